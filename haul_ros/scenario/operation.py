"""Line, commands and time grid from a checked document."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.consist import Consist
from haul_ros.model.driver import CyclicBraking, DriverPlan
from haul_ros.model.request import Request, TimedRequest
from haul_ros.model.track import Track
from haul_ros.physics.stiffness import largest_time_step
from haul_ros.scenario.document import Document, KeyPath
from haul_ros.scenario.radio import link_change
from haul_ros.units import kmh_to_mps, seconds_to_ns

SHORTEST_RAMP = 1.0
"""Shortest ramp between two grades [m]: of a step in disguise the grade by chainage would not be a number."""

_WHOLE = 1e-9


def track(document: Document) -> Track:
    """The line as steps along the chainage.

    Raises
    ------
    ScenarioError
        Grades, curves or limits that are not in order of chainage, curves that overlap, or changes of grade whose
        ramps do.
    """
    entry = document.data["track"]
    for key, name in (("grades", "grade"), ("speed_limits", "limit")):
        _check_order(document, ("track", key), name, [float(step["from_m"]) for step in entry[key]])
    line = Track(
        start_chainage=float(entry["start_chainage_m"]),
        grades=tuple((float(step["from_m"]), step["grade_permille"] / 1e3) for step in entry["grades"]),
        curves=_curves(document, entry["curves"]),
        grade_ramp=float(entry["grade_ramp_m"]),
        speed_limits=tuple(
            (float(step["from_m"]), kmh_to_mps(step.get("limit_kmh", math.inf))) for step in entry["speed_limits"]
        ),
    )
    _check_ramps(document, line)
    return line


def _check_order(document: Document, path: KeyPath, name: str, chainages: list[float]) -> None:
    for index, (before, chainage) in enumerate(pairwise(chainages), start=1):
        if chainage <= before:
            expected = f"must be above that of the {name} before, {before:g}"
            raise document.refusal((*path, index, "from_m"), expected)


def _check_ramps(document: Document, line: Track) -> None:
    if line.grade_ramp == 0.0:
        return
    if line.grade_ramp < SHORTEST_RAMP:
        raise document.refusal(("track", "grade_ramp_m"), f"must be 0 or at least {SHORTEST_RAMP:g}")
    for (before, _), (chainage, grade) in pairwise(line.grade_changes):
        if chainage - before < line.grade_ramp:
            path = ("track", "grades", line.grades.index((chainage, grade)), "from_m")
            ramp = f"its ramp of {line.grade_ramp:g} m overlaps that of the change at {before:g} m"
            expected = f"must be at least {before + line.grade_ramp:g}, or grade_ramp_m at most {chainage - before:g}"
            raise document.refusal(path, f"{ramp}: {expected}")


def _curves(document: Document, entries: list[dict[str, Any]]) -> tuple[tuple[float, float], ...]:
    steps: list[tuple[float, float]] = []
    for index, curve in enumerate(entries):
        path: KeyPath = ("track", "curves", index)
        begin, end = float(curve["from_m"]), float(curve["to_m"])
        if end <= begin:
            raise document.refusal((*path, "to_m"), f"must be above from_m, {begin:g}")
        if steps and begin < steps[-1][0]:
            raise document.refusal((*path, "from_m"), f"the curve before ends at {steps[-1][0]:g}")
        if steps and begin == steps[-1][0]:
            steps.pop()
        steps += [(begin, 1.0 / curve["radius_m"]), (end, 0.0)]
    return tuple(steps)


def _request(document: Document, path: KeyPath, train: Consist) -> Request:
    entry = document.at(path)
    if "link" in entry:
        return link_change(document, path, train)
    locomotive = train.locomotive(entry["locomotive"])
    if locomotive is None:
        names = ", ".join(loco.name for loco in train.locomotives)
        raise document.refusal((*path, "locomotive"), f"must be one of {names}")
    if "emergency" in entry:
        return Command(locomotive.name, CommandKind.EMERGENCY, float(entry["emergency"]))
    if "brake" in entry:
        return Command(locomotive.name, CommandKind.BRAKE, float(entry["brake"]))
    vehicle = train.vehicles[locomotive.vehicle]
    if "traction_kN" in entry:
        key, kind, most = "traction_kN", CommandKind.TRACTION, vehicle.max_tractive_effort
    else:
        key, kind, most = "electric_brake_kN", CommandKind.ELECTRIC_BRAKE, vehicle.electric_brake.max_force
    if entry[key] * 1e3 > most:
        raise document.refusal((*path, key), f"must be at most {most / 1e3:g}, all that {vehicle.name} has")
    return Command(locomotive.name, kind, entry[key] * 1e3)


def driver(document: Document, train: Consist) -> DriverPlan | None:
    """Who drives; None if nobody does.

    Raises
    ------
    ScenarioError
        Speeds that are not in order, or more effort than the weakest of the locomotives has.
    """
    entry = document.data.get("driver")
    if entry is None:
        return None
    vehicles = [train.vehicles[locomotive.vehicle] for locomotive in train.locomotives]
    limits = {
        "traction_kN": min(vehicle.max_tractive_effort for vehicle in vehicles),
        "electric_brake_kN": min(vehicle.electric_brake.max_force for vehicle in vehicles),
    }
    for key, most in limits.items():
        if entry[key] * 1e3 > most:
            raise document.refusal(("driver", key), f"must be at most {most / 1e3:g}, all that every locomotive has")
    return DriverPlan(
        speed=kmh_to_mps(entry["speed_kmh"]),
        traction=entry["traction_kN"] * 1e3,
        electric_brake=entry["electric_brake_kN"] * 1e3,
        band=kmh_to_mps(entry["band_kmh"]),
        reaction_time=float(entry["reaction_s"]),
        cyclic=_cyclic(document, entry.get("cyclic")),
    )


def _cyclic(document: Document, entry: dict[str, Any] | None) -> CyclicBraking | None:
    if entry is None:
        return None
    if not entry["release_below_kmh"] < entry["apply_above_kmh"] < entry["full_service_above_kmh"]:
        expected = "must lie between release_below_kmh and full_service_above_kmh"
        raise document.refusal(("driver", "cyclic", "apply_above_kmh"), expected)
    return CyclicBraking(
        apply_speed=kmh_to_mps(entry["apply_above_kmh"]),
        release_speed=kmh_to_mps(entry["release_below_kmh"]),
        demand=float(entry["demand"]),
        recharge_time=float(entry["recharge_s"]),
        full_service_speed=kmh_to_mps(entry["full_service_above_kmh"]),
    )


def commands(document: Document, train: Consist) -> tuple[TimedRequest, ...]:
    """The timed commands and changes of radio links, in order of time.

    Raises
    ------
    ScenarioError
        A locomotive that the train does not have, more traction or electric brake than it has, or no change of a link.
    """
    timed = [
        TimedRequest(seconds_to_ns(entry["at_s"]), _request(document, ("commands", index), train))
        for index, entry in enumerate(document.data["commands"])
    ]
    return tuple(sorted(timed, key=lambda command: command.time_ns))


def check_time_step(document: Document, train: Consist) -> None:
    """Refuse a time step that is too long for the stiffest contact, whatever it is divided into.

    Raises
    ------
    ScenarioError
        Says how long it may be.
    """
    largest, coupler = largest_time_step(train)
    if document.data["time_step_ms"] / 1e3 > largest:
        expected = f"must be at most {largest * 1e3:.3g} ms for the stiffness of {coupler} and the masses that it joins"
        raise document.refusal(("time_step_ms",), expected)


def time_grid(document: Document) -> tuple[float, float]:
    """Time step [s] and sample rate [Hz].

    Raises
    ------
    ScenarioError
        A sample does not take a whole number of time steps.
    """
    time_step = document.data["time_step_ms"] / 1e3
    sample_rate = float(document.data["sample_rate_hz"])
    steps = 1.0 / (time_step * sample_rate)
    if round(steps) < 1 or abs(steps - round(steps)) > _WHOLE * steps:
        problem = f"a sample takes {steps:.9g} time steps of {document.data['time_step_ms']:g} ms"
        raise document.refusal(("sample_rate_hz",), f"{problem}, must be a whole number of them")
    return time_step, sample_rate
