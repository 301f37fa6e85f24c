"""Figure of a pneumatic brake: pressures at some wagons over time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from haul_ros.analysis.plotting import DASHES, legend_below, new_figure, shades
from haul_ros.model.consist import Consist
from haul_ros.recording.series import PressureSeries
from haul_ros.units import NS_PER_S

WAGONS = 4
"""Lines in each panel."""
MOST_POINTS = 4000
"""Of a line; more would be told apart by nobody."""


def brake_figure(
    consist: Consist, pipe: PressureSeries, auxiliary: PressureSeries, cylinder: PressureSeries, title: str
) -> Figure:
    """Gauge pressure of brake pipe, auxiliary reservoir and brake cylinder at wagons from head to tail."""
    figure = new_figure(title, (10.0, 7.6))
    panels = figure.subplots(3, 1, sharex=True)
    wagons = [i for i, vehicle in enumerate(consist.vehicles) if vehicle.max_tractive_effort == 0.0]
    places = wagons or list(range(len(consist.vehicles)))
    chosen = sorted({places[round(part)] for part in np.linspace(0, len(places) - 1, WAGONS)})
    for axes, series, label in zip(
        panels,
        (pipe, auxiliary, cylinder),
        ("brake pipe [kPa]", "auxiliary reservoir [kPa]", "brake cylinder [kPa]"),
        strict=True,
    ):
        stride = max(1, len(series.time_ns) // MOST_POINTS)
        times = series.time_ns[::stride] / NS_PER_S
        for vehicle, colour, dash in zip(chosen, shades(len(chosen)), DASHES, strict=False):
            name = consist.vehicle_names[vehicle]
            axes.plot(times, series.pressure[::stride, vehicle] / 1e3, color=colour, ls=dash, label=name)
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    panels[-1].set_xlabel("simulation time [s]")
    legend_below(figure, panels[0], WAGONS)
    return figure
