"""The formation: which vehicles, in which order, joined by what, and who brakes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from haul_ros.model.draft_gear import DraftGear
from haul_ros.model.vehicle import VehicleType

MASTER = "master"


@dataclass(frozen=True, slots=True)
class Locomotive:
    """A locomotive that takes brake commands: ``master``, ``slave_1``, ``slave_2`` ... from the head."""

    name: str
    vehicle: int
    """Index of the vehicle, 0 at the head."""


@dataclass(frozen=True)
class Consist:
    """Vehicles from the head and what joins them.

    ``couplers[j]`` lies between vehicles ``j`` and ``j + 1``: a draft gear, or None for a rigid
    drawbar, which makes the two vehicles one mass.
    """

    vehicles: tuple[VehicleType, ...]
    couplers: tuple[DraftGear | None, ...]
    locomotives: tuple[Locomotive, ...]

    def __post_init__(self) -> None:
        if len(self.couplers) != len(self.vehicles) - 1:
            raise ValueError(
                f"{len(self.vehicles)} vehicles need {len(self.vehicles) - 1} couplers, not {len(self.couplers)}"
            )

    @cached_property
    def vehicle_names(self) -> tuple[str, ...]:
        """Names as published: ``vehicle_001_SS4`` ... from the head."""
        return tuple(f"vehicle_{i:03d}_{v.name}" for i, v in enumerate(self.vehicles, start=1))

    @cached_property
    def coupler_names(self) -> tuple[str, ...]:
        """Names as published: ``coupler_001`` between the first two vehicles, and so on."""
        return tuple(f"coupler_{j:03d}" for j in range(1, len(self.couplers) + 1))

    @cached_property
    def mass(self) -> float:
        """Mass of the whole train [kg]."""
        return sum(v.mass for v in self.vehicles)

    @cached_property
    def length(self) -> float:
        """Length of the whole train over couplers [m]."""
        return sum(v.length for v in self.vehicles)

    @cached_property
    def centre_offsets(self) -> tuple[float, ...]:
        """Distance [m] of each vehicle's centre behind the head of the train, couplers free."""
        offsets, head = [], 0.0
        for vehicle in self.vehicles:
            offsets.append(head + vehicle.length / 2)
            head += vehicle.length
        return tuple(offsets)

    def locomotive(self, name: str) -> Locomotive | None:
        """The commanded locomotive of that name, or None."""
        return next((loco for loco in self.locomotives if loco.name == name), None)
