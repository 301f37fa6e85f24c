"""Figures of studies: profiles along the train as in the paper, and quantiles of many cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haul_ros.analysis.plotting import (
    DASHES,
    FORCE_LABEL,
    LOW_SIZE,
    STROKE_LABEL,
    TENSION_COLOUR,
    force_and_stroke,
    frame_train,
    legend_below,
    mark_locomotives,
    new_figure,
    plot_peak_forces,
    plot_peak_strokes,
    shades,
)
from haul_ros.model.sample import FloatArray
from haul_ros.studies.case import Case, CaseResult, Finished
from haul_ros.studies.sweep import Axis, PaperValues, Point, Sweep
from haul_ros.studies.tables import QUANTILES

ALONG = "position along the train, 0 head .. 1 tail"

UNITS = {
    "kN_per_mm": "kN/mm", "kmh": "km/h", "hz": "Hz", "mps": "m/s", "permille": "per mille", "kPa": "kPa", "kN": "kN",
    "kW": "kW", "mm": "mm", "ms": "ms", "t": "t", "m": "m", "s": "s",
}  # fmt: skip
"""Units in the names of keys, and how people write them."""

_ROOM_FOR_LABEL = 1.15
_EDGE = "<"
"""Marker of what the paper says without a place."""


def peaks_figure(study: Sweep, finished: Sequence[Finished[CaseResult]]) -> Figure:
    """Peaks along the train of all cases of a study."""
    if len(finished) == 1:
        (one,) = finished
        return single_figure(one.result, study.paper_values(one.case), study.description)
    return profiles_figure(study, finished)


def _axis_positions(result: CaseResult) -> list[float]:
    """Where the locomotives lie along the train, 0 head .. 1 tail."""
    return [(int(vehicle) + 0.5) / (len(result.geared) + 1) for vehicle in result.locomotives]


def single_figure(result: CaseResult, paper: PaperValues, title: str) -> Figure:
    """Largest compression, tension and |F| of one case along the train, strokes below, the paper's numbers marked."""
    figure, force, stroke = force_and_stroke(title)
    plot_peak_forces(force, result.position, result.extremes)
    plot_peak_strokes(stroke, result.position, result.extremes, result.geared)
    _mark_paper(force, paper.force, 1e-3, paper.position, "kN")
    _mark_paper(stroke, paper.stroke, 1e3, None, "mm")
    stroke.set_xlabel(ALONG)
    for axes in (force, stroke):
        frame_train(axes, 1.0)
        mark_locomotives(axes, _axis_positions(result))
    legend_below(figure, force, columns=3)
    return figure


def _mark_paper(axes: Axes, value: float | None, factor: float, position: float | None, unit: str) -> None:
    if value is None:
        return
    axes.axhline(value * factor, color="black", lw=1.0, ls=(0, (6, 3)))
    label = f"paper: {value * factor:g} {unit}" + (f" at {position:g}" if position is not None else "")
    if position is not None:
        axes.plot([position], [value * factor], "k*", ms=11)
    at, side = (position, "center") if position is not None else (0.99, "right")
    axes.annotate(label, (at, value * factor), textcoords="offset points", xytext=(0, 4), ha=side, va="bottom")
    axes.set_ylim(top=max(axes.get_ylim()[1], value * factor * _ROOM_FOR_LABEL))


def profiles_figure(study: Sweep, finished: Sequence[Finished[CaseResult]]) -> Figure:
    """|F| and stroke of several cases along the train.

    Where several things are varied, each value of the first has panels of its own. The paper's text names forces and
    not where they are: they are marked at the edge.
    """
    columns = _columns(study, finished)
    figure = new_figure(study.description)
    grid = figure.subplots(2, len(columns), sharex=True, sharey="row", squeeze=False, height_ratios=(3, 2))
    for (name, cases), (force, stroke) in zip(columns.items(), grid.T, strict=True):
        force.set_title(name, fontsize=10)
        _draw_profiles(study, cases, force, stroke)
        stroke.set_xlabel(ALONG)
    for axes in grid.flat:  # which share their heights, so after all of them
        frame_train(axes, 1.0)
    grid[0, 0].set_ylabel(FORCE_LABEL)
    grid[1, 0].set_ylabel(STROKE_LABEL)
    if any(text.force for text in study.paper):
        label = "in the paper's text, which names no place"
        grid[0, 0].plot([], [], ls="", marker=_EDGE, ms=9, mfc="white", mec="black", label=label)
    legend_below(figure, grid[0, 0], columns=3)
    return figure


def _draw_profiles(study: Sweep, cases: Sequence[Finished[CaseResult]], force: Axes, stroke: Axes) -> None:
    for number, (each, colour) in enumerate(zip(cases, shades(len(cases)), strict=True)):
        result, geared, dashes = each.result, each.result.geared, DASHES[number % len(DASHES)]
        labels = _labels(study, each.case)
        label = ", ".join(labels[1:] or labels)
        force.plot(result.position[geared], result.force[geared] / 1e3, color=colour, ls=dashes, label=label)
        stroke.plot(result.position[geared], result.stroke[geared] * 1e3, color=colour, ls=dashes)
        text = study.paper_values(each.case)
        if text.force is not None:
            force.plot([1.0], [text.force / 1e3], marker=_EDGE, ms=9, mfc=colour, mec="black", zorder=4, clip_on=False)
    if len({tuple(each.result.locomotives) for each in cases}) == 1:
        for axes in (force, stroke):
            mark_locomotives(axes, _axis_positions(cases[0].result))


def _columns(study: Sweep, finished: Sequence[Finished[CaseResult]]) -> Mapping[str, Sequence[Finished[CaseResult]]]:
    """Cases by what is varied first, by its label, if more is varied; else all of them under none."""
    found: dict[str, list[Finished[CaseResult]]] = {}
    for each in finished:
        first, *rest = _labels(study, each.case)
        found.setdefault(first if rest else "", []).append(each)
    return found


def _labels(study: Sweep, case: Case) -> list[str]:
    """A case in words, by what is varied: the scenario if there are several, then axes of more than one point."""
    scenario = [case.scenario_name] if len(study.scenarios) > 1 else []
    axes = [axis for axis in study.axes if len(axis.points) > 1]
    return [*scenario, *(point_label(axis, axis.points[axis.index(case)]) for axis in axes)] or [case.name]


def point_label(axis: Axis, point: Point) -> str:
    """A point of an axis for people: ``delay 0.5 s`` for ``radio.default.delay_s=0.5``, variants by their name."""
    if axis.name not in point.overrides:
        return point.name
    *parents, quantity = axis.name.split(".")
    owner = [parents[1]] if len(parents) > 1 and parents[1] != "default" else []
    unit = next((suffix for suffix in UNITS if quantity.endswith(f"_{suffix}")), None)
    words = quantity.removesuffix(f"_{unit}").replace("_", " ")
    value = point.overrides[axis.name]
    number = f"{value:g}" if isinstance(value, float) else str(value)
    return " ".join([*owner, words, number, *([UNITS[unit]] if unit else [])])


def quantiles_figure(forces: FloatArray, position: FloatArray, title: str) -> Figure:
    """Quantiles over the cases of |F| [N], given as (n_cases, n_couplers), along the train."""
    figure = new_figure(title, LOW_SIZE)
    axes = figure.subplots()
    found = dict(zip(QUANTILES, np.quantile(forces, QUANTILES, axis=0) / 1e3, strict=True))
    for low, high, shade in ((0.0, 1.0, 0.15), (0.05, 0.95, 0.3), (0.25, 0.75, 0.5)):
        label = "all cases" if low == 0.0 else f"{low * 100:g} to {high * 100:g} %"
        axes.fill_between(position, found[low], found[high], color=TENSION_COLOUR, alpha=shade, lw=0, label=label)
    axes.plot(position, found[0.5], color="black", lw=1.2, label=f"median of {len(forces)} cases")
    axes.set_ylabel(FORCE_LABEL)
    axes.set_xlabel(ALONG)
    frame_train(axes, 1.0)
    legend_below(figure, axes, columns=4)
    return figure
