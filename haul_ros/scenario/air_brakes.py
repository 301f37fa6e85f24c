"""Pneumatic brakes from a checked document."""

from __future__ import annotations

import math
from dataclasses import MISSING, fields
from typing import Any

from haul_ros.model.air_brake import BrakePipe, ControlValve, DriverValve, PneumaticBrake, Release
from haul_ros.model.consist import Consist
from haul_ros.model.vehicle import VehicleType
from haul_ros.physics.air_assembly import GAS_CONSTANT
from haul_ros.scenario.document import Document, KeyPath

UNITS = {
    "_L": 1e-3,
    "_mm": 1e-3,
    "_kPa": 1e3,
    "_kPa_per_s": 1e3,
    "_m3_per_min": 1.0 / 60.0,
    "_K": 1.0,
    "_s": 1.0,
    "": 1.0,
}
"""SI units in those that keys of a valve or pipe end in."""

LARGEST_STEP = 0.25
"""Of the time that sound takes through a vehicle: the flow is explicit, and faster with the air that moves."""

_WHOLE = 1e-9


def is_pneumatic(entry: dict[str, Any]) -> bool:
    """Whether an entry of brake_systems is a pneumatic brake."""
    return "pipe_pressure_kPa" in entry


def _numbers(kind: type, entry: dict[str, Any]) -> dict[str, Any]:
    """The fields of a dataclass from keys of the same names, which end in a unit."""
    found: dict[str, Any] = {}
    for field in fields(kind):
        for suffix, factor in UNITS.items():
            if (value := entry.get(field.name + suffix)) is not None:
                found[field.name] = value if isinstance(value, str | bool) else value * factor
                break
    return found


def control_valve(document: Document, name: str) -> ControlValve:
    """The control valve of that name in a complete scenario.

    Raises
    ------
    ScenarioError
        Something that a valve of its kind needs is missing.
    """
    path = ("control_valves", name)
    numbers = _numbers(ControlValve, document.at(path))
    numbers["release"] = Release(numbers["release"])
    missing = [f.name for f in fields(ControlValve) if f.name not in numbers and f.default is MISSING]
    if missing:
        raise document.error(path, f"a {numbers['release'].value} release valve needs {', '.join(missing)} too")
    valve = ControlValve(**numbers)
    if valve.from_main_reservoir and valve.release is Release.DIRECT:
        expected = "must be false: a direct release valve compares its auxiliary reservoir with the pipe"
        raise document.refusal((*path, "from_main_reservoir"), expected)
    _check_differences(document, path, valve)
    return valve


def pneumatic_brake(document: Document, name: str, train: Consist) -> PneumaticBrake:
    """The pneumatic brake of that name in a complete scenario, for the vehicles of a train.

    Raises
    ------
    ScenarioError
        Steps of time and air that do not fit, an air step too long for the shortest vehicle, or a valve that lacks
        something.
    """
    entry = document.at(("brake_systems", name))
    vehicles = {vehicle.name: vehicle for vehicle in train.vehicles}
    pipe = BrakePipe(**_numbers(BrakePipe, entry["pipe"]))
    names = {vehicle.name: _valve_name(document, entry, vehicle) for vehicle in vehicles.values()}
    valves = {valve: control_valve(document, valve) for valve in set(names.values())}
    limits = {kind: document.at(("vehicles", kind)).get("cylinder_limit_kPa", math.inf) * 1e3 for kind in vehicles}
    if not entry["least_reduction_kPa"] < entry["full_reduction_kPa"] < entry["pipe_pressure_kPa"]:
        path = ("brake_systems", name, "full_reduction_kPa")
        raise document.refusal(path, "must lie between least_reduction_kPa and pipe_pressure_kPa")
    _check_main_reservoir(document, name)
    _check_steps(document, name, pipe, min(vehicle.length for vehicle in vehicles.values()))
    return PneumaticBrake(
        pressure=entry["pipe_pressure_kPa"] * 1e3,
        least_reduction=entry["least_reduction_kPa"] * 1e3,
        full_reduction=entry["full_reduction_kPa"] * 1e3,
        step=entry["air_step_ms"] / 1e3,
        discharge=float(entry["discharge_coefficient"]),
        pipe=pipe,
        driver_valve=DriverValve(**_numbers(DriverValve, entry["driver_valve"])),
        valves={kind: valves[valve] for kind, valve in names.items()},
        cylinder_limits=limits,
    )


def _valve_name(document: Document, entry: dict[str, Any], vehicle: VehicleType) -> str:
    """The valve of a vehicle: its own, or that of the brake system for locomotives and wagons."""
    default = entry["locomotive_valve"] if vehicle.max_tractive_effort > 0.0 else entry["wagon_valve"]
    return str(document.at(("vehicles", vehicle.name)).get("control_valve", default))


def _check_steps(document: Document, name: str, pipe: BrakePipe, shortest: float) -> None:
    """One clock: the steps of air and train are whole multiples, and sound crosses no cell in one."""
    path = ("brake_systems", name, "air_step_ms")
    step, time_step = document.at(path), document.data["time_step_ms"]
    ratio = max(step / time_step, time_step / step)
    if abs(ratio - round(ratio)) > _WHOLE * ratio:
        raise document.refusal(path, f"must be a whole multiple or fraction of time_step_ms, {time_step:g}")
    crossing = 1e3 * pipe.length_ratio * shortest / math.sqrt(GAS_CONSTANT * pipe.temperature)
    if step > LARGEST_STEP * crossing:
        expected = f"must be at most {LARGEST_STEP * crossing:.3g} ms, a quarter of what sound takes through"
        raise document.refusal(path, f"{expected} the shortest vehicle")


def _check_main_reservoir(document: Document, name: str) -> None:
    """The compressor keeps the main reservoir above what the pipe needs."""
    path, entry = ("brake_systems", name, "driver_valve"), document.at(("brake_systems", name))
    if not entry["pipe_pressure_kPa"] < entry["driver_valve"]["compressor_on_kPa"]:
        raise document.refusal((*path, "compressor_on_kPa"), "must be above pipe_pressure_kPa")
    if not entry["driver_valve"]["compressor_on_kPa"] < entry["driver_valve"]["compressor_off_kPa"]:
        raise document.refusal((*path, "compressor_off_kPa"), "must be above compressor_on_kPa")


def _check_differences(document: Document, path: KeyPath, valve: ControlValve) -> None:
    """No two positions of a valve may call for one another."""
    if valve.release is Release.GRADUATED:
        if valve.release_difference >= valve.apply_difference:
            raise document.refusal((*path, "release_difference_kPa"), "must be below apply_difference_kPa")
    elif not valve.lap_difference < min(valve.reapply_difference, valve.apply_difference):
        expected = "must be below reapply_difference_kPa and apply_difference_kPa"
        raise document.refusal((*path, "lap_difference_kPa"), expected)
