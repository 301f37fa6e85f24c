"""Figures of studies: profiles along the train as in the paper, quantiles, the map, modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haul_ros.analysis.plotting import (
    DASHES,
    DIVERGING,
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
from haul_ros.physics.modal import Modes
from haul_ros.studies.case import CaseResult
from haul_ros.studies.claims import Results
from haul_ros.studies.sweep import PaperValues
from haul_ros.studies.tables import QUANTILES

_ALONG = "position along the train, 0 head .. 1 tail"


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
    stroke.set_xlabel(_ALONG)
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


def profiles_figure(results: Results, paper: Mapping[str, PaperValues], title: str) -> Figure:
    """|F| and stroke of several cases along the train; a star marks the paper's number where the case has its peak."""
    figure, force, stroke = force_and_stroke(title)
    for (name, result), (colour, dashes) in zip(results.items(), _styles(list(results)), strict=True):
        geared = result.geared
        force.plot(result.position[geared], result.force[geared] / 1e3, color=colour, ls=dashes, label=name)
        stroke.plot(result.position[geared], result.stroke[geared] * 1e3, color=colour, ls=dashes)
        text = paper.get(name, PaperValues())
        if text.force is not None:
            at = float(result.position[result.force.argmax()])
            force.plot([at], [text.force / 1e3], "*", ms=13, mfc=colour, mec="black", zorder=4)
    if any(text.force for text in paper.values()):
        force.plot([], [], "*", ms=13, mfc="white", mec="black", label="number in the paper's text")
    force.set_ylabel("peak |F| in draft gears [kN]")
    stroke.set_ylabel("peak stroke [mm]")
    stroke.set_xlabel(_ALONG)
    for axes in (force, stroke):
        frame_train(axes, 1.0)
        if len({tuple(result.locomotives) for result in results.values()}) == 1:
            mark_locomotives(axes, _axis_positions(next(iter(results.values()))))
    legend_below(stroke, force, columns=3)
    return figure


def _styles(names: Sequence[str]) -> list[tuple[FloatArray, str]]:
    """Colour and dashes of each line; of cases from two axes (``a, b``) the first gives the colour."""
    first = list(dict.fromkeys(name.partition(", ")[0] for name in names))
    second = list(dict.fromkeys(name.partition(", ")[2] for name in names))
    if len(first) * len(second) != len(names) or len(second) == 1:
        colours = shades(len(names))
        return [(colours[n], DASHES[n % len(DASHES)]) for n in range(len(names))]
    colours = shades(len(first), 0.6)
    parts = [name.partition(", ") for name in names]
    return [(colours[first.index(a)], DASHES[second.index(b) % len(DASHES)]) for a, _, b in parts]


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
    axes.set_xlabel(_ALONG)
    frame_train(axes, 1.0)
    legend_below(axes, axes, columns=4)
    return figure


def map_figure(
    maps: Mapping[str, FloatArray],
    wave_speeds: Sequence[float],
    build_up_times: Sequence[float],
    fitted: Mapping[str, tuple[str, float, float]],
    title: str,
) -> Figure:
    """Change of the peak by rigid pairs, (wave speeds, build-up times) by draft gear; blue: smaller, as the paper says.

    ``fitted`` are the places of the fitted parameter sets: name, wave speed [m/s] and build-up time
    [s] by draft gear.
    """
    figure = new_figure(title, LOW_SIZE)
    panels = np.atleast_1d(figure.subplots(1, len(maps), sharey=True))
    limit = max(float(np.abs(values).max()) for values in maps.values()) * 100.0
    for axes, (gear, values) in zip(panels, maps.items(), strict=True):
        mesh = axes.pcolormesh(
            np.arange(len(wave_speeds) + 1), np.arange(len(build_up_times) + 1), values.T * 100.0,
            cmap=DIVERGING, vmin=-limit, vmax=limit,
        )  # fmt: skip
        for (i, k), value in np.ndenumerate(values):
            shade = "white" if abs(value) * 100.0 > 0.6 * limit else "black"
            axes.text(i + 0.5, k + 0.5, f"{value * 100:+.0f}", ha="center", va="center", fontsize=8, color=shade)
        axes.set_title(gear, fontsize=10)
        axes.set_xticks(np.arange(len(wave_speeds)) + 0.5, [f"{v:g}" for v in wave_speeds])
        axes.set_yticks(np.arange(len(build_up_times)) + 0.5, [f"{t:g}" for t in build_up_times])
        axes.set_xlabel("brake wave speed [m/s]")
        _mark_fit(axes, fitted.get(gear), wave_speeds, build_up_times)
    panels[0].set_ylabel("build-up time [s]")
    figure.colorbar(mesh, ax=list(panels), label="peak with pairs over without [%]", pad=0.01)
    return figure


def _mark_fit(
    axes: Axes, fit: tuple[str, float, float] | None, wave_speeds: Sequence[float], times: Sequence[float]
) -> None:
    if fit is None:
        return
    name, speed, time = fit
    x, y = wave_speeds.index(speed) + 0.5, times.index(time) + 0.5
    axes.plot([x], [y], "s", ms=26, mfc="none", mec="black", mew=1.8)
    axes.annotate(name, (x, y), xytext=(0, 15), textcoords="offset points", ha="center", fontsize=8, weight="bold")


def modes_figure(modes: Mapping[str, Modes], shown: str, title: str) -> Figure:
    """Natural frequencies of several trains, and the first modes of one of them along the train."""
    figure = new_figure(title)
    spectrum, shapes = figure.subplots(2, 1, height_ratios=(3, 2))
    colours = shades(len(modes))
    for number, (name, found) in enumerate(modes.items()):
        order = np.arange(1, len(found.frequencies))
        spectrum.plot(order, found.frequencies[1:], color=colours[number], ls=DASHES[number % len(DASHES)], label=name)
    spectrum.set_xscale("log")
    spectrum.set_yscale("log")
    spectrum.set_xlabel("mode")
    spectrum.set_ylabel("natural frequency [Hz]")
    spectrum.grid(alpha=0.3, which="both")
    spectrum.legend(frameon=False)
    first = modes[shown]
    n = first.shapes.shape[1]
    for number in (1, 2, 3):
        shape = first.shapes[number] / np.abs(first.shapes[number]).max()
        label = f"mode {number}, {first.frequencies[number]:.3f} Hz"
        shapes.plot((np.arange(n) + 0.5) / n, shape, ls=DASHES[number - 1], label=label)
    shapes.set_xlim(0.0, 1.0)
    shapes.grid(alpha=0.3)
    shapes.set_ylabel(f"displacement,\n{shown}")
    shapes.set_xlabel(_ALONG)
    shapes.set_ylim(-1.1, 1.75)
    shapes.legend(frameon=False, ncol=3, loc="upper center")
    return figure
