"""Faults from a checked document."""

from __future__ import annotations

from typing import Any

from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.consist import Consist
from haul_ros.model.fault import HOSE_REACH, Fault, FaultKind, FaultPlan, PlannedFault
from haul_ros.scenario.document import Document, KeyPath
from haul_ros.units import seconds_to_ns

LEAST_PRESSURE = 100e3
"""Of the charged pipe [Pa], above which a leak of it is choked."""


def faults(document: Document, train: Consist, brake: BrakeSystem | PneumaticBrake) -> FaultPlan:
    """What goes wrong in a complete scenario.

    Raises
    ------
    ScenarioError
        A place that the train does not have, something of the air without a pneumatic brake, or a leakage of a pipe
        whose pressure is too low for it to be choked.
    """
    entry: dict[str, Any] = document.data.get("faults", {})
    planned = tuple(
        _planned(document, ("faults", "events", index), train, brake) for index in range(len(entry.get("events", [])))
    )
    return FaultPlan(
        leakage=_leakage(document, entry, brake),
        hose_reach=entry.get("hose_parts_at_mm", HOSE_REACH * 1e3) / 1e3,
        planned=planned,
    )


def _leakage(document: Document, entry: dict[str, Any], brake: BrakeSystem | PneumaticBrake) -> float:
    rate = float(entry.get("leakage_kPa_per_min", 0.0))
    path: KeyPath = ("faults", "leakage_kPa_per_min")
    if rate == 0.0:
        return 0.0
    if not isinstance(brake, PneumaticBrake):
        raise document.refusal(path, _needs_air(document))
    if brake.pressure < LEAST_PRESSURE:
        raise document.refusal(path, f"needs a pipe_pressure_kPa of at least {LEAST_PRESSURE / 1e3:g}")
    return rate * 1e3 / 60.0


def _needs_air(document: Document) -> str:
    return f"needs a pneumatic brake, and brakes = {document.data['brakes']} is none"


def _planned(document: Document, path: KeyPath, train: Consist, brake: BrakeSystem | PneumaticBrake) -> PlannedFault:
    entry = document.at(path)
    kind = next(kind for kind in FaultKind if kind.value in entry)
    place: KeyPath = (*path, kind.value)
    number = int(entry[kind.value])
    if kind.of_air and not isinstance(brake, PneumaticBrake):
        raise document.refusal(place, _needs_air(document))
    count = len(train.vehicles) if kind.of_vehicle else len(train.couplers)
    if number > count:
        what = "vehicles" if kind.of_vehicle else "couplers"
        raise document.refusal(place, f"must be at most {count}, the number of {what}")
    if kind is FaultKind.UNCOUPLE and train.couplers[number - 1] is None:
        raise document.refusal(place, "is a rigid drawbar, which cannot be uncoupled")
    fault = Fault(kind, number, entry.get("bore_mm", 0.0) / 1e3)
    if "at_s" in entry:
        return PlannedFault(fault, time_ns=seconds_to_ns(entry["at_s"]))
    return PlannedFault(fault, chainage=float(entry["at_m"]))
