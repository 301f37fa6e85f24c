"""The house style of pictures: colours, sizes, and what figures of runs and of studies have in common."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from haul_ros.analysis.envelopes import largest_force
from haul_ros.errors import one_line
from haul_ros.files import create_file
from haul_ros.model.sample import CouplerExtremes, FloatArray

# Okabe and Ito's palette, to be told apart by colour-blind readers and in greyscale
COMPRESSION_COLOUR = "#D55E00"
TENSION_COLOUR = "#0072B2"
ENVELOPE_COLOUR = "#C8C8C8"
LOCOMOTIVE_COLOUR = "#404040"
HEAD_COLOUR = "#000000"
TAIL_COLOUR = "#009E73"
DIVERGING = "RdBu_r"
"""Colours of values of both signs."""
FORCE_LABEL = "peak coupler force [kN]"
STROKE_LABEL = "peak draft gear stroke [mm]"
DASHES = ("-", "--", "-.", ":")

DPI = 160
SIZE = (10.0, 6.8)
"""Width and height [inch] of two panels, one above the other."""
_LONGEST_TITLE = 200
"""Characters."""
LOW_SIZE = (10.0, 4.8)
"""The same of one panel, or of several side by side."""


def shown_title(title: str) -> str:
    """What of a text, which may come from a file, has room above a picture."""
    return one_line(title, _LONGEST_TITLE)


def new_figure(title: str, size: tuple[float, float] = SIZE) -> Figure:
    """An empty figure, which finds room for all that is put into it."""
    figure = Figure(figsize=size, layout="constrained")
    figure.suptitle(shown_title(title))
    return figure


def force_and_stroke(title: str) -> tuple[Figure, Axes, Axes]:
    """A figure with a panel of forces above one of strokes."""
    figure = new_figure(title)
    force, stroke = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    return figure, force, stroke


def save_png(figure: Figure, path: Path) -> None:
    """Write a figure as PNG; needs no display."""
    with create_file(path) as file:
        figure.savefig(file, format="png", dpi=DPI)


def shades(count: int, darkest_to: float = 0.8) -> NDArray[np.float64]:
    """So many colours (count, 4) from dark to light that also differ in greyscale."""
    colours: NDArray[np.float64] = colormaps["viridis"](np.linspace(0.0, darkest_to, count))
    return colours


def frame_train(axes: Axes, tail: float) -> None:
    """Axes along the train, from 0 at the head, and of magnitudes upwards."""
    axes.set_xlim(0.0, tail)
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)


def mark_locomotives(axes: Axes, positions: Iterable[float]) -> None:
    """Dotted lines at axis positions."""
    for position in positions:
        axes.axvline(position, color=LOCOMOTIVE_COLOUR, lw=0.8, ls=":", zorder=1.5)  # over areas, under lines


def plot_peak_forces(axes: Axes, x: FloatArray, extremes: CouplerExtremes) -> None:
    """Largest compression, tension and |F| [kN] of the couplers at axis positions ``x`` (n_couplers,)."""
    axes.fill_between(x, largest_force(extremes) / 1e3, color=ENVELOPE_COLOUR, lw=0, label="|F|, larger of both")
    axes.plot(x, extremes.compression / 1e3, color=COMPRESSION_COLOUR, label="compression (buff)")
    axes.plot(x, extremes.tension / 1e3, color=TENSION_COLOUR, ls="--", label="tension (draft)")
    axes.set_ylabel(FORCE_LABEL)


def plot_peak_strokes(axes: Axes, x: FloatArray, extremes: CouplerExtremes, geared: NDArray[np.bool_]) -> None:
    """Largest strokes [mm] of the draft gears at axis positions ``x`` (n_couplers,): a rigid drawbar has none."""
    axes.plot(x[geared], extremes.compression_stroke[geared] * 1e3, color=COMPRESSION_COLOUR)
    axes.plot(x[geared], extremes.tension_stroke[geared] * 1e3, color=TENSION_COLOUR, ls="--")
    axes.set_ylabel(STROKE_LABEL)


def legend_above(axes: Axes, offset: float) -> None:
    """Names of lines above the axes, ``offset`` axes heights from below."""
    axes.legend(
        loc="lower right", bbox_to_anchor=(1.0, offset), ncol=3, frameon=False, borderaxespad=0.2, borderpad=0.0
    )


def legend_below(figure: Figure, lines: Axes, columns: int) -> None:
    """Names of the lines of some axes under all axes, which the layout makes room for."""
    handles, labels = lines.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncol=columns, frameon=False)
