"""One quantity of a run over two things that are varied, a panel for each point of a third; and published trends."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from numpy.typing import NDArray

from haul_ros.analysis.plotting import LOW_SIZE, new_figure
from haul_ros.studies.case import CaseResult
from haul_ros.studies.claims import Claim, peak
from haul_ros.studies.figures import UNITS, point_label
from haul_ros.studies.kinds.kind import Results, judged
from haul_ros.studies.kinds.needs import no_samples, separate_axes, unfit
from haul_ros.studies.sweep import Axis, Point, Sweep, Trend
from haul_ros.units import mps_to_kmh

Numbers = NDArray[np.float64]

_LEAST_CHANGE = 0.005
"""Relative change along an axis that is neither a rise nor a fall."""
_SHADE = "viridis"
_DARK = 0.55
"""Part of the range of colours below which they are dark, and text on them white."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """What is shown: its name with the unit, and how it comes from a result."""

    name: str
    of: Callable[[CaseResult], float]


QUANTITIES: Mapping[str, Quantity] = {
    "force": Quantity("largest coupler force [kN]", lambda result: peak(result) / 1e3),
    "released": Quantity("vehicles that released unasked", lambda result: float(result.released)),
    "unbraked": Quantity("vehicles that do not brake at the end", lambda result: float(result.unbraked)),
    "top_speed": Quantity("highest speed [km/h]", lambda result: mps_to_kmh(result.top_speed)),
    "distance": Quantity("distance of the head [m]", lambda result: result.distance),
}


def _needs(study: Sweep) -> None:
    no_samples(study)
    separate_axes(study)
    if len(study.scenarios) != 1 or not 2 <= len(study.axes) <= 3:
        raise unfit(study, "expected one scenario, and two or three things that are varied (over)")
    names = [axis.name for axis in study.axes]
    for trend in study.trends:
        if trend.along not in names:
            raise unfit(study, f"trends: along {trend.along}, expected one of {', '.join(names)}")


def values(study: Sweep, results: Results, quantity: str) -> Numbers:
    """A quantity by the points of the axes, an array with a dimension for each of them."""
    found = np.full([len(axis.points) for axis in study.axes], np.nan)
    for finished in results:
        at = tuple(axis.index(finished.case) for axis in study.axes)
        found[at] = QUANTITIES[quantity].of(finished.result)
    return found


def _steps(study: Sweep, results: Results, trend: Trend) -> tuple[int, int, int]:
    """How many steps from point to point along the axis go as the trend says, against it, and are there."""
    found = values(study, results, trend.quantity)
    along = [axis.name for axis in study.axes].index(trend.along)
    first, second = (np.moveaxis(found, along, 0)[part] for part in (slice(None, -1), slice(1, None)))
    change = (second - first) * (1.0 if trend.rises else -1.0)
    least = _LEAST_CHANGE * np.maximum(np.abs(first), np.abs(second))
    return int((change > least).sum()), int((change < -least).sum()), change.size


def judge(study: Sweep, results: Results) -> list[Claim]:
    """Each published trend, from point to point of its axis, all else equal: it holds if nothing is against it."""
    claims = []
    for trend in study.trends:
        with_it, against, of = _steps(study, results, trend)
        sense = "rises" if trend.rises else "falls"
        label = axis_label(next(axis for axis in study.axes if axis.name == trend.along))
        text = f"{_words(trend.quantity)} {sense} with {label} ({trend.source})"
        found = f"with it in {with_it}, against it in {against} of {of} steps"
        decided = with_it + against > 0
        claims.append(Claim(text, against == 0 if decided else None, found))
    found_values = values(study, results, study.quantity)
    low, high = float(np.nanmin(found_values)), float(np.nanmax(found_values))
    claims.append(Claim(_words(study.quantity), None, f"from {low:.0f} to {high:.0f}"))
    return claims


def _words(quantity: str) -> str:
    return QUANTITIES[quantity].name


def axis_label(axis: Axis) -> str:
    """An axis for people: ``electric brake [kN]`` for ``driver.electric_brake_kN``, that of variants by its name."""
    if axis.name not in axis.points[0].overrides:
        return axis.name
    quantity = axis.name.split(".")[-1]
    unit = next((suffix for suffix in UNITS if quantity.endswith(f"_{suffix}")), None)
    words = quantity.removesuffix(f"_{unit}").replace("_", " ")
    return f"{words} [{UNITS[unit]}]" if unit else words


def _title(axis: Axis, point: Point) -> str:
    """A point of the third axis: ``delay 2 s``, variants with the name of the axis before their own."""
    return point_label(axis, point) if axis.name in point.overrides else f"{axis.name} {point.name}"


def _tick(axis: Axis, point: Point) -> str:
    value = point.overrides.get(axis.name)
    if value is None:
        return point.name
    return f"{value:g}" if isinstance(value, (int, float)) else str(value)


def map_figure(study: Sweep, results: Results) -> Figure:
    """The quantity as shades with its numbers, and how many brakes released unasked where any did."""
    shown, released = values(study, results, study.quantity), values(study, results, "released")
    if len(study.axes) == 2:
        shown, released = shown[..., None], released[..., None]
    figure = new_figure(study.description, LOW_SIZE)
    panels = figure.subplots(1, shown.shape[2], sharey=True, squeeze=False)[0]
    framed = study.quantity not in ("released", "unbraked") and bool(released.any())
    low, high = float(np.nanmin(shown)), float(np.nanmax(shown))
    for number, axes in enumerate(panels):
        mesh = _draw(axes, study, shown[..., number], low, high)
        if framed:
            _mark_released(axes, released[..., number])
        if len(study.axes) == 3:
            axis = study.axes[2]
            axes.set_title(_title(axis, axis.points[number]), fontsize=10)
    panels[0].set_ylabel(axis_label(study.axes[1]))
    figure.colorbar(mesh, ax=list(panels), label=_words(study.quantity), pad=0.01)
    note = "\nin a frame: so many vehicles have released their brake unasked" if framed else ""
    figure.supxlabel(axis_label(study.axes[0]) + note, fontsize=10)
    return figure


def _draw(axes: Axes, study: Sweep, shown: Numbers, low: float, high: float) -> QuadMesh:
    columns, rows = (np.arange(length + 1) for length in shown.shape)
    mesh = axes.pcolormesh(columns, rows, shown.T, cmap=_SHADE, vmin=low, vmax=max(high, low + 1e-9))
    for (i, k), value in np.ndenumerate(shown):
        shade = "white" if value < low + _DARK * (high - low) else "black"
        axes.text(i + 0.5, k + 0.52, f"{value:.0f}", ha="center", va="bottom", fontsize=9, color=shade)
    first, second = study.axes[:2]
    axes.set_xticks(columns[:-1] + 0.5, [_tick(first, point) for point in first.points])
    axes.set_yticks(rows[:-1] + 0.5, [_tick(second, point) for point in second.points])
    return mesh


def _mark_released(axes: Axes, released: Numbers) -> None:
    for i, k in itertools.product(*map(range, released.shape)):
        if released[i, k] > 0.0:
            box = {"boxstyle": "round,pad=0.25", "fc": "white", "ec": "#D55E00", "lw": 1.5}
            axes.text(
                i + 0.5, k + 0.45, f"{released[i, k]:.0f}", ha="center", va="top", fontsize=8, color="black", bbox=box
            )


MAP = judged(_needs, judge, map_figure)
