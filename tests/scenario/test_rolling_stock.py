"""Vehicle entries to SI: each number against the formula in the units of the standard."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haul_ros.model.vehicle import VehicleType
from haul_ros.scenario.catalogue import catalogue_section
from haul_ros.scenario.rolling_stock import running_resistance, shoe_friction, vehicle_types
from haul_ros.units import kmh_to_mps

SHOES = catalogue_section("brake_shoes").data["brake_shoes"]
RESISTANCES = catalogue_section("resistances").data["resistances"]
PUBLISHED: dict[str, Callable[[float, float, float], float]] = {
    "high_friction_composite": lambda k, v, v0: 0.41 * (k + 200) / (4 * k + 200) * (v + 150) / (2 * v + 150),
    "low_friction_composite": lambda k, v, v0: (
        0.25 * (k + 500) / (6 * k + 500) * (4 * v + 150) / (10 * v + 150) + 0.0006 * (100 - v0)
    ),
    "medium_phosphorus_iron": lambda k, v, v0: (
        0.64 * (k + 100) / (5 * k + 100) * (3.6 * v + 100) / (14 * v + 100) + 0.0007 * (110 - v0)
    ),
    "high_phosphorus_iron": lambda k, v, v0: (
        0.82 * (k + 100) / (7 * k + 100) * (17 * v + 100) / (60 * v + 100) + 0.0012 * (120 - v0)
    ),
}


@pytest.mark.parametrize("name", PUBLISHED)
@given(force_kn=st.floats(0.0, 60.0), speed_kmh=st.floats(0.0, 120.0), initial_kmh=st.floats(0.0, 120.0))
def test_friction_in_si_is_that_of_the_standard(
    name: str, force_kn: float, speed_kmh: float, initial_kmh: float
) -> None:
    friction = shoe_friction(SHOES[name])
    si = friction.coefficient(force_kn * 1e3, kmh_to_mps(speed_kmh), kmh_to_mps(initial_kmh))
    assert si == pytest.approx(PUBLISHED[name](force_kn, speed_kmh, initial_kmh), rel=1e-12)


@pytest.mark.parametrize(
    ("name", "published"),
    [
        ("ss_locomotive", lambda v: 2.25 + 0.019 * v + 0.00032 * v**2),
        ("wagon_loaded", lambda v: 0.92 + 0.0048 * v + 0.000125 * v**2),
        ("wagon_empty", lambda v: 2.23 + 0.0053 * v + 0.000675 * v**2),
    ],
)
def test_resistance_in_si_is_that_of_the_standard(name: str, published: Callable[[float], float]) -> None:
    resistance = running_resistance(RESISTANCES[name])
    for speed_kmh in (10.0, 40.0, 100.0):
        v = kmh_to_mps(speed_kmh)
        si = resistance.constant + resistance.linear * v + resistance.quadratic * v**2
        assert si * 1e3 == pytest.approx(published(speed_kmh), rel=1e-12)
    assert resistance.minimum_speed == kmh_to_mps(10.0)
    assert resistance.starting * 1e3 == pytest.approx(5.0 if name == "ss_locomotive" else 3.5)


def _vehicle(**entry: object) -> VehicleType:
    wagon = {
        "mass_t": 84,
        "length_m": 12,
        "resistance": "wagon_loaded",
        "shoes": 8,
        "brake_shoe": "high_friction_composite",
        "cylinder_pressure_kPa": 360,
        **entry,
    }
    return vehicle_types({"vehicles": {"W": wagon}, "brake_shoes": SHOES, "resistances": RESISTANCES})["W"]


def test_a_vehicle_is_converted_to_si() -> None:
    wagon = _vehicle(shoe_force_kN=19.5, max_tractive_effort_kN=470)
    assert (wagon.name, wagon.mass, wagon.length, wagon.shoes) == ("W", 84e3, 12.0, 8)
    assert (wagon.shoe_force, wagon.cylinder_pressure, wagon.max_tractive_effort) == (19.5e3, 360e3, 470e3)


def test_the_shoe_force_may_come_from_cylinder_and_rigging() -> None:
    cylinder = {"diameter_mm": 254, "leverage_ratio": 9.6, "efficiency": 0.9, "cylinders": 2}
    wagon = _vehicle(cylinder=cylinder)
    # TB/T 1407-1998 in its own units: mm, kPa, kN
    published_kn = math.pi / 4 * 254**2 * 360 * 0.9 * 9.6 * 2 / (8 * 1e6)
    assert wagon.shoe_force == pytest.approx(published_kn * 1e3)
