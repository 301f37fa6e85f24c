"""Draft gear curves as hinges against the tables they come from."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.model.draft_gear import Curve, DraftGear, SideCurves
from haul_ros.physics.hinges import side_hinges, stored_energy
from tests.physics.physics_cases import linear, linear_gear, side_force

INF = float("inf")


def _hinge_force(knots: np.ndarray, slopes: np.ndarray, depth: float) -> float:
    return float(np.sum(slopes * np.maximum(0.0, depth - knots)))


@st.composite
def _gears(draw: st.DrawFn) -> DraftGear:
    """Rising tables, unloading below loading, with or without preload, slack and bottoming."""
    n = draw(st.integers(2, 6))
    widths = draw(st.lists(st.floats(2e-3, 30e-3), min_size=n - 1, max_size=n - 1))
    rises = draw(st.lists(st.floats(1e3, 5e5), min_size=n - 1, max_size=n - 1))
    preload = draw(st.one_of(st.just(0.0), st.floats(1e3, 1e5)))
    share = draw(st.floats(0.05, 1.0))
    strokes = np.concatenate(([0.0], np.cumsum(widths)))
    forces = preload + np.concatenate(([0.0], np.cumsum(rises)))
    loading: Curve = tuple((float(x), float(f)) for x, f in zip(strokes, forces, strict=True))
    unloading: Curve = tuple((x, share * f) for x, f in loading)
    if n > 3 and draw(st.booleans()):
        unloading = unloading[:1] + unloading[2:]  # tables need not have the same strokes
        unloading = tuple((x, 0.5 * f) for x, f in unloading)
    side = SideCurves(loading, unloading)
    return DraftGear(
        "drawn",
        side,
        side,
        transition_speed=0.01,
        slack=draw(st.one_of(st.just(0.0), st.floats(1e-3, 40e-3))),
        maximum_stroke=draw(st.one_of(st.just(INF), st.floats(10e-3, 90e-3))),
        bottoming_stiffness=5e8,
        solid_stiffness=1e9,
    )


@settings(deadline=None)
@given(gear=_gears(), depths=st.lists(st.floats(0.0, 0.3), min_size=1, max_size=20))
def test_hinges_give_the_tables_with_slack_preload_and_bottoming(gear: DraftGear, depths: list[float]) -> None:
    knots, loading, unloading = side_hinges(gear, gear.compression)
    assert np.all(np.diff(knots) >= 0.0)
    for depth in depths:
        for curve, slopes in ((gear.compression.loading, loading), (gear.compression.unloading, unloading)):
            expected = side_force(gear, curve, depth)
            assert _hinge_force(knots, slopes, depth) == pytest.approx(expected, rel=1e-9, abs=1e-3)


@settings(deadline=None)
@given(gear=_gears(), depth=st.floats(0.0, 0.2), draft=st.booleans())
def test_stored_energy_is_the_area_under_the_mean_of_both_curves(gear: DraftGear, depth: float, draft: bool) -> None:
    x = np.linspace(0.0, depth, 201)
    curves = (gear.compression.loading, gear.compression.unloading)
    forces = np.array([0.5 * sum(side_force(gear, curve, float(d)) for curve in curves) for d in x])
    area = float(np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(x)))
    # The area by 200 trapezia misses a little at each kink: half a step's width times the change of force in it.
    missed = 6.0 * 1e9 * (depth / 200.0) ** 2 / 8.0
    assert stored_energy(gear, -depth if draft else depth) == pytest.approx(area, rel=1e-9, abs=missed + 1e-9)


def test_stored_energy_of_a_linear_gear_is_half_its_mean_stiffness_times_stroke_squared_on_its_own_side() -> None:
    gear = DraftGear("x", SideCurves(linear(3e7), linear(1e7)), SideCurves(linear(2e7), linear(4e6)), 0.01)
    assert stored_energy(gear, 0.02) == pytest.approx(0.5 * 2e7 * 0.02**2)
    assert stored_energy(gear, -0.02) == pytest.approx(0.5 * 12e6 * 0.02**2)


def test_a_linear_gear_is_one_hinge_at_stroke_zero() -> None:
    gear = linear_gear(3e7, 9e6)
    knots, loading, unloading = side_hinges(gear, gear.tension)
    assert (knots.tolist(), loading.tolist(), unloading.tolist()) == ([0.0], [3e7], [9e6])


def test_the_last_slope_of_a_table_goes_on() -> None:
    table: Curve = ((0.0, 0.0), (0.01, 1e5), (0.02, 4e5))
    gear = DraftGear("x", SideCurves(table, table), SideCurves(table, table), 0.01)
    knots, loading, _ = side_hinges(gear, gear.compression)
    assert _hinge_force(knots, loading, 0.03) == pytest.approx(7e5)


@pytest.mark.parametrize(
    ("loading", "unloading"),
    [
        (((0.0, 300e3), (1e-3, 310e3)), ((0.0, 0.0), (0.5e-3, 300e3), (1e-3, 300e3))),
        (((0.0, 300e3), (1e-3, 400e3)), ((0.0, 1e3), (0.5e-3, 350e3), (1e-3, 400e3))),
        # Above, below, above and below the solid slope again.
        (
            ((0.0, 400e3), (4e-3, 900e3)),
            ((0.0, 0.0), (0.5e-3, 200e3), (1e-3, 210e3), (1.4e-3, 390e3), (2e-3, 400e3), (3e-3, 410e3)),
        ),
    ],
)
def test_unloading_of_a_preloaded_gear_is_nowhere_above_what_its_solid_part_has_taken(
    loading: Curve, unloading: Curve
) -> None:
    side = SideCurves(loading, unloading)
    gear = DraftGear("x", side, side, 0.01, solid_stiffness=2.5e8)
    knots, up, down = side_hinges(gear, side)
    for depth in [*np.linspace(0.0, 6e-3, 601), 1.0, 100.0]:
        assert _hinge_force(knots, down, depth) <= _hinge_force(knots, up, depth) * (1.0 + 1e-12)
        for curve, slopes in ((loading, up), (unloading, down)):
            assert _hinge_force(knots, slopes, depth) == pytest.approx(side_force(gear, curve, float(depth)), abs=1e-3)


@pytest.mark.parametrize("solid_stiffness", [1e7, 3e7])
def test_a_solid_stiffness_that_never_reaches_the_curve_is_refused(solid_stiffness: float) -> None:
    side = SideCurves(linear(3e7, preload=50e3), linear(1e7, preload=20e3))
    gear = DraftGear("x", side, side, 0.01, solid_stiffness=solid_stiffness)
    with pytest.raises(ValueError, match="solid stiffness"):
        side_hinges(gear, side)
