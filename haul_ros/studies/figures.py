"""Figures of studies: profiles along the train as in the paper, quantiles, the map, modes."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation
from PIL import Image

from haul_ros.analysis.plots import COMPRESSION_COLOUR, ENVELOPE_COLOUR, LOCOMOTIVE_COLOUR, TENSION_COLOUR
from haul_ros.model.sample import FloatArray
from haul_ros.physics.modal import Modes
from haul_ros.studies.case import CaseResult
from haul_ros.studies.claims import Results
from haul_ros.studies.sweep import PaperValues
from haul_ros.studies.tables import QUANTILES

DPI = 100
_COLOURS = 128
_SIZE = (9.0, 6.0)
"""Width and height [inch]."""

_LABEL_HEIGHT = 0.45
"""Of the numbers and the label under the axes [inch]."""

_LINES = ("-", "--", "-.", ":")
_ALONG = "position along the train, 0 head .. 1 tail"


def save_png(figure: Figure, path: Path) -> None:
    """Write a figure as a small PNG of few colours; needs no display."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI)
    Image.open(buffer).convert("RGB").quantize(_COLOURS).save(path, format="png", optimize=True)


def _place(vehicle: int, n_vehicles: int) -> float:
    return (vehicle + 0.5) / n_vehicles


def _mark_locomotives(axes: Axes, result: CaseResult) -> None:
    for vehicle in result.locomotives:
        axes.axvline(_place(int(vehicle), len(result.geared) + 1), color=LOCOMOTIVE_COLOUR, lw=0.8, ls=":", zorder=0)


def _legend_below(lowest: Axes, lines: Axes, columns: int) -> None:
    """Names of lines under the lowest axes and their label, which the layout makes room for."""
    handles, labels = lines.get_legend_handles_labels()
    below = lowest.transAxes + ScaledTranslation(0.0, -_LABEL_HEIGHT, lowest.figure.dpi_scale_trans)
    lowest.legend(
        handles,
        labels,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=below,
        ncol=columns,
        frameon=False,
        borderaxespad=0.0,
    )


def _trim(axes: Axes) -> None:
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)


def single_figure(result: CaseResult, paper: PaperValues, title: str) -> Figure:
    """Largest compression, tension and |F| of one case along the train, strokes below, the paper's numbers marked."""
    figure = Figure(figsize=_SIZE, layout="constrained")
    force, stroke = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    figure.suptitle(title)
    extremes, x = result.extremes, result.position
    force.fill_between(x, result.force / 1e3, color=ENVELOPE_COLOUR, lw=0, label="|F|, larger of both")
    force.plot(x, extremes.compression / 1e3, color=COMPRESSION_COLOUR, label="compression (buff)")
    force.plot(x, extremes.tension / 1e3, color=TENSION_COLOUR, ls="--", label="tension (draft)")
    stroke.plot(x, extremes.compression_stroke * 1e3, color=COMPRESSION_COLOUR)
    stroke.plot(x, extremes.tension_stroke * 1e3, color=TENSION_COLOUR, ls="--")
    _mark_paper(force, paper.force, 1e-3, paper.position, "kN")
    _mark_paper(stroke, paper.stroke, 1e3, None, "mm")
    force.set_ylabel("peak coupler force [kN]")
    stroke.set_ylabel("peak stroke [mm]")
    stroke.set_xlabel(_ALONG)
    for axes in (force, stroke):
        _trim(axes)
        _mark_locomotives(axes, result)
        axes.set_ylim(top=axes.get_ylim()[1] * 1.08)
    _legend_below(stroke, force, columns=3)
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
    figure = Figure(figsize=_SIZE, layout="constrained")
    force, stroke = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    figure.suptitle(title)
    for (name, result), (colour, dashes) in zip(results.items(), _styles(list(results)), strict=True):
        line = {"color": colour, "ls": dashes}
        geared = result.geared
        force.plot(result.position[geared], result.force[geared] / 1e3, label=name, **line)
        stroke.plot(result.position[geared], result.stroke[geared] * 1e3, **line)
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
        _trim(axes)
        if len({tuple(result.locomotives) for result in results.values()}) == 1:
            _mark_locomotives(axes, next(iter(results.values())))
    _legend_below(stroke, force, columns=3)
    return figure


def _styles(names: Sequence[str]) -> list[tuple[object, str]]:
    """Colour and dashes of each line; of cases from two axes (``a, b``) the first gives the colour."""
    first = list(dict.fromkeys(name.partition(", ")[0] for name in names))
    second = list(dict.fromkeys(name.partition(", ")[2] for name in names))
    if len(first) * len(second) != len(names) or len(second) == 1:
        colours = colormaps["viridis"](np.linspace(0.0, 0.8, len(names)))
        return [(colours[n], _LINES[n % len(_LINES)]) for n in range(len(names))]
    colours = colormaps["viridis"](np.linspace(0.0, 0.6, len(first)))
    parts = [name.partition(", ") for name in names]
    return [(colours[first.index(a)], _LINES[second.index(b) % len(_LINES)]) for a, _, b in parts]


def quantiles_figure(forces: FloatArray, position: FloatArray, title: str) -> Figure:
    """Quantiles over the cases of |F| [N], given as (n_cases, n_couplers), along the train."""
    figure = Figure(figsize=(9.0, 4.5), layout="constrained")
    axes = figure.subplots()
    figure.suptitle(title)
    found = dict(zip(QUANTILES, np.quantile(forces, QUANTILES, axis=0) / 1e3, strict=True))
    for low, high, shade in ((0.0, 1.0, 0.15), (0.05, 0.95, 0.3), (0.25, 0.75, 0.5)):
        label = "all cases" if low == 0.0 else f"{low * 100:g} to {high * 100:g} %"
        axes.fill_between(position, found[low], found[high], color=TENSION_COLOUR, alpha=shade, lw=0, label=label)
    axes.plot(position, found[0.5], color="black", lw=1.2, label=f"median of {len(forces)} cases")
    axes.set_ylabel("peak |F| [kN]")
    axes.set_xlabel(_ALONG)
    _trim(axes)
    _legend_below(axes, axes, columns=4)
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
    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(maps), sharey=True))
    figure.suptitle(title)
    limit = max(float(np.abs(values).max()) for values in maps.values()) * 100.0
    for axes, (gear, values) in zip(panels, maps.items(), strict=True):
        mesh = axes.pcolormesh(
            np.arange(len(wave_speeds) + 1), np.arange(len(build_up_times) + 1), values.T * 100.0,
            cmap="RdBu_r", vmin=-limit, vmax=limit,
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
    figure = Figure(figsize=_SIZE, layout="constrained")
    spectrum, shapes = figure.subplots(2, 1, height_ratios=(3, 2))
    figure.suptitle(title)
    colours = colormaps["viridis"](np.linspace(0.0, 0.8, len(modes)))
    for number, (name, found) in enumerate(modes.items()):
        order = np.arange(1, len(found.frequencies))
        spectrum.plot(order, found.frequencies[1:], color=colours[number], ls=_LINES[number % len(_LINES)], label=name)
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
        shapes.plot((np.arange(n) + 0.5) / n, shape, ls=_LINES[number - 1], label=label)
    shapes.set_xlim(0.0, 1.0)
    shapes.grid(alpha=0.3)
    shapes.set_ylabel(f"displacement,\n{shown}")
    shapes.set_xlabel(_ALONG)
    shapes.set_ylim(-1.1, 1.75)
    shapes.legend(frameon=False, ncol=3, loc="upper center")
    return figure
