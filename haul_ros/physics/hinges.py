"""Draft gear curves as sums of hinges, the form that the kernel evaluates.

Any piecewise linear curve with f(0) = 0 is ``f(x) = sum of slope[i] max(0, x - knot[i])``: tables,
slack (knots moved outwards), preload (a steep first piece) and bottoming (a steep last one) need
no cases of their own.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.draft_gear import Curve, DraftGear, SideCurves

Floats = NDArray[np.float64]


def _on_solid_ramp(curve: Curve, solid_stiffness: float) -> Curve:
    """The smaller of the curve and the steep line ``solid_stiffness * x``; they may meet more than once."""
    slopes = [(f1 - f0) / (x1 - x0) for (x0, f0), (x1, f1) in pairwise(curve)]
    if solid_stiffness <= slopes[-1]:
        raise ValueError(f"solid stiffness {solid_stiffness} N/m, must be above the last slope of the curve {curve}")
    ends = [*(x for x, _ in curve[1:-1]), float("inf")]  # the last slope goes on
    points = [(0.0, 0.0)]
    for (x, f), slope, end in zip(curve, slopes, ends, strict=False):
        if x > 0.0:
            points.append((x, min(f, solid_stiffness * x)))
        meeting = x + (f - solid_stiffness * x) / (solid_stiffness - slope) if slope != solid_stiffness else x
        if x < meeting < end:
            points.append((meeting, solid_stiffness * meeting))
    beyond = max(points[-1][0], curve[-1][0]) + 1.0
    points.append((beyond, curve[-1][1] + slopes[-1] * (beyond - curve[-1][0])))
    return tuple(points)


def _slopes_at(curve: Curve, knots: Floats) -> Floats:
    """Slope to the right of each knot [N/m]; the last slope goes on."""
    strokes = np.array([x for x, _ in curve])
    forces = np.array([f for _, f in curve])
    slopes = np.diff(forces) / np.diff(strokes)
    piece = np.clip(np.searchsorted(strokes, knots, side="right") - 1, 0, len(slopes) - 1)
    return np.asarray(slopes[piece], dtype=np.float64)


def side_hinges(gear: DraftGear, side: SideCurves) -> tuple[Floats, Floats, Floats]:
    """Knots [m] and slope changes [N/m] of the loading and the unloading curve of one side, each (h,)."""
    loading, unloading = side.loading, side.unloading
    if loading[0][1] > 0.0:
        # What the solid part has not taken it cannot give back, even if the table of unloading asks for more.
        loading, unloading = (_on_solid_ramp(curve, gear.solid_stiffness) for curve in (loading, unloading))
    knots = {x for x, _ in loading[:-1]} | {x for x, _ in unloading[:-1]}
    # A table that ends on its last slope has no knot at its last point.
    stops = np.isfinite(gear.maximum_stroke) and gear.bottoming_stiffness > 0.0
    if stops:
        knots.add(gear.maximum_stroke)
    at = np.array(sorted(knots))
    closed = np.where(at >= gear.maximum_stroke, gear.bottoming_stiffness, 0.0) if stops else 0.0
    changes = [np.diff(_slopes_at(curve, at) + closed, prepend=0.0) for curve in (loading, unloading)]
    return at + gear.slack / 2.0, changes[0], changes[1]


def stored_energy(gear: DraftGear, stroke: float) -> float:
    """Energy [J] that a gear gives back when it is let out slowly: the area under the mean of its curves.

    Let out at its transition speed or faster it gives back the area under its unloading curve; the rest is then
    dissipated on the way out.
    """
    side = gear.compression if stroke >= 0.0 else gear.tension
    knots, loading, unloading = side_hinges(gear, side)
    past = np.maximum(0.0, abs(stroke) - knots)
    return float(np.sum(0.25 * (loading + unloading) * past**2))
