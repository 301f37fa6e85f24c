"""Figure of a pneumatic brake: pressures at some wagons over time."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.figure import Figure

from haul_ros.analysis.history import Thinning
from haul_ros.analysis.plotting import DASHES, legend_below, new_figure, shades
from haul_ros.analysis.train_layout import TrainLayout
from haul_ros.recording.series import PressureSeries

WAGONS = 4
"""Lines in each panel."""
MOST_POINTS = 4000
"""Of a line; more would be told apart by nobody."""
_LABELS = ("brake pipe [kPa]", "auxiliary reservoir [kPa]", "brake cylinder [kPa]")


class BrakeHistory:
    """Gauge pressures at wagons from head to tail, in about ``samples`` samples, taken piece by piece."""

    def __init__(self, layout: TrainLayout, samples: int) -> None:
        places = layout.wagons or tuple(range(len(layout.vehicles)))
        self.vehicles = sorted({places[round(part)] for part in np.linspace(0, len(places) - 1, WAGONS)})
        self._layout = layout
        self._panels = [Thinning(samples, MOST_POINTS) for _ in _LABELS]

    def add(self, *pressures: PressureSeries | None) -> None:
        """The next samples of pipe, reservoir and cylinder; None: not among them."""
        for panel, series in zip(self._panels, pressures, strict=True):
            if series is not None and len(series.time_ns):
                panel.add(series.time_ns, series.pressure[:, self.vehicles])

    def figure(self, title: str) -> Figure:
        """Pressure of brake pipe, auxiliary reservoir and brake cylinder over time."""
        figure = new_figure(title, (10.0, 7.6))
        panels = figure.subplots(3, 1, sharex=True)
        for axes, series, label in zip(panels, self._panels, _LABELS, strict=True):
            if len(series.time):
                for i, (name, colour, dash) in enumerate(self._lines()):
                    axes.plot(series.time, series.values[:, i] / 1e3, color=colour, ls=dash, label=name)
            axes.set_ylabel(label)
            axes.grid(alpha=0.3)
            axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        panels[-1].set_xlabel("simulation time [s]")
        legend_below(figure, panels[0], WAGONS)
        return figure

    def _lines(self) -> Iterable[tuple[str, object, str]]:
        names = [self._layout.vehicles[vehicle] for vehicle in self.vehicles]
        return zip(names, shades(len(names)), DASHES, strict=False)
