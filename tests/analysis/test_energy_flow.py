"""Energies from samples: by hand, and against the simulation's own balance."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from haul_ros.analysis.energy_flow import GearWork, Height, TrainWork, work
from haul_ros.model.scenario import Scenario
from haul_ros.model.track import Track
from haul_ros.recording.reader import Recording
from haul_ros.units import GRAVITY

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun


def test_work_of_a_gear_pressed_in_and_let_out_is_the_area_of_its_loop() -> None:
    # In to 10 mm on a straight line up to 300 kN (1500 J), out on one from 100 kN to 0 (500 J given back)
    stroke = np.array([[0.0], [0.010], [0.010], [0.0]])
    force = np.array([[0.0], [300e3], [100e3], [0.0]])
    assert work(force, stroke) == pytest.approx([1000.0])

    for cut in range(5):
        gears = GearWork(1)
        gears.add(force[:cut], stroke[:cut])
        gears.add(force[cut:], stroke[cut:])
        assert gears.taken == pytest.approx([1000.0])


def test_height_of_a_line_with_and_without_vertical_curves() -> None:
    # 10 per mille up from 100 m to 300 m, level behind
    grades = ((100.0, 0.010), (300.0, 0.0))
    chainage = np.array([0.0, 100.0, 200.0, 300.0, 500.0])

    assert Height(Track(grades=grades)).at(chainage) == pytest.approx([0.0, 0.0, 1.0, 2.0, 2.0])
    # A ramp of 40 m: in the middle of it 20^2/(2 40) 0.01 = 0.05 m, behind it as without
    curved = Height(Track(grades=grades, grade_ramp=40.0))
    assert curved.at(chainage) == pytest.approx([0.0, 0.05, 1.0, 1.95, 2.0])


def test_the_balance_from_samples_comes_to_the_simulations_own(scenario: Scenario, run: "RecordedRun") -> None:
    consist = scenario.consist
    gears, train = GearWork(len(consist.couplers)), TrainWork(consist, scenario.track)
    with Recording(run.path) as recording:
        for couplers, vehicles, _ in recording.blocks():
            gears.add(couplers.force, couplers.stroke)
            none = np.zeros_like(vehicles.speed)
            train.add(vehicles.chainage, vehicles.speed, vehicles.brake_force, none)
    sampled, own = train.energy(gears), run.session.energy()

    assert sampled.kinetic_start == pytest.approx(own.kinetic_start, rel=1e-12)
    assert sampled.kinetic == pytest.approx(own.kinetic, abs=1.0)
    assert sampled.brake_work == pytest.approx(own.brake_work, rel=1e-3)
    assert sampled.resistance_work == pytest.approx(own.resistance_work, rel=1e-3)
    assert sampled.gear_stored == pytest.approx(own.gear_stored, abs=1.0)
    assert sampled.gear_dissipated == pytest.approx(own.gear_dissipated, rel=0.05)
    assert abs(sampled.relative_imbalance) < 1e-3


def test_a_train_on_a_grade_by_hand(scenario: Scenario) -> None:
    # One wagon of 100 t at 10 m/s up 10 per mille through a curve of R = 600 m for 100 m, pulled with 50 kN
    wagon = scenario.consist.vehicles[1]
    law = replace(wagon.resistance, constant=0.001, linear=0.0, quadratic=0.0)
    consist = replace(
        scenario.consist, vehicles=(replace(wagon, mass=100e3, resistance=law),), couplers=(), locomotives=()
    )
    train = TrainWork(consist, Track(grades=((0.0, 0.010),), curves=((0.0, 1.0 / 600.0),)))
    at = np.array([[0.0], [50.0], [100.0]])
    speed, effort = np.full((3, 1), 10.0), np.full((3, 1), 50e3)
    train.add(at[:2], speed[:2], np.zeros((2, 1)), effort[:2])
    train.add(at[2:], speed[2:], np.zeros((1, 1)), effort[2:])
    energy = train.energy(GearWork(0))

    weight = 100e3 * GRAVITY
    assert energy.kinetic == energy.kinetic_start == 5e6
    assert energy.gravity_work == pytest.approx(-weight * 1.0)
    assert energy.resistance_work == pytest.approx(weight * (0.001 + 0.001) * 100.0)  # 600/R = 1 N/kN
    assert energy.traction_work == pytest.approx(5e6)
    assert energy.imbalance == pytest.approx(weight * (1.0 + 0.2) - 5e6)
