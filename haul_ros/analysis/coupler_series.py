"""Force and stroke of chosen couplers at every sample, as a table and a figure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from haul_ros.analysis.plotting import DASHES, legend_below, new_figure, shades
from haul_ros.analysis.tables import Table
from haul_ros.errors import HaulError
from haul_ros.model.sample import FloatArray
from haul_ros.recording.series import CouplerSeries
from haul_ros.units import NS_PER_S

MOST_NUMBERS = 20_000_000
"""Forces and strokes that are kept: 160 MB."""
_NAMED = 12
"""Lines of a figure that have names; of more nobody finds his own."""


class SeriesError(HaulError):
    """More samples of couplers than are kept."""


class CouplerRecorder:
    """Samples of the couplers in ``columns`` of a recording, taken piece by piece."""

    def __init__(self, columns: Sequence[int]) -> None:
        self._columns = list(columns)
        self._pieces: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        self._count = 0

    def add(self, couplers: CouplerSeries) -> None:
        """The next samples.

        Raises
        ------
        SeriesError
            They are too many.
        """
        self._count += 2 * len(couplers.time_ns) * len(self._columns)
        if self._count > MOST_NUMBERS:
            raise SeriesError(f"more than {MOST_NUMBERS} samples of the chosen couplers: choose fewer, or less time")
        self._pieces.append(
            (couplers.time_ns / NS_PER_S, couplers.force[:, self._columns], couplers.stroke[:, self._columns])
        )

    def table(self, names: Sequence[str]) -> Table:
        """One row per sample; ``names`` are those of all couplers. Compression is positive."""
        time, force, stroke = self._whole()
        columns: dict[str, Sequence[object]] = {"time_s": time.tolist()}
        for i, column in enumerate(self._columns):
            columns[f"{names[column]}_force_kN"] = (force[:, i] / 1e3).tolist()
            columns[f"{names[column]}_stroke_mm"] = (stroke[:, i] * 1e3).tolist()
        return columns

    def figure(self, names: Sequence[str], title: str) -> Figure:
        """Force above stroke over time, a line for each coupler."""
        time, force, stroke = self._whole()
        figure = new_figure(title)
        above, below = figure.subplots(2, 1, sharex=True)
        colours = shades(len(self._columns))
        for axes, values, label in (
            (above, force / 1e3, "force [kN]"),
            (below, stroke * 1e3, "stroke [mm]"),
        ):
            for i, column in enumerate(self._columns):
                style = DASHES[i % len(DASHES)]
                axes.plot(time, values[:, i], color=colours[i], ls=style, lw=1.0, label=names[column])
            axes.set_ylabel(f"{label}, compression positive")
            axes.grid(alpha=0.3)
        below.set_xlabel("simulation time [s]")
        if len(self._columns) <= _NAMED:
            legend_below(figure, above, 6)
        return figure

    def _whole(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        time, force, stroke = (np.concatenate(part) for part in zip(*self._pieces, strict=True))
        return time, force, stroke
