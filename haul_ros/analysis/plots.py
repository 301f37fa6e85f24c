"""Figures of a run: peaks along the train, coupler forces and speed over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haul_ros.analysis.history import History
from haul_ros.analysis.plotting import (
    DIVERGING,
    HEAD_COLOUR,
    LOCOMOTIVE_COLOUR,
    SIZE,
    TAIL_COLOUR,
    force_and_stroke,
    frame_train,
    legend_above,
    mark_locomotives,
    plot_peak_forces,
    plot_peak_strokes,
    shown_title,
)
from haul_ros.analysis.train_layout import TrainLayout
from haul_ros.model.sample import CouplerExtremes
from haul_ros.recording.series import ScalarSeries
from haul_ros.units import NS_PER_S, mps_to_kmh

HISTORY_COLUMNS = 1200


@dataclass(frozen=True, slots=True)
class BrakeEvent:
    """The brake that a locomotive applies rises (``applied``) or falls, at ``time`` [s]."""

    time: float
    vehicle: int
    applied: bool


def brake_events(vehicle: int, applied_brake: ScalarSeries) -> list[BrakeEvent]:
    """Changes in the applied brake of the locomotive at a vehicle index."""
    times, rises = applied_brake.time_ns[1:] / NS_PER_S, np.diff(applied_brake.values)
    return [BrakeEvent(float(times[i]), vehicle, bool(rises[i] > 0.0)) for i in np.flatnonzero(rises)]


def profile_figure(layout: TrainLayout, extremes: CouplerExtremes, title: str) -> Figure:
    """Largest compression, tension and |F| of each coupler along the train, largest strokes below."""
    figure, force, stroke = force_and_stroke(title)
    couplers = np.arange(1.0, len(layout.couplers) + 1)
    plot_peak_forces(force, couplers, extremes)
    plot_peak_strokes(stroke, couplers, extremes, layout.geared)
    stroke.set_xlabel("coupler, counted from the head")
    for axes in (force, stroke):
        frame_train(axes, len(layout.vehicles))
        mark_locomotives(axes, (_axis_position(locomotive.vehicle) for locomotive in layout.locomotives))
    _name_locomotives(force, layout)
    legend_above(force, offset=1.08)
    return figure


def history_figure(layout: TrainLayout, history: History, events: Sequence[BrakeEvent], title: str) -> Figure:
    """Force of every coupler over time as colours, with the brake events; speed of head and tail below."""
    figure = Figure(figsize=SIZE, layout="constrained")
    force, speed = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    figure.suptitle(shown_title(title))

    edges = history.force_edges
    limit = max(float(np.abs(history.force).max()) / 1e3, 1.0)
    rows = np.arange(len(layout.couplers) + 1) + 0.5
    mesh = force.pcolormesh(
        edges, rows, history.force.T / 1e3, cmap=DIVERGING, vmin=-limit, vmax=limit, shading="flat", rasterized=True
    )
    figure.colorbar(mesh, ax=force, label="coupler force [kN], compression positive", pad=0.01)
    force.set_ylabel("coupler, counted from the head")
    force.set_ylim(len(layout.vehicles), 0.0)
    _mark_events(force, events)

    if len(history.speed_time):
        _plot_speeds(speed, history)
    speed.set_ylabel("speed [km/h]")
    speed.set_xlabel("simulation time [s]")
    speed.set_xlim(edges[0], edges[-1])
    speed.grid(alpha=0.3)
    return figure


def _plot_speeds(speed: Axes, history: History) -> None:
    speed.plot(history.speed_time, mps_to_kmh(1.0) * history.head_speed, color=HEAD_COLOUR, label="head")
    speed.plot(history.speed_time, mps_to_kmh(1.0) * history.tail_speed, color=TAIL_COLOUR, ls="--", label="tail")
    legend_above(speed, offset=1.0)


def _axis_position(vehicle: int) -> float:
    """Where a vehicle lies on the axis of couplers: between the one before (index) and the one behind (index + 1)."""
    return vehicle + 0.5


def _name_locomotives(axes: Axes, layout: TrainLayout) -> None:
    """Names above the axes; locomotives coupled to one another share a label."""
    top = axes.secondary_xaxis("top")
    # Index minus rank is the same for neighbours
    ranked = enumerate(layout.locomotives)
    groups = [[loco for _, loco in group] for _, group in groupby(ranked, lambda item: item[1].vehicle - item[0])]
    top.set_xticks([float(np.mean([_axis_position(loco.vehicle) for loco in group])) for group in groups])
    top.set_xticklabels([", ".join(loco.name.replace("_", " ") for loco in group) for group in groups])
    top.tick_params(length=0, labelcolor=LOCOMOTIVE_COLOUR)


def _mark_events(axes: Axes, events: Sequence[BrakeEvent]) -> None:
    for applied, face, label in ((True, "black", "brake applied"), (False, "white", "brake released")):
        chosen = [event for event in events if event.applied is applied]
        if chosen:
            axes.scatter(
                [event.time for event in chosen],
                [_axis_position(event.vehicle) for event in chosen],
                marker=">",
                s=45,
                facecolor=face,
                edgecolor="black",
                linewidth=0.8,
                clip_on=False,
                zorder=3,
                label=f"{label} by a locomotive",
            )
    if events:
        legend_above(axes, offset=1.0)
