"""Figures of recordings over one another, and of measured signals beside them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from haul_ros.analysis.comparison import Compared, LineTest
from haul_ros.analysis.plotting import DASHES, FORCE_LABEL, legend_below, new_figure, shades
from haul_ros.units import mps_to_kmh

MOST_SIGNALS = 8
"""Panels of measured signals; the table has all."""
_MOST_POINTS = 20_000


def profiles_figure(runs: Sequence[Compared], title: str) -> Figure:
    """Largest compression and tension along the train of each run over one another, and speed of the head below."""
    figure = new_figure(title, (10.0, 9.0))
    compression, tension, speed = figure.subplots(3, 1)
    for run, colour, dash in zip(runs, shades(len(runs)), _dashes(len(runs)), strict=True):
        best, n = run.numbers.couplers.best, len(run.numbers.couplers.names) + 1
        position = np.arange(1.0, n) / n
        compression.plot(position, best.compression / 1e3, color=colour, ls=dash, label=run.label)
        tension.plot(position, best.tension / 1e3, color=colour, ls=dash)
        motion = run.numbers.train.motion
        stride = max(1, len(motion.time) // _MOST_POINTS)
        speed.plot(motion.time[::stride], mps_to_kmh(1.0) * motion.head_speed[::stride], color=colour, ls=dash)
    for axes, name in ((compression, "compression (buff)"), (tension, "tension (draft)")):
        axes.set_xlim(0.0, 1.0)
        axes.set_ylim(bottom=0.0)
        axes.set_ylabel(FORCE_LABEL)
        axes.set_title(name, loc="left")
        axes.grid(alpha=0.3)
    tension.set_xlabel("position of the coupler in the train, 0 at the head")
    speed.set_xlabel("simulation time [s]")
    speed.set_ylabel("speed of the head [km/h]")
    speed.grid(alpha=0.3)
    legend_below(figure, compression, 4)
    return figure


def measured_figure(runs: Sequence[Compared], tests: Sequence[LineTest], title: str) -> Figure:
    """Measured signals over time with what each run has in their place."""
    shown = [
        (test, i, signal)
        for number, test in enumerate(tests)
        for i, (signal, _) in enumerate(runs[0].simulated[number])
    ][:MOST_SIGNALS]
    figure = new_figure(title, (10.0, 1.2 + 2.2 * len(shown)))
    panels = np.atleast_1d(figure.subplots(len(shown), 1, sharex=True))
    colours, dashes = shades(len(runs)), _dashes(len(runs))
    for axes, (test, i, signal) in zip(panels, shown, strict=True):
        time = test.measurement.time + test.offset
        stride = max(1, len(time) // _MOST_POINTS)
        measured = signal.sign * test.measurement.columns[signal.column]
        axes.plot(time[::stride], measured[::stride], color="#808080", lw=2.0, label="measured")
        for run, colour, dash in zip(runs, colours, dashes, strict=True):
            _, simulated = run.simulated[tests.index(test)][i]
            axes.plot(time[::stride], simulated[::stride], color=colour, ls=dash, lw=1.0, label=run.label)
        axes.set_ylabel(f"{signal.target}\n[{signal.unit}]")
        axes.grid(alpha=0.3)
    panels[-1].set_xlabel("simulation time [s]")
    legend_below(figure, panels[0], 4)
    return figure


def _dashes(count: int) -> list[str]:
    return [DASHES[i % len(DASHES)] for i in range(count)]
