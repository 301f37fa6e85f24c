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


def _with_preload_ramp(curve: Curve, solid_stiffness: float) -> Curve:
    """Replace a jump at stroke 0 by the steep line ``solid_stiffness * x`` up to where it meets the curve."""
    if curve[0][1] == 0.0:
        return curve
    for n, ((x0, f0), (x1, f1)) in enumerate(pairwise(curve), start=2):
        slope = (f1 - f0) / (x1 - x0)
        if solid_stiffness <= slope:
            break
        meeting = (f0 - slope * x0) / (solid_stiffness - slope)
        if meeting <= x1 or n == len(curve):  # the last slope goes on
            force = solid_stiffness * meeting
            rest = [point for point in curve if point[0] > meeting] or [(meeting + 1.0, force + slope)]
            return ((0.0, 0.0), (meeting, force), *rest)
    raise ValueError(f"solid stiffness {solid_stiffness} N/m, must be above the slope of the curve {curve}")


def _slopes_at(curve: Curve, knots: Floats) -> Floats:
    """Slope to the right of each knot [N/m]; the last slope goes on."""
    strokes = np.array([x for x, _ in curve])
    forces = np.array([f for _, f in curve])
    slopes = np.diff(forces) / np.diff(strokes)
    piece = np.clip(np.searchsorted(strokes, knots, side="right") - 1, 0, len(slopes) - 1)
    return np.asarray(slopes[piece], dtype=np.float64)


def side_hinges(gear: DraftGear, side: SideCurves) -> tuple[Floats, Floats, Floats]:
    """Knots [m] and slope changes [N/m] of the loading and the unloading curve of one side, each (h,)."""
    loading = _with_preload_ramp(side.loading, gear.solid_stiffness)
    unloading = _with_preload_ramp(side.unloading, gear.solid_stiffness)
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
