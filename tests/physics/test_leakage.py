"""Leakage of the whole brake pipe: the rate that is asked for, and what rules allow (49 CFR 232.207)."""

from __future__ import annotations

import numpy as np
import pytest

from haul_ros.model.air_brake import ATMOSPHERE, PneumaticBrake
from haul_ros.physics.train_model import TrainModel
from haul_ros.scenario import load_scenario
from tests.physics.air_cases import GAS, INERT, air_train, cylinder, locomotives_of, pipe

PSI = 6894.76
CUBIC_FOOT = 0.0283168


def test_a_pipe_that_nothing_feeds_falls_everywhere_as_a_choked_leak_lets_it() -> None:
    """dp/dt = -rate p/p0 with absolute pressures, and no flow along the pipe, whatever lengths its vehicles have."""
    train = air_train(20, locomotives=(0, 7), wagon_valve=INERT, locomotive_valve=INERT, driver={"feed_bore": 0.0})
    charged, rate = 500e3 + ATMOSPHERE, 30e3 / 60.0
    train.set_leakage(rate)
    train.advance(30_000)
    expected = charged * np.exp(-rate * 60.0 / charged) - ATMOSPHERE
    assert pipe(train) == pytest.approx(np.full(22, expected), rel=1e-5)
    assert np.abs(train.train.air_state.flow).max() < 1e-12
    assert train.air_error < 1e-12


def test_150_cars_leaking_5_psi_a_minute_pass_what_the_rules_ask() -> None:
    """The tail within 15 psi and at 75 or more, a flow of at most 60 CFM; after 15 psi, 5 psi/min times p/p0."""
    scenario = load_scenario("aar_unit_train", {"commands": [], "consist.1.count": 150, "time_step_ms": 2})
    assert isinstance(scenario.brakes, PneumaticBrake)
    train = TrainModel(scenario.consist, scenario.brakes, initial_speed=0.0, time_step=2e-3)
    train.set_leakage(5.0 * PSI / 60.0)
    train.advance(90_000)
    before = float(train.train.air_account[0].fed)
    train.advance(15_000)
    flow = (float(train.train.air_account[0].fed) - before) / 30.0 * GAS / ATMOSPHERE
    volume = float(np.sum(train.train.air_parameters.pipe_volume))
    assert flow == pytest.approx(5.0 * PSI / 60.0 * volume / ATMOSPHERE, rel=0.03)  # the pressure is a little lower
    assert flow * 60.0 / CUBIC_FOOT < 60.0
    head, lowest = pipe(train)[0] / PSI, pipe(train).min() / PSI
    assert head - lowest < 15.0
    assert lowest > 75.0
    assert cylinder(train).max() < 1e3
    brake = scenario.brakes
    for vehicle in locomotives_of(train):
        demand = (15.0 * PSI - brake.least_reduction) / (brake.full_reduction - brake.least_reduction)
        train.set_brake_valve(vehicle, demand)
    train.advance(45_000)
    applied = float(pipe(train)[75])
    train.advance(30_000)
    fall = (applied - float(pipe(train)[75])) / PSI
    assert fall == pytest.approx(5.0 * (applied + ATMOSPHERE) / (brake.pressure + ATMOSPHERE), rel=0.05)
