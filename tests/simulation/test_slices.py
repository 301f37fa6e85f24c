from __future__ import annotations

import pytest

from haul_ros.simulation.slices import LONGEST, Slices


@pytest.mark.parametrize("cost", [1e-6, 1e-4, 1e-2, 1.0])
def test_calls_grow_or_shrink_until_they_take_about_as_long_as_they_may(cost: float) -> None:
    slices = Slices()
    for _ in range(40):
        slices.took(slices.steps, slices.steps * cost)
    assert slices.steps * cost <= max(LONGEST, cost)
    assert slices.steps * cost >= LONGEST / 5.0


def test_short_calls_say_nothing() -> None:
    slices = Slices()
    before = slices.steps
    slices.took(1, 1e-6)
    assert slices.steps == before
