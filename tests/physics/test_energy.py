"""Energy balance and convergence of whole stops of the shipped trains."""

from __future__ import annotations

import pytest

from haul_ros.model.track import Track
from haul_ros.physics.energy import EnergyBalance, energy_balance
from haul_ros.physics.train_model import TrainModel, WaveKind
from haul_ros.resources import shipped_scenarios
from haul_ros.scenario.loader import load_scenario
from tests.physics.physics_cases import (
    WAGON_RESISTANCE,
    assert_converged,
    brake_system,
    linear_gear,
    model,
    train_of,
    vehicle,
)


@pytest.mark.parametrize("name", shipped_scenarios())
def test_the_energy_of_an_emergency_stop_balances_and_newton_converges_at_every_step(name: str) -> None:
    scenario = load_scenario(name)
    train = TrainModel(
        scenario.consist,
        scenario.brakes,
        scenario.track,
        initial_speed=scenario.initial_speed,
        time_step=scenario.time_step,
    )
    for locomotive in scenario.consist.locomotives:
        if train.pneumatic is not None:
            train.set_emergency_valve(locomotive.vehicle)
        else:
            train.start_wave(0.0, locomotive.vehicle, WaveKind.EMERGENCY)
    while not train.at_standstill:
        train.advance(1000)
    balance = energy_balance(train)
    assert balance.kinetic_start == pytest.approx(0.5 * scenario.consist.mass * scenario.initial_speed**2)
    assert balance.kinetic == 0.0
    assert abs(balance.relative_imbalance) < 1e-9
    # The parts are what they should be: brakes do nearly all of it, resistance some, gears a little.
    given = balance.kinetic_start + balance.gravity_work
    assert 0.75 < balance.brake_work / given < 0.99
    assert 0.01 < balance.resistance_work / given < 0.25
    assert balance.gear_dissipated > 0.0
    assert balance.gear_stored >= 0.0
    assert_converged(train)
    assert train.statistics().newton_iterations_max <= 5


def test_traction_and_gravity_enter_the_balance_of_a_train_that_starts_at_rest() -> None:
    vehicles = [
        vehicle(tractive_effort=600e3, resistance=WAGON_RESISTANCE),
        *[vehicle(resistance=WAGON_RESISTANCE)] * 9,
    ]
    train = model(train_of(vehicles, linear_gear(3e7, 9e6)), 0.0, track=Track(0.0, ((-1e4, -0.005), (40.0, 0.01))))
    train.set_traction(0, 300e3)
    train.advance(20_000)
    balance = energy_balance(train)
    assert balance.kinetic_start == 0.0
    assert balance.traction_work == pytest.approx(300e3 * float(train.displacement[0]), rel=1e-9)
    assert balance.gravity_work != 0.0
    assert abs(balance.relative_imbalance) < 1e-9


def test_a_release_and_another_application_keep_the_balance() -> None:
    train = model(train_of([vehicle()] * 10, linear_gear(3e7, 9e6)), 20.0, brakes=brake_system())
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.6)
    train.start_wave(8.0, 0, WaveKind.RELEASE, 0.1)
    train.start_wave(14.0, 0, WaveKind.EMERGENCY)
    while not train.at_standstill:
        train.advance(100)
    assert abs(energy_balance(train).relative_imbalance) < 1e-9


@pytest.mark.interpreted
@pytest.mark.parametrize("speed", [5.0, 5.03, -5.07])
def test_the_step_in_which_a_wagon_comes_to_rest_is_balanced_too(speed: float) -> None:
    # Steps of 0.1 s leave up to 200 J to that step, which the mean friction force over it has to take.
    train = model(train_of([vehicle(resistance=WAGON_RESISTANCE)], linear_gear()), speed, time_step=0.1)
    train.start_wave(0.0, 0, WaveKind.EMERGENCY)
    while not train.at_standstill:
        train.advance(1)
    balance = energy_balance(train)
    assert balance.brake_work > 0.9 * balance.kinetic_start
    assert abs(balance.imbalance) < 0.05


@pytest.mark.interpreted
@pytest.mark.parametrize("n_steps", [0, 100])
def test_a_train_without_any_friction_starts_from_rest_with_a_balance(n_steps: int) -> None:
    # A scenario may give a vehicle no resistance at all.
    train = model(train_of([vehicle(tractive_effort=600e3)] * 3, linear_gear(3e7, 9e6)), 0.0)
    train.advance(n_steps)
    train.set_traction(0, 300e3)
    train.advance(1000)
    assert train.speed[0] > 0.0
    assert abs(energy_balance(train).relative_imbalance) < 1e-9


def test_what_is_missing_shows_as_imbalance() -> None:
    balance = EnergyBalance(100.0, 40.0, 30.0, 10.0, -5.0, 2.0, 4.0, 6.0)
    assert balance.imbalance == pytest.approx(40 + 30 + 10 + 4 + 6 - 100 + 5 - 2)
    assert balance.relative_imbalance == pytest.approx(balance.imbalance / 107.0)


def test_nothing_given_and_nothing_spent_is_balanced() -> None:
    assert EnergyBalance(*[0.0] * 8).relative_imbalance == 0.0


@pytest.mark.parametrize("light", [False, True])
def test_one_gear_that_makes_energy_shows_among_many_that_dissipate(light: bool) -> None:
    """Its unloading curve lies above loading; the loader refuses such gears."""
    good, bad = linear_gear(3e7, 9e6), linear_gear(1e7, 1.1e7)
    vehicles = [*[vehicle()] * 10, vehicle(100.0 if light else 100e3, shoe_force=25.0 if light else 25e3)]
    faults = []
    for last in (good, bad):
        train = model(train_of(vehicles, [*[good] * 9, last]), 20.0)
        train.start_wave(0.0, 0, WaveKind.EMERGENCY)
        train.advance(4000)
        balance = energy_balance(train)
        assert abs(balance.relative_imbalance) < 1e-9
        assert balance.gear_dissipated > 0.0
        faults.append(balance.fault)
    assert faults[0] is None
    assert faults[1] is not None and "a draft gear has given more than it took" in faults[1]
