"""Draft gears from a checked document, and whether their curves can be those of a gear."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import Any

from haul_ros.model.draft_gear import Curve, DraftGear, SideCurves
from haul_ros.scenario.document import Document, KeyPath

_KN_PER_MM = 1e6  # in N/m
_ROUNDING = 1e-9

DEFAULT_SOLID_STIFFNESS = 250.0 * _KN_PER_MM
"""Slope on which a preload is taken up [N/m] if none is given; assumed, that of a steel structure under a
wedge gear that has not begun to slide."""


def _linear(preload: float, stiffness: float) -> Curve:
    return (0.0, preload), (1.0, preload + stiffness)


def _table(points: Iterable[tuple[float, float]]) -> Curve:
    return tuple((stroke / 1e3, force * 1e3) for stroke, force in points)


def _force(curve: Curve, stroke: float) -> float:
    """Force [N] on a curve at a stroke [m], straight beyond the last point."""
    right = next((i for i in range(1, len(curve)) if stroke <= curve[i][0]), len(curve) - 1)
    (x0, f0), (x1, f1) = curve[right - 1], curve[right]
    return f0 + (f1 - f0) * (stroke - x0) / (x1 - x0)


def _check_table(document: Document, path: KeyPath) -> None:
    points = document.at(path)
    if points[0][0] != 0:
        raise document.refusal((*path, 0, 0), "the first stroke must be 0")
    for index, ((x0, f0), (x1, f1)) in enumerate(pairwise(points), start=1):
        if x1 <= x0:
            raise document.refusal((*path, index, 0), f"strokes must rise: must be above {x0}")
        if f1 < f0:
            raise document.refusal((*path, index, 1), f"forces must not fall: must be at least {f0}")
    if points[-1][1] == 0:
        raise document.refusal((*path, len(points) - 1, 1), "the last force must be above 0")


def _last_slope(curve: Curve) -> float:
    """Slope [N/m] that goes on beyond the last point."""
    (x0, f0), (x1, f1) = curve[-2:]
    return (f1 - f0) / (x1 - x0)


def _strokes_that_tell(curves: SideCurves) -> list[float]:
    """Strokes [m] at which the order of two curves shows: all points, and one beyond where the last slopes cross."""
    strokes = sorted({stroke for curve in (curves.loading, curves.unloading) for stroke, _ in curve})
    last, loading, unloading = strokes[-1], _last_slope(curves.loading), _last_slope(curves.unloading)
    if unloading > loading * (1.0 + _ROUNDING):
        gap = max(_force(curves.loading, last) - _force(curves.unloading, last), 0.0)
        strokes.append(2.0 * (last + gap / (unloading - loading)))
    return strokes


def _check_order(document: Document, path: KeyPath, curves: SideCurves) -> None:
    """Refuse a gear that gives back more force than it took: unloading above loading at any stroke, however large."""
    for stroke in _strokes_that_tell(curves):
        loading, unloading = _force(curves.loading, stroke), _force(curves.unloading, stroke)
        if unloading > loading * (1.0 + _ROUNDING):
            forces = f"{unloading / 1e3:g} kN, above loading, {loading / 1e3:g} kN"
            raise document.error((*path, "unloading"), f"at stroke {stroke * 1e3:g} mm it is {forces}")


def _side(document: Document, path: KeyPath) -> SideCurves:
    entry = document.at(path)
    if "loading" in entry:
        _check_table(document, (*path, "loading"))
        _check_table(document, (*path, "unloading"))
        curves = SideCurves(_table(entry["loading"]), _table(entry["unloading"]))
        _check_order(document, path, curves)
        return curves
    loading = entry["loading_stiffness_kN_per_mm"]
    unloading = entry["unloading_stiffness_kN_per_mm"]
    if unloading > loading:
        key = (*path, "unloading_stiffness_kN_per_mm")
        raise document.refusal(key, f"must be at most loading_stiffness_kN_per_mm, {loading}")
    preload = entry.get("preload_kN", 0.0) * 1e3
    return SideCurves(
        _linear(preload, loading * _KN_PER_MM), _linear(preload * unloading / loading, unloading * _KN_PER_MM)
    )


def _steepest(curve: Curve) -> float:
    return max((f1 - f0) / (x1 - x0) for (x0, f0), (x1, f1) in pairwise(curve))


def _check_solid_stiffness(document: Document, path: KeyPath, solid: float, steepest: float) -> None:
    """Refuse a preload that is taken up no steeper than the gear itself."""
    if solid <= steepest:
        given = "solid_stiffness_kN_per_mm" in document.at(path)
        given_text = f"solid_stiffness_kN_per_mm = {solid / _KN_PER_MM:g}{'' if given else ' by default'}"
        slope = f"{steepest / _KN_PER_MM:g}, the steepest slope of a preloaded loading curve"
        raise document.error(path, f"{given_text}, must be above {slope}")


def _draft_gear(document: Document, name: str) -> DraftGear:
    path = ("couplers", name)
    entry: dict[str, Any] = document.at(path)
    compression = _side(document, path)
    tension = _side(document, (*path, "tension")) if "tension" in entry else compression
    optional: dict[str, float] = {}
    if "maximum_stroke_mm" in entry:
        optional["maximum_stroke"] = entry["maximum_stroke_mm"] / 1e3
    if "strength_kN" in entry:
        optional["strength"] = entry["strength_kN"] * 1e3
    if "bottoming_stiffness_kN_per_mm" in entry:
        optional["bottoming_stiffness"] = entry["bottoming_stiffness_kN_per_mm"] * _KN_PER_MM
    solid_stiffness = entry.get("solid_stiffness_kN_per_mm", DEFAULT_SOLID_STIFFNESS / _KN_PER_MM) * _KN_PER_MM
    preloaded = [side.loading for side in (compression, tension) if side.loading[0][1] > 0]
    if preloaded:
        _check_solid_stiffness(document, path, solid_stiffness, max(map(_steepest, preloaded)))
    if preloaded or "solid_stiffness_kN_per_mm" in entry:
        optional["solid_stiffness"] = solid_stiffness
    return DraftGear(
        name=name,
        compression=compression,
        tension=tension,
        transition_speed=float(entry["transition_speed_mps"]),
        slack=entry.get("slack_mm", 0.0) / 1e3,
        **optional,
    )


def draft_gears(document: Document) -> dict[str, DraftGear]:
    """All couplers of a complete scenario by name.

    Raises
    ------
    ScenarioError
        Curves that do not start at stroke 0, do not rise, or unload above loading.
    """
    return {name: _draft_gear(document, name) for name in document.data["couplers"]}
