"""Draft gears that go from loading to unloading over a tiny range of stroke rates: every step is solved, and right."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from haul_ros.physics.energy import energy_balance
from haul_ros.physics.lumping import lump
from haul_ros.physics.train_model import TrainModel
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session
from tests.physics.physics_cases import linear_gear, model, slack_gear, train_of, vehicle
from tests.physics.runge_kutta import Brakes, explicit_run

Floats = NDArray[np.float64]

SPEEDS = 10.0 + np.array([0.06, -0.07, 0.32, 0.05, -0.27])

CASES = [
    # masses, loading and unloading [N/m], transition speed, time step
    ([100e3] * 5, 3e7, 3e6, 1e-4, 0.1),
    ([100e3, 100e3, 20e3, 100e3, 100e3], 3e8, 1e3, 1e-4, 5e-3),
    ([100e3, 100e3, 100.0, 100e3, 100e3], 3e7, 1e3, 1e-3, 0.1),
]


def _relative_energy(train: TrainModel) -> float:
    """Kinetic energy in the frame of the centre of mass [J]."""
    mass, velocity = train.train.mass_parameters.mass, train.train.masses.velocity
    return float(0.5 * mass @ (velocity - mass @ velocity / np.sum(mass)) ** 2)


@pytest.mark.parametrize(("masses", "loading", "unloading", "transition_speed", "time_step"), CASES)
def test_free_bodies_that_meet_on_a_fast_hysteresis_lose_energy_and_no_momentum(
    masses: list[float], loading: float, unloading: float, transition_speed: float, time_step: float
) -> None:
    gear = slack_gear(linear_gear(loading, unloading, transition_speed), 0.01)
    train = model(train_of([vehicle(m) for m in masses], gear), SPEEDS, time_step=time_step)
    energies = [_relative_energy(train)]
    for _ in range(40):
        train.advance(1)
        energies.append(_relative_energy(train) + energy_balance(train).gear_stored)
    statistics = train.statistics()
    assert statistics.unconverged_steps == 0
    assert energy_balance(train).fault is None
    assert np.max(np.diff(energies)) < 1e-9 * energies[0]
    assert energies[-1] < 0.5 * energies[0]
    momentum = np.array(masses) @ train.train.masses.velocity
    assert momentum == pytest.approx(np.array(masses) @ SPEEDS, rel=1e-12)


@pytest.mark.parametrize("time_step", [1e-3, 5e-3])
def test_peaks_on_a_fast_hysteresis_are_those_of_explicit_runge_kutta_steps(time_step: float) -> None:
    # Explicit steps have to be shorter than Ve m / 2 d, some 1e-5 s here.
    gear = slack_gear(linear_gear(3e7, 3e6, 1e-4), 0.01)
    consist = train_of([vehicle()] * 5, gear)
    train = model(consist, SPEEDS, time_step=time_step)
    train.advance(round(1.0 / time_step))
    none = Brakes(np.zeros(5), np.zeros(5), 1.0)
    reference = explicit_run(lump(consist).mass, lump(consist).gears, none, SPEEDS.copy(), 1e-6, 1.0)
    found = (train.extremes().compression, train.extremes().tension)
    assert train.statistics().unconverged_steps == 0
    for of_train, expected in zip(found, reference, strict=True):
        assert of_train == pytest.approx(expected, rel=5e-3, abs=5e-4 * float(np.max(reference)))


def test_a_long_train_of_mt_2_gears_with_a_fast_transition_comes_out_the_same_at_20_ms_as_at_1_ms() -> None:
    peaks = []
    for time_step in (1, 20):
        changes = {
            "coupler": "MT-2",
            "couplers.MT-2.transition_speed_mps": 1e-4,
            "time_step_ms": time_step,
            "sample_rate_hz": 10,
            "max_duration_s": 12,
        }
        session = Session(load_scenario("daqin_1_1_0", changes), play_commands=True)
        while not session.finished:
            session.advance()
        assert session.status().solver.unconverged_steps == 0
        assert session.energy().fault is None
        peaks.append(np.max(session.extremes().compression))
    assert peaks[1] == pytest.approx(peaks[0], rel=1e-3)
