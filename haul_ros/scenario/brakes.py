"""Brake systems from a checked document."""

from __future__ import annotations

from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.brake_system import BrakeSystem, BuildUp, WaveSpeeds
from haul_ros.model.consist import Consist
from haul_ros.scenario.air_brakes import is_pneumatic, pneumatic_brake
from haul_ros.scenario.document import Document, KeyPath


def _build_up(document: Document, path: KeyPath) -> BuildUp:
    entry = document.at(path)
    full_time = float(entry["full_time_s"])
    # Without a knee the law is linear: the knee lies at its end.
    knee_time = float(entry.get("knee_time_s", full_time))
    if "knee_time_s" in entry and knee_time >= full_time:
        raise document.refusal((*path, "knee_time_s"), f"must be below full_time_s, {entry['full_time_s']}")
    return BuildUp(
        knee=float(entry.get("knee_fraction", 1.0)),
        knee_time=knee_time,
        full_time=full_time,
        service_time=float(entry["service_time_s"]),
        release_time=float(entry["release_time_s"]),
        friction_follows_pressure=entry["friction_follows_pressure"],
    )


def brakes(document: Document, name: str, train: Consist) -> BrakeSystem | PneumaticBrake:
    """The brakes of that name in a complete scenario, empirical or pneumatic.

    Raises
    ------
    ScenarioError
        See `brake_system` and `pneumatic_brake`.
    """
    if is_pneumatic(document.at(("brake_systems", name))):
        return pneumatic_brake(document, name, train)
    return brake_system(document, name)


def brake_system(document: Document, name: str) -> BrakeSystem:
    """The empirical brake system of that name in a complete scenario.

    Raises
    ------
    ScenarioError
        The two stages of the build-up are not in order.
    """
    path = ("brake_systems", name)
    entry = document.at(path)
    waves = entry["wave_speeds"]
    return BrakeSystem(
        wave_speeds=WaveSpeeds(
            emergency=float(waves["emergency_mps"]),
            service=float(waves["service_mps"]),
            release=float(waves["release_mps"]),
        ),
        build_up=_build_up(document, (*path, "build_up")),
        full_service=float(entry["full_service_fraction"]),
    )
