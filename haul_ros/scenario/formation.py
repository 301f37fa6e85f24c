"""The consist from a checked document: vehicles, what joins them, and who takes commands."""

from __future__ import annotations

from haul_ros.model.consist import MASTER, Consist, Locomotive
from haul_ros.model.draft_gear import DraftGear
from haul_ros.model.vehicle import VehicleType
from haul_ros.scenario.document import Document
from haul_ros.scenario.draft_gears import draft_gears
from haul_ros.scenario.rolling_stock import vehicle_types

MAX_VEHICLES = 2000
"""Longest train; ten times those in service."""


def consist(document: Document) -> Consist:
    """The train of a complete scenario.

    Raises
    ------
    ScenarioError
        Not 2 to 2000 vehicles, not exactly one master, groups that do not come out even, or draft gear curves
        that cannot be.
    """
    kinds = vehicle_types(document.data)
    gears = draft_gears(document)
    default_gear = gears[document.data["coupler"]]
    vehicles: list[VehicleType] = []
    couplers: list[DraftGear | None] = []
    roles: list[tuple[str, int]] = []
    for index, entry in enumerate(document.data["consist"]):
        count = int(entry.get("count", 1))
        group = int(entry.get("drawbar_group", 1))
        if count % group:
            raise document.refusal(("consist", index, "drawbar_group"), f"must divide count, {count}")
        gear = gears[entry["coupler"]] if "coupler" in entry else default_gear
        for number in range(1, count + 1):
            if "role" in entry:
                roles.append((entry["role"], len(vehicles)))
            vehicles.append(kinds[entry["vehicle"]])
            couplers.append(None if number % group else gear)
    if not 2 <= len(vehicles) <= MAX_VEHICLES:
        raise document.error(("consist",), f"a train of {len(vehicles)}, must have 2 to {MAX_VEHICLES} vehicles")
    # Nothing is coupled behind the last vehicle.
    return Consist(tuple(vehicles), tuple(couplers[:-1]), _locomotives(document, roles))


def _locomotives(document: Document, roles: list[tuple[str, int]]) -> tuple[Locomotive, ...]:
    masters = sum(role == MASTER for role, _ in roles)
    if masters != 1:
        raise document.error(("consist",), f"{masters} vehicles have role: master, must be exactly 1")
    locomotives, slaves = [], 0
    for role, vehicle in roles:
        if role != MASTER:
            slaves += 1
        locomotives.append(Locomotive(MASTER if role == MASTER else f"slave_{slaves}", vehicle))
    return tuple(locomotives)
