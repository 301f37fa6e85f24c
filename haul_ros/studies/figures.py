"""Figures of studies: profiles along the train as in the paper, and quantiles of many cases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haul_ros.analysis.plotting import (
    DASHES,
    LOW_SIZE,
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
from haul_ros.studies.case import CaseResult, Finished
from haul_ros.studies.sweep import PaperValues, Sweep
from haul_ros.studies.tables import QUANTILES

ALONG = "position along the train, 0 head .. 1 tail"


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
        axes.set_ylim(top=axes.get_ylim()[1] * 1.08)
    legend_below(stroke, force, columns=3)
    return figure


def _mark_paper(axes: Axes, value: float | None, factor: float, position: float | None, unit: str) -> None:
    if value is None:
        return
    axes.axhline(value * factor, color="black", lw=1.0, ls=(0, (6, 3)))
    label = f"paper: {value * factor:g} {unit}" + (f" at {position:g}" if position is not None else "")
    at, to_left = (position, False) if position is not None else (0.99, True)
    if position is not None:
        axes.plot([position], [value * factor], "k*", ms=11)
    axes.annotate(
        label,
        (at, value * factor),
        textcoords="offset points",
        xytext=(0, 4),
        ha="right" if to_left else "center",
        va="bottom",
    )


def profiles_figure(study: Sweep, finished: Sequence[Finished[CaseResult]]) -> Figure:
    """|F| and stroke of several cases along the train; a star marks the paper's number where the case has its peak."""
    figure, force, stroke = force_and_stroke(study.description)
    for each, (colour, dashes) in zip(finished, _styles(study), strict=True):
        result, geared = each.result, each.result.geared
        force.plot(result.position[geared], result.force[geared] / 1e3, color=colour, ls=dashes, label=each.case.name)
        stroke.plot(result.position[geared], result.stroke[geared] * 1e3, color=colour, ls=dashes)
        text = study.paper_values(each.case)
        if text.force is not None:
            at = float(result.position[result.force.argmax()])
            force.plot([at], [text.force / 1e3], "*", ms=13, mfc=colour, mec="black", zorder=4)
    if any(text.force for text in study.paper):
        force.plot([], [], "*", ms=13, mfc="white", mec="black", label="number in the paper's text")
    force.set_ylabel("peak |F| in draft gears [kN]")
    stroke.set_ylabel("peak stroke [mm]")
    stroke.set_xlabel(ALONG)
    same_locomotives = len({tuple(each.result.locomotives) for each in finished}) == 1
    for axes in (force, stroke):
        frame_train(axes, 1.0)
        if same_locomotives:
            mark_locomotives(axes, _axis_positions(finished[0].result))
    legend_below(stroke, force, columns=3)
    return figure


def _styles(study: Sweep) -> list[tuple[FloatArray, str]]:
    """Colour and dashes of the line of each case; where several things are varied, the first gives the colour."""
    sizes = [size for size in (len(study.scenarios), *(len(axis.points) for axis in study.axes)) if size > 1]
    if len(sizes) < 2:
        return [(colour, DASHES[n % len(DASHES)]) for n, colour in enumerate(shades(len(study)))]
    rest = len(study) // sizes[0]
    return [(colour, DASHES[n % len(DASHES)]) for colour in shades(sizes[0], 0.6) for n in range(rest)]


def quantiles_figure(forces: FloatArray, position: FloatArray, title: str) -> Figure:
    """Quantiles over the cases of |F| [N], given as (n_cases, n_couplers), along the train."""
    figure = new_figure(title, LOW_SIZE)
    axes = figure.subplots()
    found = dict(zip(QUANTILES, np.quantile(forces, QUANTILES, axis=0) / 1e3, strict=True))
    for low, high, shade in ((0.0, 1.0, 0.15), (0.05, 0.95, 0.3), (0.25, 0.75, 0.5)):
        label = "all cases" if low == 0.0 else f"{low * 100:g} to {high * 100:g} %"
        axes.fill_between(position, found[low], found[high], color=TENSION_COLOUR, alpha=shade, lw=0, label=label)
    axes.plot(position, found[0.5], color="black", lw=1.2, label=f"median of {len(forces)} cases")
    axes.set_ylabel("peak |F| [kN]")
    axes.set_xlabel(ALONG)
    frame_train(axes, 1.0)
    legend_below(axes, axes, columns=4)
    return figure
