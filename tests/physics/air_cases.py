"""Trains with a pneumatic brake, as in the catalogue or with single laws alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from haul_ros.model.air_brake import ATMOSPHERE, ControlValve, PneumaticBrake
from haul_ros.model.consist import Consist, Locomotive
from haul_ros.model.vehicle import VehicleType
from haul_ros.physics.train_model import TrainModel
from haul_ros.scenario import load_scenario

GAS = 287.0 * 293.0
"""R T of air at 293 K [J/kg]."""

SOUND = GAS**0.5
"""Isothermal speed of sound [m/s]."""

CHOKED = 0.6847
"""sqrt(1.4 (2/2.4)^6): choked mass flow is this times area, pressure over SOUND."""

_BORES = (
    "charge",
    "service",
    "exhaust",
    "bulb_fill",
    "bulb_vent",
    "quick_service",
    "accelerated",
    "vent",
    "fast",
    "slow",
)
INERT: dict[str, Any] = {f"{name}_bore": 0.0 for name in _BORES} | {
    "apply_difference": 1e9, "quick_service_difference": 1e9, "emergency_difference": np.inf
}  # fmt: skip
"""A control valve that does nothing."""

Floats = NDArray[np.float64]


def effective(bore: float, discharge: float = 0.8) -> float:
    """Effective area of a bore [m^2]."""
    return float(discharge * np.pi / 4.0 * bore**2)


def brake_of(scenario: str = "daqin_1_2_1_pneumatic", **overrides: Any) -> PneumaticBrake:
    brakes = load_scenario(scenario, {key.replace("__", "."): value for key, value in overrides.items()}).brakes
    assert isinstance(brakes, PneumaticBrake)
    return brakes


def air_train(
    wagons: int = 20,
    *,
    locomotives: tuple[int, ...] = (0,),
    time_step: float = 2e-3,
    wagon_valve: dict[str, Any] | None = None,
    locomotive_valve: dict[str, Any] | None = None,
    pipe: dict[str, Any] | None = None,
    driver: dict[str, Any] | None = None,
    initial_speed: ArrayLike = 0.0,
    **brake: Any,
) -> TrainModel:
    """A train of ``wagons`` C80 with SS4 put in before the wagons of these numbers; single values replaced."""
    scenario = load_scenario("daqin_1_2_1_pneumatic")
    shipped = scenario.brakes
    assert isinstance(shipped, PneumaticBrake)
    kinds = {vehicle.name: vehicle for vehicle in scenario.consist.vehicles}
    vehicles: list[VehicleType] = []
    powered: list[int] = []
    for number in range(wagons + 1):
        for _ in range(locomotives.count(number)):
            powered.append(len(vehicles))
            vehicles.append(kinds["SS4"])
        if number < wagons:
            vehicles.append(kinds["C80"])
    names = ["master", *(f"slave_{n}" for n in range(1, len(powered)))]
    consist = Consist(
        tuple(vehicles),
        (scenario.consist.couplers[0],) * (len(vehicles) - 1),
        tuple(Locomotive(name, vehicle) for name, vehicle in zip(names, powered, strict=True)),
    )
    valves: dict[str, ControlValve] = {
        "C80": replace(shipped.valves["C80"], **(wagon_valve or {})),
        "SS4": replace(shipped.valves["SS4"], **(locomotive_valve or {})),
    }
    brakes = replace(
        shipped,
        valves=valves,
        pipe=replace(shipped.pipe, **(pipe or {})),
        driver_valve=replace(shipped.driver_valve, **(driver or {})),
        **brake,
    )
    return TrainModel(consist, brakes, initial_speed=initial_speed, time_step=time_step)


def locomotives_of(train: TrainModel) -> list[int]:
    return [locomotive.vehicle for locomotive in train.consist.locomotives]


def wagons_of(train: TrainModel) -> NDArray[np.bool_]:
    return np.array([vehicle.max_tractive_effort == 0.0 for vehicle in train.consist.vehicles])


def cylinder(train: TrainModel) -> Floats:
    """Gauge pressure of the brake cylinders [Pa]."""
    return np.array(train.train.air_state.cylinder - ATMOSPHERE)


def pipe(train: TrainModel) -> Floats:
    """Gauge pressure of the brake pipe [Pa]."""
    return np.array(train.train.air_state.pipe - ATMOSPHERE)


def history(train: TrainModel, seconds: float, every: float = 0.05) -> tuple[Floats, Floats, Floats]:
    """Times (n,) [s], gauge pressures of pipe and cylinders (n, v) [Pa] while a train is advanced."""
    steps = round(every / train.time_step)
    times, pipes, cylinders = [], [], []
    for _ in range(round(seconds / every)):
        train.advance(steps)
        times.append(train.time)
        pipes.append(pipe(train))
        cylinders.append(cylinder(train))
    return np.array(times), np.array(pipes), np.array(cylinders)


def first_above(times: Floats, pressures: Floats, level: float) -> Floats:
    """When each vehicle's pressure first passes a level [s], NaN: never."""
    above = pressures > level
    return np.where(above.any(axis=0), times[above.argmax(axis=0)], np.nan)
