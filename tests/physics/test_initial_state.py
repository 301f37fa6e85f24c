"""Trains that do not start with free couplers and charged, released brakes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from haul_ros.model.air_brake import ATMOSPHERE
from haul_ros.model.draft_gear import DraftGear
from haul_ros.model.initial_state import CouplerState, InitialAir, InitialState
from haul_ros.model.track import Track
from haul_ros.physics.air_assembly import total_air
from haul_ros.physics.energy import energy_balance
from haul_ros.physics.kernel.air_data import LAPPED, RELEASED
from haul_ros.physics.train_model import TrainModel
from haul_ros.scenario import load_scenario
from tests.physics.air_cases import GAS, air_train, cylinder, pipe
from tests.physics.physics_cases import assert_converged, brake_system, linear_gear, train_of, vehicle

SLACK = 0.02
MASS = 100e3


def loose_gear(slack: float = SLACK) -> DraftGear:
    return replace(linear_gear(2e7, 2e7), slack=slack)


def train_in(state: CouplerState, *, wagons: int = 4, speed: float = 0.0, track: Track | None = None) -> TrainModel:
    """A locomotive and wagons of 12 m and 100 t that roll freely."""
    vehicles = [vehicle(MASS, tractive_effort=600e3), *[vehicle(MASS)] * wagons]
    consist = train_of(vehicles, loose_gear())
    strokes = InitialState(state).strokes(consist)
    return TrainModel(consist, brake_system(), track, initial_speed=speed, initial_stroke=strokes)


@pytest.mark.interpreted
@pytest.mark.parametrize(
    ("state", "side"), [(CouplerState.FREE, 0.0), (CouplerState.STRETCHED, -1.0), (CouplerState.BUNCHED, 1.0)]
)
def test_vehicles_stand_where_their_couplers_put_them(state: CouplerState, side: float) -> None:
    train = train_in(state, track=Track(500.0, ((476.0, 0.01),)))
    sample = train.sample()
    np.testing.assert_array_equal(sample.stroke, np.full(4, side * SLACK / 2.0))
    # The head stands at its place; each vehicle behind it is half a slack farther back, or nearer, than the one before.
    expected = 494.0 - 12.0 * np.arange(5) + side * SLACK / 2.0 * np.arange(5)
    np.testing.assert_allclose(sample.chainage, expected, rtol=1e-14)
    np.testing.assert_array_equal(sample.coupler_force, np.zeros(4))
    # The grade begins at 476 m, between the second and the third vehicle, and each takes that of its own place.
    np.testing.assert_allclose(train.acceleration, [-9.81 * 0.01, -9.81 * 0.01, 0.0, 0.0, 0.0], rtol=1e-12)
    assert energy_balance(train).gear_stored == 0.0
    assert (train.initial_gear_energy == 0.0).all()


def test_a_bunched_train_starts_vehicle_by_vehicle() -> None:
    force, acceleration = 200e3, 200e3 / MASS
    train = train_in(CouplerState.BUNCHED)
    train.set_traction(0, force)
    taken_up = (2.0 * SLACK / acceleration) ** 0.5  # the locomotive alone goes the whole slack of its coupler
    train.advance(round((taken_up - 2e-3) / train.time_step))
    assert train.speed[0] == pytest.approx(acceleration * train.time, rel=1e-9)
    assert train.speed[1:].tolist() == [0.0] * 4
    train.advance(6)
    assert train.speed[1] > 0.0
    assert train.speed[2:].tolist() == [0.0] * 3
    assert energy_balance(train).fault is None


def test_a_stretched_train_starts_as_one_without_a_run_out() -> None:
    train = train_in(CouplerState.STRETCHED)
    train.set_traction(0, 200e3)
    train.advance(3)
    assert (train.sample().coupler_force[:1] < 0.0).all()
    assert train.speed[1] > 0.0
    train.advance(5000)
    assert_converged(train)
    balance = energy_balance(train)
    assert abs(balance.imbalance) < 1e-3 * 5 * train.displacement[0]
    # Of slack that opens again and closes, hardly any: bunched, the same train gives far larger forces.
    bunched = train_in(CouplerState.BUNCHED)
    bunched.set_traction(0, 200e3)
    bunched.advance(5000)
    assert bunched.extremes().tension.max() > 1.5 * train.extremes().tension.max()


def test_what_gears_hold_at_the_start_is_no_energy_from_nowhere() -> None:
    stiffness, stroke = 2e7, 0.015
    consist = train_of([vehicle(MASS)] * 2, linear_gear(stiffness, stiffness))
    train = TrainModel(consist, brake_system(), initial_speed=0.0, initial_stroke=stroke, time_step=1e-4)
    stored = 0.5 * stiffness * stroke**2
    assert train.initial_gear_energy == pytest.approx(stored, rel=1e-12)
    assert train.sample().coupler_force[0] == pytest.approx(stiffness * stroke, rel=1e-12)
    assert energy_balance(train).gear_stored == 0.0
    quarter = np.pi / 2.0 * (MASS / 2.0 / stiffness) ** 0.5
    train.advance(round(quarter / train.time_step))
    balance = energy_balance(train)
    assert train.kinetic_energy == pytest.approx(stored, rel=1e-4)
    assert balance.gear_stored == pytest.approx(-stored, rel=1e-4)
    assert abs(balance.imbalance) < 1e-6 * stored
    assert balance.fault is None
    # A fault is still one: what is missing is measured against what the gears gave.
    assert replace(balance, kinetic=balance.kinetic + 1e-3 * stored).fault is not None


# -- air ----------------------------------------------------------------------------------------

AIR = InitialAir(pipe=440e3, auxiliary=440e3, cylinder=150e3)


def air_started(initial: InitialAir | None, *, speed: float = 0.0, scenario: str = "daqin_1_1_0") -> TrainModel:
    base = air_train(20) if scenario == "daqin_1_1_0" else None
    if base is not None:
        shipped = load_scenario("daqin_1_2_1_pneumatic").brakes
        consist = base.consist
    else:
        loaded = load_scenario(scenario)
        shipped, consist = loaded.brakes, loaded.consist
    return TrainModel(consist, shipped, initial_speed=speed, initial_air=initial, time_step=2e-3)


@pytest.mark.parametrize("scenario", ["daqin_1_1_0", "uic_freight", "aar_unit_train"])
def test_a_lapped_train_holds_its_pressures(scenario: str) -> None:
    train = air_started(AIR, scenario=scenario)
    assert (train.train.air_state.position == LAPPED).all()
    before = [cylinder(train), pipe(train), train.train.air_state.auxiliary.copy()]
    np.testing.assert_allclose(before[1], 440e3, rtol=1e-12)
    assert (before[0] > 140e3).any()
    train.advance(5000)
    after = [cylinder(train), pipe(train), train.train.air_state.auxiliary.copy()]
    np.testing.assert_allclose(after, before, rtol=1e-9, atol=1.0)
    assert (train.train.air_state.position != RELEASED).all()
    assert train.train.air_account[0].fed == 0.0


def test_the_air_of_the_start_is_that_of_the_volumes() -> None:
    train = air_started(AIR)
    parameters, state = train.train.air_parameters, train.train.air_state
    assert AIR.cylinder > parameters.cylinder_spring.max()  # pistons out
    volumes = parameters.pipe_volume + parameters.accelerated_volume + parameters.emergency_volume
    by_hand = (
        (AIR.pipe + ATMOSPHERE) * volumes.sum()
        + (AIR.auxiliary + ATMOSPHERE) * parameters.auxiliary_volume[parameters.from_main_reservoir == 0.0].sum()
        + ATMOSPHERE * parameters.bulb_volume.sum()
        + (AIR.cylinder + ATMOSPHERE) * (parameters.cylinder_clearance + parameters.cylinder_displaced).sum()
    ) / GAS
    assert total_air(parameters, state, float(train.train.air[0].gas)) == pytest.approx(by_hand, rel=1e-6)


def test_the_brakes_act_from_the_first_instant() -> None:
    speed = 15.0
    train = air_started(AIR, speed=speed)
    sample = train.sample()
    np.testing.assert_allclose(sample.cylinder_pressure, AIR.cylinder, rtol=1e-12)
    for vehicle_type, force in zip(train.consist.vehicles, sample.brake_force, strict=True):
        shoe_force = vehicle_type.shoe_force * AIR.cylinder / vehicle_type.cylinder_pressure
        friction = vehicle_type.friction.coefficient(shoe_force, speed, speed)
        assert force == pytest.approx(vehicle_type.shoes * shoe_force * friction, rel=1e-9)
    train.advance(1)
    np.testing.assert_allclose(train.sample().brake_force, sample.brake_force, rtol=1e-3)
    train.advance(2000)
    assert energy_balance(train).fault is None


def test_a_driver_releases_what_was_applied_at_the_start() -> None:
    train = air_started(AIR)
    demand = train.initial_demand
    assert 0.0 < demand < 1.0
    brakes = train.pneumatic
    assert brakes is not None
    assert brakes.pressure_for(demand) == pytest.approx(AIR.pipe)
    train.set_brake_valve(0, 0.0)
    train.advance(30_000)
    assert cylinder(train).max() < 2e3
    assert pipe(train).min() > brakes.pressure - 10e3


def test_a_train_that_is_not_charged_is_charged() -> None:
    train = air_started(InitialAir(pipe=400e3, auxiliary=300e3, cylinder=0.0))
    assert (train.train.air_state.position == RELEASED).all()
    assert train.initial_demand == 0.0
    own = train.train.air_parameters.from_main_reservoir == 0.0
    np.testing.assert_allclose(train.train.air_state.auxiliary[own], 300e3 + ATMOSPHERE)
    train.advance(60_000)
    assert pipe(train).min() > 480e3
    assert train.train.air_state.auxiliary.min() > 400e3 + ATMOSPHERE
    assert cylinder(train).max() == 0.0


def test_charged_pressures_are_the_start_without_any() -> None:
    charged = air_started(InitialAir(500e3, 500e3, 0.0))
    for given, default in zip(charged.train.air_state, air_started(None).train.air_state, strict=True):
        np.testing.assert_array_equal(given, default)
