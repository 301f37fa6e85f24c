"""Brake shoes: TB/T 1407-1998 in its own units, and the shoe force from the brake cylinder."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.model.vehicle import ShoeFriction, shoe_force_from_cylinder

# 0.64 (K+100)/(5K+100) (3.6v+100)/(14v+100) + 0.0007 (110-v0) with K in kN and speeds in km/h, medium-phosphorus iron.
MEDIUM_PHOSPHORUS = ShoeFriction(0.64, 100e3, 5, 3.6 * 3.6, 100, 14 * 3.6, 100, 0.0007 * 3.6, 110 / 3.6)


@settings(deadline=None)
@given(k=st.floats(0.0, 60.0), v=st.floats(0.0, 120.0), v0=st.floats(0.0, 120.0))
def test_the_coefficient_in_si_units_is_that_of_the_standard_s_units(k: float, v: float, v0: float) -> None:
    expected = 0.64 * (k + 100) / (5 * k + 100) * (3.6 * v + 100) / (14 * v + 100) + 0.0007 * (110 - v0)
    assert MEDIUM_PHOSPHORUS.coefficient(k * 1e3, v / 3.6, v0 / 3.6) == pytest.approx(expected, rel=1e-12)


def test_at_25_kn_the_coefficient_reduces_to_the_converted_one() -> None:
    # Published converted coefficient: 0.356 (3.6v+100)/(14v+100) + 0.0007 (110-v0)
    assert MEDIUM_PHOSPHORUS.coefficient(25e3, 0.0, 110 / 3.6) == pytest.approx(0.356, abs=5e-4)


def test_shoe_force_is_the_piston_s_force_through_the_rigging_shared_by_the_shoes() -> None:
    # (pi/4) 203^2 mm^2 x 360 kPa x 0.90 x 9.0 x 2 / (8 x 10^6) = 23.594 kN by the standard's formula
    force = shoe_force_from_cylinder(
        diameter=0.203, pressure=360e3, efficiency=0.9, leverage_ratio=9.0, cylinders=2, shoes=8
    )
    assert force == pytest.approx(3.14159265 / 4 * 203**2 * 360 * 0.9 * 9.0 * 2 / (8 * 1e6) * 1e3, rel=1e-8)
    assert force == pytest.approx(23.594e3, rel=1e-3)
