"""Vehicles, brake shoes and running resistances from a checked document."""

from __future__ import annotations

import math
from typing import Any

from haul_ros.model.vehicle import (
    Adhesion,
    ElectricBrake,
    RunningResistance,
    ShoeFriction,
    VehicleType,
    shoe_force_from_cylinder,
)
from haul_ros.units import kmh_to_mps

_KMH_PER_MPS = 3.6
_DEFAULT_MINIMUM_SPEED_KMH = 10.0

ADHESION = {
    "chinese_electric": Adhesion(0.24, kmh_to_mps(12.0 / 8.0), kmh_to_mps(100.0 / 8.0)),
    "chinese_diesel": Adhesion(0.248, kmh_to_mps(5.9 / 20.0), kmh_to_mps(75.0 / 20.0)),
    "curtius_kniffler": Adhesion(0.161, kmh_to_mps(7.5), kmh_to_mps(44.0)),
}
"""Adhesion coefficients by their names in the schema: TB/T 1407-1998 (from general knowledge), Curtius and Kniffler."""


def running_resistance(entry: dict[str, Any]) -> RunningResistance:
    """From N/kN with v in km/h to N/N with v in m/s."""
    return RunningResistance(
        constant=entry["constant_N_per_kN"] / 1e3,
        linear=entry["linear_N_per_kN_kmh"] * _KMH_PER_MPS / 1e3,
        quadratic=entry["quadratic_N_per_kN_kmh2"] * _KMH_PER_MPS**2 / 1e3,
        starting=entry["starting_N_per_kN"] / 1e3,
        minimum_speed=kmh_to_mps(entry.get("minimum_speed_kmh", _DEFAULT_MINIMUM_SPEED_KMH)),
    )


def shoe_friction(entry: dict[str, Any]) -> ShoeFriction:
    """From the standard's K in kN and v in km/h to N and m/s; numerators and denominators are divided by 3.6."""
    return ShoeFriction(
        scale=float(entry["scale"]),
        k_offset=entry["k_offset_kN"] * 1e3,
        k_gain=float(entry["k_gain"]),
        n_slope=float(entry["n_slope"]),
        n_offset=kmh_to_mps(entry["n_offset_kmh"]),
        d_slope=float(entry["d_slope"]),
        d_offset=kmh_to_mps(entry["d_offset_kmh"]),
        v0_slope=entry.get("v0_slope_per_kmh", 0.0) * _KMH_PER_MPS,
        v0_reference=kmh_to_mps(entry.get("v0_reference_kmh", 0.0)),
    )


def _shoe_force(entry: dict[str, Any]) -> float:
    if "shoe_force_kN" in entry:
        return float(entry["shoe_force_kN"] * 1e3)
    cylinder = entry["cylinder"]
    return shoe_force_from_cylinder(
        diameter=cylinder["diameter_mm"] / 1e3,
        pressure=entry["cylinder_pressure_kPa"] * 1e3,
        efficiency=cylinder["efficiency"],
        leverage_ratio=cylinder["leverage_ratio"],
        cylinders=int(cylinder["cylinders"]),
        shoes=int(entry["shoes"]),
    )


def _electric_brake(entry: dict[str, Any] | None) -> ElectricBrake:
    if entry is None:
        return ElectricBrake()
    return ElectricBrake(
        max_force=entry["max_force_kN"] * 1e3,
        max_power=entry.get("max_power_kW", math.inf) * 1e3,
        fade_speed=kmh_to_mps(entry.get("fade_below_kmh", 10.0)),
        stays_in_emergency=entry.get("in_emergency") == "keep",
        interlock=bool(entry.get("interlock", False)),
    )


def vehicle_types(data: dict[str, Any]) -> dict[str, VehicleType]:
    """All vehicles of a complete scenario by name."""
    frictions = {name: shoe_friction(entry) for name, entry in data["brake_shoes"].items()}
    resistances = {name: running_resistance(entry) for name, entry in data["resistances"].items()}
    return {
        name: VehicleType(
            name=name,
            mass=entry["mass_t"] * 1e3,
            length=float(entry["length_m"]),
            resistance=resistances[entry["resistance"]],
            shoes=int(entry["shoes"]),
            shoe_force=_shoe_force(entry),
            friction=frictions[entry["brake_shoe"]],
            cylinder_pressure=entry["cylinder_pressure_kPa"] * 1e3,
            max_tractive_effort=entry.get("max_tractive_effort_kN", 0.0) * 1e3,
            max_power=entry.get("max_power_kW", math.inf) * 1e3,
            continuous_effort=entry.get("continuous_effort_kN", 0.0) * 1e3,
            continuous_speed=kmh_to_mps(entry.get("continuous_speed_kmh", 0.0)),
            effort_rise_time=float(entry.get("effort_rise_time_s", 0.0)),
            changeover_time=float(entry.get("changeover_time_s", 0.0)),
            electric_brake=_electric_brake(entry.get("electric_brake")),
            adhesion=ADHESION.get(entry.get("adhesion", "")),
        )
        for name, entry in data["vehicles"].items()
    }
