"""Resolutions that are powers of two."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haul_ros.model.recording_plan import UNITS, Rounding, power_of_two


@given(st.floats(1e-12, 1e12))
def test_a_resolution_becomes_the_largest_power_of_two_not_above_it(resolution: float) -> None:
    power = power_of_two(resolution)
    assert power <= resolution < 2.0 * power
    assert math.frexp(power)[0] == 0.5  # one bit


@pytest.mark.parametrize("exponent", [-30, -1, 0, 1, 20])
def test_a_power_of_two_stays_and_what_is_just_below_it_halves(exponent: int) -> None:
    power = 2.0**exponent
    assert power_of_two(power) == power
    assert power_of_two(math.nextafter(power, 0.0)) == power / 2.0


def test_no_resolution_stays_none() -> None:
    assert power_of_two(0.0) == 0.0
    assert Rounding().resolutions() == {}


@pytest.mark.parametrize("resolution", [-1.0, math.inf, math.nan])
def test_what_is_no_resolution_is_refused(resolution: float) -> None:
    with pytest.raises(ValueError, match="expected 0 or a positive number"):
        power_of_two(resolution)


@pytest.mark.parametrize("quantity", UNITS)
def test_a_rounding_takes_powers_of_two_only(quantity: str) -> None:
    values = {quantity: 0.25}
    assert Rounding(**values).resolutions() == values
    with pytest.raises(ValueError, match=f"resolution of {quantity} = 0.3: expected a power of two"):
        Rounding(**{quantity: 0.3})
