"""Standing trains: held by friction, at rest without creeping, started by more than it can hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from haul_ros.model.track import Track
from haul_ros.physics.energy import energy_balance
from haul_ros.physics.kernel.newmark import CAPTURE_SPEED
from haul_ros.physics.train_model import NEWTON_TOLERANCE, TrainModel, WaveKind
from haul_ros.scenario import load_scenario
from tests.physics.physics_cases import (
    WAGON_RESISTANCE,
    G,
    assert_converged,
    brake_system,
    gear_forces,
    linear_gear,
    model,
    train_of,
    vehicle,
    wagon_resistance,
)

WAGON = vehicle(resistance=WAGON_RESISTANCE, tractive_effort=760e3)
GEAR = linear_gear(3e7, 9e6)
N = 10


def _train(grade: float = 0.0, speed: float = 0.0) -> TrainModel:
    track = Track(0.0, ((-1e5, grade),)) if grade else None
    return model(train_of([WAGON] * N, GEAR), speed, track=track)


def _stop(train: TrainModel) -> None:
    train.start_wave(train.time, 0, WaveKind.EMERGENCY)
    for _ in range(60_000):
        train.advance(1)
        if train.at_standstill:
            return
    raise AssertionError("the train has not stopped")


@pytest.mark.parametrize("grade", [0.0, 0.02, -0.02])
def test_a_braked_train_comes_to_rest_and_stays_there(grade: float) -> None:
    # The brakes bring up 60 kN a wagon, 61 per mille of its weight: they hold it on 20 per mille either way.
    train = _train(grade, speed=8.0)
    _stop(train)
    place, stop = train.sample(), train.stop_time
    assert stop == pytest.approx(train.time, abs=1e-9)
    train.advance(60_000)
    np.testing.assert_array_equal(train.sample().chainage, place.chainage)
    np.testing.assert_array_equal(train.speed, 0.0)
    assert train.at_standstill
    assert train.stop_time == stop
    assert train.statistics().unconverged_steps == 0


@pytest.mark.parametrize("speed", [5.0, -5.0])
def test_a_stopping_train_never_runs_back(speed: float) -> None:
    train = _train(speed=speed)
    train.start_wave(0.0, 0, WaveKind.EMERGENCY)
    back = 0.0
    moved_after_rest = np.zeros(N)
    for _ in range(20_000):
        before = train.speed
        train.advance(1)
        back = min(back, float(np.min(train.speed * np.sign(speed))))
        moved_after_rest = np.maximum(moved_after_rest, np.where(before == 0.0, np.abs(train.speed), 0.0))
    assert train.at_standstill
    # Compressed couplers may push a wagon that stands, but against the brakes of 60 kN never backwards here.
    assert back == 0.0


def test_couplers_of_a_standing_train_keep_the_force_that_their_stroke_has_at_rest() -> None:
    train = _train(speed=8.0)
    _stop(train)
    sample = train.sample()
    np.testing.assert_array_equal(sample.stroke_rate, 0.0)
    assert np.max(np.abs(sample.coupler_force)) > 100.0
    np.testing.assert_allclose(sample.coupler_force, gear_forces(GEAR, sample), rtol=1e-9)
    # Every wagon is in equilibrium, and friction gives no more than it can.
    push = np.append(sample.coupler_force, 0.0) - np.insert(sample.coupler_force, 0, 0.0)
    available = 60e3 + 100e3 * G * 3.5e-3
    assert np.all(np.abs(push) <= available)
    np.testing.assert_array_equal(sample.brake_force * push >= 0.0, True)
    assert np.all(np.abs(sample.brake_force) <= np.abs(push) + 1e-6)


def test_wagons_go_on_relaxing_after_others_have_stopped() -> None:
    # The last wagon runs into the train and comes to rest long after those at the head never moved.
    train = model(train_of([WAGON] * N, GEAR), np.array([0.0] * (N - 1) + [1.5]))
    train.advance(10)
    assert not train.at_standstill
    np.testing.assert_array_equal(train.speed[: N - 3], 0.0)
    while not train.at_standstill:
        train.advance(10)
    assert train.displacement[N - 2] > 0.0
    assert abs(energy_balance(train).relative_imbalance) < 1e-9


def test_a_train_that_its_brakes_cannot_hold_rolls_down_the_grade() -> None:
    # 80 per mille against 61 per mille of brake and 3.5 of starting resistance.
    train = _train(grade=0.08)
    train.start_wave(0.0, 0, WaveKind.EMERGENCY)
    train.advance(20_000)
    assert not train.at_standstill
    expected = -G * (0.08 - 0.6 / G - wagon_resistance(float(np.mean(train.speed))))
    assert float(np.mean(train.acceleration)) == pytest.approx(expected, rel=1e-4)
    assert np.all(train.speed < -1.0)


@pytest.mark.parametrize(("grade", "rolls"), [(3.4e-3, False), (-3.4e-3, False), (3.6e-3, True), (-3.6e-3, True)])
def test_an_unbraked_train_starts_on_a_grade_above_its_starting_resistance(grade: float, rolls: bool) -> None:
    train = _train(grade)
    train.advance(3000)
    assert train.at_standstill is not rolls
    if rolls:
        assert np.all(np.sign(train.speed) == -np.sign(grade))
        np.testing.assert_allclose(np.abs(train.acceleration), G * (3.6e-3 - wagon_resistance(0.0)), rtol=1e-6)


@pytest.mark.interpreted
@pytest.mark.parametrize(("share", "starts"), [(0.99, False), (1.01, True)])
def test_a_standing_wagon_starts_when_traction_exceeds_its_starting_resistance(share: float, starts: bool) -> None:
    train = model(train_of([WAGON], GEAR), 0.0)
    train.advance(100)
    train.set_traction(0, share * 3.5e-3 * 100e3 * G)
    train.advance(1000)
    assert bool(train.speed[0] > 0.0) is starts
    if starts:
        # Once it moves, running resistance takes the place of the starting one.
        expected = (share * 3.5e-3 - wagon_resistance(0.0)) * G
        assert train.acceleration[0] == pytest.approx(expected, rel=1e-9)
        assert train.speed[0] == pytest.approx(expected * 1.0, rel=2e-3)


def test_traction_accelerates_the_train_and_its_end_lets_it_coast() -> None:
    train = model(train_of([vehicle(tractive_effort=760e3), *[vehicle()] * 3], linear_gear(3e7, 9e6)), 2.0)
    train.set_traction(0, 400e3)
    train.advance(5000)
    momentum = float(np.sum(100e3 * train.speed))
    assert momentum == pytest.approx(4 * 100e3 * 2.0 + 400e3 * 5.0, rel=1e-9)
    train.set_traction(0, 0.0)
    train.advance(5000)
    assert float(np.sum(100e3 * train.speed)) == pytest.approx(momentum, rel=1e-9)
    assert abs(energy_balance(train).relative_imbalance) < 1e-9


def test_traction_that_starts_the_head_but_cannot_keep_the_train_in_motion_stretches_couplers_and_is_held() -> None:
    train = _train()
    train.set_traction(0, 1.2 * 3.5e-3 * 100e3 * G)
    train.advance(30_000)
    assert train.at_standstill
    assert train.displacement[0] > 0.0
    assert train.displacement[-1] == 0.0
    assert train.sample().coupler_force[0] < 0.0  # draft


@pytest.mark.interpreted
def test_a_train_that_never_moved_has_stopped_at_time_zero() -> None:
    train = _train()
    assert train.at_standstill
    assert train.stop_time == 0.0
    train.advance(1000)
    assert train.stop_time == 0.0


@settings(deadline=None, max_examples=20)
@given(
    speeds=st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=6),
    braked=st.booleans(),
)
@example(speeds=[1.125, 0.0, 0.0, -1.75], braked=True)  # arrested under a push that grows beyond what friction holds
def test_brakes_and_resistance_take_energy_and_never_push_along(speeds: list[float], braked: bool) -> None:
    train = model(train_of([WAGON] * len(speeds), GEAR), np.array(speeds))
    if braked:
        train.start_wave(0.3, 0, WaveKind.EMERGENCY)
    brake_work = resistance_work = 0.0
    path = float(np.sum(np.abs(speeds))) * 0.01
    for _ in range(150):
        train.advance(10)
        sample = train.sample()
        path += float(np.sum(np.abs(sample.speed))) * 0.01
        assert np.all(sample.brake_force * sample.speed >= 0.0)
        assert np.all(np.abs(sample.brake_force) <= 60e3 * (1.0 + 1e-9))
        balance = energy_balance(train)
        assert balance.brake_work >= brake_work - 1e-9 * balance.kinetic_start
        assert balance.resistance_work >= resistance_work - 1e-9 * balance.kinetic_start
        # What the balance may leave over is the Newton residual times the way, and rounding.
        assert abs(balance.imbalance) <= NEWTON_TOLERANCE * path + 1e-12 * balance.kinetic_start
        brake_work, resistance_work = balance.brake_work, balance.resistance_work


def test_when_a_train_with_slack_comes_to_rest_does_not_depend_on_the_time_step() -> None:
    # The last of ten wagons runs into the others. Held by resistance alone, masses creep for long before they stand.
    gear = replace(GEAR, slack=0.02)
    stops = []
    for time_step in (2e-3, 1e-3, 5e-4, 2.5e-4):
        train = model(train_of([WAGON] * N, gear), np.array([0.0] * (N - 1) + [0.3]), time_step=time_step)
        while not train.at_standstill:
            train.advance(100)
        stops.append(train.stop_time)
    np.testing.assert_allclose(stops, stops[-1], rtol=0.0, atol=3e-3)


@pytest.mark.interpreted
def test_a_creeping_mass_without_friction_is_not_arrested() -> None:
    train = model(train_of([vehicle()], None), 0.9 * CAPTURE_SPEED)
    train.advance(100)
    assert train.speed[0] == pytest.approx(0.9 * CAPTURE_SPEED, rel=1e-6)


@pytest.mark.parametrize("time_step", [4e-3, 1e-3, 2.5e-4])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_wagon_that_breaks_loose_slips_until_friction_has_stopped_it(time_step: float, sense: float) -> None:
    """A wagon on a spring that is just stronger than what holds it, against the closed form of stick and slip.

    Sliding, it is held by F_k alone, less than F_s at rest: it swings about F_k and stands where the spring is at
    F_k - (F_s - F_k), with (F_s - F_k) / sqrt(k m) on the way. That it is slow at first is no standstill.
    """
    stiffness, mass = 30e6, 100e3
    at_rest, sliding = 3.5e-3 * mass * G, wagon_resistance(0.0) * mass * G
    heavy, wagon = (vehicle(m, resistance=WAGON_RESISTANCE) for m in (1e9, mass))
    stroke = sense * at_rest * (1.0 + 1e-6) / stiffness
    train = TrainModel(
        train_of([heavy, wagon], linear_gear(stiffness, stiffness)),
        brake_system(),
        initial_speed=0.0,
        initial_stroke=stroke,
        time_step=time_step,
    )
    fastest = 0.0
    for _ in range(round(0.5 / time_step)):
        train.advance(1)
        fastest = max(fastest, -sense * float(train.speed[1]))
    slips = at_rest - sliding
    assert fastest == pytest.approx(slips / np.sqrt(stiffness * mass), rel=5e-3)
    assert train.at_standstill
    # CAPTURE_SPEED ends the slip early, by this part of it.
    early = 1.0 - np.sqrt(1.0 - (CAPTURE_SPEED / fastest) ** 2)
    assert sense * train.sample().coupler_force[0] == pytest.approx(sliding - slips, abs=(early + 0.01) * slips)


def test_a_heavy_rigid_train_converges_at_a_short_step_to_what_rounding_allows() -> None:
    # 20 000 t at 22 m/s and 0.05 ms: velocities are rounded to 3.6e-15 m/s, which is 1.4 mN.
    train = model(train_of([vehicle(20e6, resistance=WAGON_RESISTANCE)], None), 22.0, time_step=5e-5)
    train.start_wave(0.0, 0, WaveKind.EMERGENCY)
    train.advance(60_000)
    assert_converged(train)
    assert train.statistics().newton_iterations_max <= 2


def test_the_instant_at_which_a_train_with_slack_stands_is_no_more_exact_than_its_speeds_at_the_start() -> None:
    """Stop times at different time steps differ by up to 0.1 s without a trend: it is no error of the step.

    The last wagons rattle to and fro in their slack before they stand. At one and the same step speeds at the start
    that differ by 1 nm/s scatter the stop as much as other steps do, while the largest forces stay what they are.
    """
    scenario = load_scenario("validation_ss3_c63", {"couplers.paper_set_b.slack_mm": 20})
    stops, peaks = [], []
    for seed in range(5):
        random = np.random.default_rng(seed)
        speed = scenario.initial_speed + 1e-9 * random.standard_normal(len(scenario.consist.vehicles))
        train = TrainModel(scenario.consist, scenario.brakes, scenario.track, initial_speed=speed, time_step=1e-3)
        train.start_wave(0.0, 0, WaveKind.EMERGENCY)
        while not train.at_standstill:
            train.advance(100)
        stops.append(train.stop_time)
        peaks.append(float(np.max(train.extremes().compression)))
    assert 0.01 < max(stops) - min(stops) < 0.2
    assert max(peaks) / min(peaks) - 1.0 < 1e-6
