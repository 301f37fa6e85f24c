"""The brake pipe and its orifices against closed forms and an integration that shares no code with them."""

from __future__ import annotations

import numpy as np
import pytest

from haul_ros.model.air_brake import ATMOSPHERE
from haul_ros.physics.air_assembly import total_air
from haul_ros.physics.train_model import TrainModel
from tests.physics.air_cases import CHOKED, GAS, INERT, SOUND, air_train, effective, locomotives_of, pipe
from tests.physics.godunov import OpenPipe


def _air(train: TrainModel) -> float:
    """All air in the train and its main reservoirs, less what has come in and gone out [kg]."""
    arrays, account = train.train, train.train.air_account[0]
    reservoirs = arrays.driver_valves.main_reservoir * arrays.driver_valve_parameters.reservoir_volume
    inside = total_air(arrays.air_parameters, arrays.air_state, GAS) + float(reservoirs.sum()) / GAS
    return float(inside + account.vented - account.compressed)


def test_no_air_is_lost_or_made_whatever_the_valves_do() -> None:
    train = air_train(30, locomotives=(0, 15))
    rng = np.random.default_rng(7)
    before = _air(train)
    train.set_hole(20, effective(2e-3))
    for _ in range(40):
        vehicle = int(rng.choice(locomotives_of(train)))
        if rng.random() < 0.15:
            train.set_emergency_valve(vehicle)
        else:
            train.set_brake_valve(vehicle, float(rng.choice((0.0, 0.1, 0.5, 1.0))))
        if rng.random() < 0.2:
            train.set_cock(int(rng.integers(31)), is_open=rng.random() < 0.7)
        train.advance(int(rng.integers(200, 3000)))
    account = train.train.air_account[0]
    assert account.vented > 1.0  # more than the train has held at once has gone through it
    assert account.compressed > 0.1
    assert account.fed > 1.0
    assert _air(train) == pytest.approx(before, rel=1e-12)


def test_a_charged_train_without_leaks_keeps_every_pressure_to_the_bit() -> None:
    train = air_train(20, locomotives=(0, 20))
    before = train.train.air_state.pipe.copy(), train.train.air_state.auxiliary.copy()
    train.advance(30_000)
    assert (train.train.air_state.pipe == before[0]).all()
    assert (train.train.air_state.auxiliary == before[1]).all()
    assert not train.train.air_state.cylinder_air.std() > 0.0 or (train.train.air_state.cylinder == ATMOSPHERE).all()


def test_a_small_step_of_pressure_runs_at_the_speed_of_sound() -> None:
    train = air_train(
        200, wagon_valve=INERT, locomotive_valve=INERT, pipe={"friction_factor": 0.0, "branch_volume": 0.0}
    )
    state, lengths = train.train.air_state, train.train.air_parameters.face_length
    state.pipe[:60] += 1e3
    distance = np.concatenate(([0.0], np.cumsum(lengths[:-1])))
    train.set_cock(0, is_open=False)  # the locomotive is out of it
    step = distance[59] + 0.5 * lengths[59]
    crossed: dict[int, float] = {}
    while len(crossed) < 2:
        train.advance(1)
        for vehicle in (100, 160):
            if vehicle not in crossed and state.pipe[vehicle] > state.pipe[-1] + 250.0:
                crossed[vehicle] = train.time
    speed = (distance[160] - distance[100]) / (crossed[160] - crossed[100])
    assert speed == pytest.approx(SOUND, rel=0.01)
    assert (distance[160] - step) / crossed[160] == pytest.approx(SOUND, rel=0.01)


def test_a_steady_leak_at_the_tail_makes_the_profile_of_friction() -> None:
    bore, friction = 0.035, 0.03
    train = air_train(60, wagon_valve=INERT, locomotive_valve=INERT, driver={"compressor_on": 899e3})
    train.set_hole(60, effective(6e-3))
    train.advance(150_000)
    state, lengths = train.train.air_state, train.train.air_parameters.face_length[:-1]
    flow = state.flow[:-1]
    assert flow == pytest.approx(np.full(60, flow.mean()), rel=5e-4)
    assert flow.mean() == pytest.approx(CHOKED * effective(6e-3) * state.pipe[-1] / SOUND, rel=1e-4)
    reynolds = flow.mean() / (np.pi / 4.0 * bore * 1.81e-5)
    assert reynolds > 2300.0
    # d(p^2)/dx = -f R T G |G| / (D A^2), the flow being far below the speed of sound
    area = np.pi / 4.0 * bore**2
    fall = friction * GAS * flow.mean() ** 2 * np.sum(lengths[1:]) / (bore * area**2)
    assert state.pipe[1] ** 2 - state.pipe[-1] ** 2 == pytest.approx(fall, rel=5e-3)


def test_a_laminar_leak_makes_the_profile_of_hagen_and_poiseuille() -> None:
    bore = 0.035
    train = air_train(60, wagon_valve=INERT, locomotive_valve=INERT)
    train.set_hole(60, effective(0.8e-3))
    train.advance(400_000)
    state, lengths = train.train.air_state, train.train.air_parameters.face_length[:-1]
    flow = float(state.flow[:-1].mean())
    assert flow / (np.pi / 4.0 * bore * 1.81e-5) < 2300.0
    fall = 128.0 * 1.81e-5 * flow * np.sum(lengths[1:]) / (np.pi * bore**4) * 2.0 * GAS
    assert state.pipe[1] ** 2 - state.pipe[-1] ** 2 == pytest.approx(fall, rel=2e-2)


def test_nothing_goes_through_a_closed_cock() -> None:
    train = air_train(20)
    train.set_cock(10, is_open=False)
    before = train.train.air_state.pipe[11:].copy()
    train.set_emergency_valve(0)
    train.advance(10_000)
    assert (train.train.air_state.pipe[11:] == before).all()
    assert pipe(train)[:11].max() < 1e3


@pytest.mark.parametrize("kind", ["emergency", "service"])
def test_a_symmetric_train_stays_symmetric(kind: str) -> None:
    train = air_train(40, locomotives=(0, 20, 20, 40))
    for vehicle in locomotives_of(train):
        if kind == "emergency":
            train.set_emergency_valve(vehicle)
        else:
            train.set_brake_valve(vehicle, 1.0)
    train.advance(3_000)
    state = train.train.air_state
    for pressure in (state.pipe, state.auxiliary, state.cylinder):
        assert pressure == pytest.approx(pressure[::-1], rel=1e-9)
    assert state.cylinder.max() > ATMOSPHERE + 20e3


def test_the_result_approaches_its_limit_with_the_first_power_of_the_step() -> None:
    def pressures(step: float) -> float:
        train = air_train(60, time_step=step, step=step, wagon_valve=INERT, locomotive_valve=INERT)
        train.set_emergency_valve(0)
        train.advance(round(1.2 / step))
        return float(pipe(train)[:40].mean())

    exact = pressures(0.0625e-3)
    errors = [abs(pressures(step) - exact) for step in (4e-3, 2e-3, 1e-3, 0.5e-3)]
    order = np.polyfit(np.log([4.0, 2.0, 1.0, 0.5]), np.log(errors), 1)[0]
    assert 0.9 < order < 1.2


def test_a_pipe_that_is_opened_empties_as_a_godunov_scheme_says() -> None:
    """Isothermal Euler equations by a Riemann solver on a mesh six times as fine, written apart from the kernel."""
    closed = {"feed_bore": 0.0, "exhaust_bore": 0.0, "emergency_difference": np.inf}
    train = air_train(40, wagon_valve=INERT, locomotive_valve=INERT, pipe={"branch_volume": 0.0}, driver=closed)
    parameters, state = train.train.air_parameters, train.train.air_state
    lengths = parameters.pipe_volume / (np.pi / 4.0 * 0.035**2)
    area = effective(0.016)
    reference = OpenPipe(lengths, bore=0.035, friction=0.03, pressure=float(state.pipe[0]), hole=area, refinement=6)
    train.set_hole(0, area)
    for seconds in (0.5, 1.0, 2.0, 4.0):
        train.advance(round((seconds - train.time) / train.time_step))
        expected = reference.pressures_at(seconds)
        assert state.pipe[1:] == pytest.approx(expected[1:], abs=0.01 * 6e5), f"at {seconds} s"
        assert state.pipe[0] == pytest.approx(expected[0], abs=0.015 * 6e5), f"at {seconds} s"  # where the hole is
    assert state.pipe[0] < 3.5e5
