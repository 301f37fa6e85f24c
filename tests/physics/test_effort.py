"""Traction and electric brake of locomotives: curves, power, adhesion, rates, changeover, emergency."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from haul_ros.model.consist import Consist, Locomotive
from haul_ros.model.vehicle import Adhesion, ElectricBrake, VehicleType
from haul_ros.physics.energy import energy_balance
from haul_ros.physics.train_model import TrainModel, WaveKind
from haul_ros.scenario import load_scenario
from haul_ros.scenario.rolling_stock import ADHESION
from tests.physics.physics_cases import FREE_ROLLING, G, brake_system, linear_gear, vehicle

AT_ONCE: dict[str, Any] = {"effort_rise_time": 0.0, "changeover_time": 0.0}


def catalogue(name: str) -> VehicleType:
    scenario = load_scenario("daqin_1_2_1", {"consist.0.vehicle": name})
    return scenario.consist.vehicles[0]


def pair(locomotive: VehicleType, speed: float, wagon_mass: float = 1e9) -> TrainModel:
    """A locomotive before a wagon so heavy that its effort changes their speed by next to nothing."""
    consist = Consist((locomotive, vehicle(wagon_mass)), (linear_gear(),), (Locomotive("master", 0),))
    return TrainModel(consist, brake_system(), initial_speed=speed)


def effort(train: TrainModel) -> float:
    return float(train.efforts[0])


@pytest.mark.parametrize(
    ("name", "kmh", "kilonewton"),
    [
        ("SS4", 0.0, 627.8),
        ("SS4", 25.75, (627.8 + 436.5) / 2.0),
        ("SS4", 51.5, 436.5),
        ("SS4", 80.0, 6400.0 / (80.0 / 3.6)),
        ("HXD1", 70.0, 494.0 * 9600.0 / 9605.6),  # 494 kN at 70 km/h are 9605.6 kW
        ("HXD2", 90.0, 10000.0 / 25.0),
    ],
)
def test_full_traction_follows_the_published_curve_and_then_the_power(name: str, kmh: float, kilonewton: float) -> None:
    locomotive = replace(catalogue(name), **AT_ONCE)
    train = pair(locomotive, kmh / 3.6)
    train.set_traction(0, locomotive.max_tractive_effort)
    train.advance(1)
    assert effort(train) / 1e3 == pytest.approx(kilonewton, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "kmh", "kilonewton"),
    [
        ("HXD1", 75.0, 9600.0 / (75.0 / 3.6)),
        ("HXD1", 60.0, 461.0),
        ("HXD2", 50.0, 473.0),
        ("SS4", 80.0, 5570.0 / (80.0 / 3.6)),
        ("SS4", 20.0, 382.0),
        ("SS4", 5.0, 191.0),  # fades below 10 km/h
    ],
)
def test_full_electric_brake_follows_force_power_and_fade(name: str, kmh: float, kilonewton: float) -> None:
    locomotive = replace(catalogue(name), **AT_ONCE)
    train = pair(locomotive, kmh / 3.6)
    train.set_electric_brake(0, locomotive.electric_brake.max_force)
    train.advance(1)
    assert -effort(train) / 1e3 == pytest.approx(kilonewton, rel=1e-3)


@pytest.mark.parametrize(
    ("law", "kmh", "kilonewton"),
    [("chinese_electric", 0.0, 650.0), ("chinese_electric", 51.5, 475.0), ("curtius_kniffler", 0.0, 598.2)],
)
def test_adhesion_limits_an_ss4(law: str, kmh: float, kilonewton: float) -> None:
    """650 kN at rest and 475 kN at 51.5 km/h by the Chinese formula; Curtius and Kniffler: 0.161 + 7.5/44 at rest."""
    coefficient = ADHESION[law].coefficient(kmh / 3.6)
    assert 184e3 * G * coefficient / 1e3 == pytest.approx(kilonewton, rel=2e-3)
    locomotive = replace(
        catalogue("SS4"),
        **AT_ONCE,
        adhesion=ADHESION[law],
        continuous_speed=0.0,
        max_tractive_effort=2e6,
        max_power=1e9,
    )
    train = pair(locomotive, kmh / 3.6)
    train.set_traction(0, 2e6)
    train.advance(1)
    assert effort(train) == pytest.approx(184e3 * G * coefficient, rel=1e-3)


def test_the_electric_brake_too_is_limited_by_adhesion() -> None:
    weak = Adhesion(0.05, 0.0, 1.0)
    locomotive = replace(catalogue("SS4"), **AT_ONCE, adhesion=weak)
    train = pair(locomotive, 10.0)
    train.set_electric_brake(0, 382e3)
    train.advance(1)
    assert -effort(train) == pytest.approx(0.05 * 184e3 * G, rel=1e-6)


def test_efforts_rise_and_fall_at_their_rate() -> None:
    locomotive = catalogue("HXD2")  # 760 kN in 25 s
    train = pair(locomotive, 5.0)
    train.set_traction(0, 300e3)
    found = []
    for _ in range(12):
        train.advance(1000)
        found.append(effort(train))
    assert np.diff([0.0, *found[:9]]) == pytest.approx(np.full(9, 760e3 / 25.0), rel=1e-9)
    assert found[-1] == 300e3
    train.set_traction(0, 0.0)
    train.advance(5000)
    assert effort(train) == pytest.approx(300e3 - 5.0 * 760e3 / 25.0, rel=1e-9)


def test_ten_seconds_pass_between_traction_and_electric_braking() -> None:
    train = pair(catalogue("HXD2"), 15.0)
    train.set_traction(0, 152e3)
    train.advance(6000)
    assert effort(train) == 152e3
    train.set_electric_brake(0, 152e3)
    times: list[float] = []
    for _ in range(2500):
        train.advance(10)
        if effort(train) < 0.0:
            break
        if effort(train) == 0.0:
            times.append(train.time)
    assert times[0] == pytest.approx(11.0, abs=0.05)  # 5 s down
    assert times[-1] - times[0] == pytest.approx(10.0, abs=0.05)
    train.advance(6000)
    assert effort(train) == -152e3


def test_an_electric_brake_stops_no_train_but_slows_it_as_its_force_says() -> None:
    electric = ElectricBrake(max_force=461e3, fade_speed=10.0 / 3.6)
    locomotive = replace(catalogue("HXD1"), **AT_ONCE, electric_brake=electric, resistance=FREE_ROLLING)
    train = pair(locomotive, 20.0, wagon_mass=800e3)
    train.set_electric_brake(0, 461e3)
    train.advance(10_000)
    masses = np.array([200e3, 800e3])
    assert (masses * (20.0 - train.speed)).sum() == pytest.approx(461e3 * 10.0, rel=1e-9)  # momentum
    balance = energy_balance(train)
    assert balance.electric_brake_work == pytest.approx(461e3 * float(train.displacement[0]), rel=1e-6)
    assert balance.traction_work == 0.0
    assert abs(balance.relative_imbalance) < 1e-9
    train.advance(60_000)
    speeds = []
    for _ in range(5):
        train.advance(2000)
        speeds.append(float(train.speed[0]))
    assert all(0.0 <= later <= earlier for earlier, later in pairwise(speeds))
    assert (train.efforts <= 0.0).all()


@pytest.mark.parametrize("stays", [False, True])
def test_an_emergency_ends_traction_and_the_electric_brake_unless_it_is_to_stay(stays: bool) -> None:
    shipped = catalogue("HXD1")
    locomotive = replace(shipped, **AT_ONCE, electric_brake=replace(shipped.electric_brake, stays_in_emergency=stays))
    train = pair(locomotive, 20.0)
    train.set_electric_brake(0, 300e3)
    train.advance(100)
    train.start_wave(train.time, 0, WaveKind.EMERGENCY)
    train.advance(100)
    assert effort(train) == (-300e3 if stays else 0.0)
    train = pair(locomotive, 20.0)
    train.set_traction(0, 300e3)
    train.advance(100)
    train.start_wave(train.time, 0, WaveKind.EMERGENCY)
    train.advance(100)
    assert effort(train) == 0.0


def test_none_of_one_leaves_the_other_alone() -> None:
    train = pair(replace(catalogue("HXD1"), **AT_ONCE), 10.0)
    train.set_traction(0, 100e3)
    train.set_electric_brake(0, 0.0)
    train.advance(1)
    assert effort(train) == 100e3
    train.set_electric_brake(0, 50e3)
    train.set_traction(0, 0.0)
    train.advance(1)
    assert effort(train) == -50e3


@pytest.mark.parametrize("demand", [0.5, None])
def test_the_electric_brake_holds_the_locomotives_air_brake_off_but_in_an_emergency(demand: float | None) -> None:
    overrides = {"consist.1.count": 20, "commands": [], "vehicles.SS4.electric_brake.in_emergency": "keep"}
    scenario = load_scenario("daqin_1_2_1_pneumatic", overrides)
    train = TrainModel(scenario.consist, scenario.brakes, initial_speed=20.0, time_step=1e-3)
    train.set_electric_brake(0, 300e3)
    train.advance(500)
    if demand is None:
        train.set_emergency_valve(0)
    else:
        train.set_brake_valve(0, demand)
    train.advance(6000)
    force = train.train.vehicles.brake_force
    assert effort(train) < 0.0
    assert (force[1:20] > 1e3).all()
    assert (force[0] > 50e3) == (demand is None)
    assert (train.train.brakes.fraction[0] > 0.3) == (demand is None)  # its cylinder is empty, not only without effect


def test_a_standing_locomotive_keeps_its_air_brake_whatever_electric_brake_is_asked_for() -> None:
    overrides = {"consist.1.count": 2, "consist.3.count": 2, "commands": []}
    scenario = load_scenario("daqin_1_2_1_pneumatic", overrides)
    train = TrainModel(scenario.consist, scenario.brakes, initial_speed=0.0, time_step=1e-3)
    train.set_brake_valve(0, 1.0)
    train.advance(20_000)
    train.set_electric_brake(0, 380e3)
    train.advance(20_000)
    assert train.train.brakes.gain[0] > 0.0
