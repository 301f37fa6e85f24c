"""Figures of a run: peaks along the train, coupler forces and speed over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haul_ros.analysis.envelopes import largest_force
from haul_ros.analysis.history import History
from haul_ros.model.consist import Consist
from haul_ros.model.sample import CouplerExtremes
from haul_ros.recording.series import ScalarSeries
from haul_ros.units import NS_PER_S, mps_to_kmh

# Okabe and Ito's palette, to be told apart by colour-blind readers and in greyscale
COMPRESSION_COLOUR = "#D55E00"
TENSION_COLOUR = "#0072B2"
ENVELOPE_COLOUR = "#C8C8C8"
LOCOMOTIVE_COLOUR = "#404040"
HEAD_COLOUR = "#000000"
TAIL_COLOUR = "#009E73"

HISTORY_COLUMNS = 1200
DPI = 160
_SIZE = (10.0, 6.8)
"""Width and height [inch]."""


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


def profile_figure(consist: Consist, extremes: CouplerExtremes, title: str) -> Figure:
    """Largest compression, tension and |F| of each coupler along the train, largest strokes below."""
    figure = Figure(figsize=_SIZE, layout="constrained")
    force, stroke = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    figure.suptitle(title)
    couplers = np.arange(1, len(consist.couplers) + 1)

    force.fill_between(
        couplers, largest_force(extremes) / 1e3, color=ENVELOPE_COLOUR, lw=0, label="|F|, larger of both"
    )
    force.plot(couplers, extremes.compression / 1e3, color=COMPRESSION_COLOUR, label="compression (buff)")
    force.plot(couplers, extremes.tension / 1e3, color=TENSION_COLOUR, ls="--", label="tension (draft)")
    force.set_ylabel("peak coupler force [kN]")

    geared = np.array([gear is not None for gear in consist.couplers], dtype=bool)  # a rigid drawbar has no stroke
    stroke.plot(couplers[geared], extremes.compression_stroke[geared] * 1e3, color=COMPRESSION_COLOUR)
    stroke.plot(couplers[geared], extremes.tension_stroke[geared] * 1e3, color=TENSION_COLOUR, ls="--")
    stroke.set_ylabel("peak draft gear stroke [mm]")
    stroke.set_xlabel("coupler, counted from the head")

    for axes in (force, stroke):
        axes.set_xlim(0.0, len(consist.vehicles))
        axes.set_ylim(bottom=0.0)
        axes.grid(alpha=0.3)
        for locomotive in consist.locomotives:
            axes.axvline(_place(locomotive.vehicle), color=LOCOMOTIVE_COLOUR, lw=0.8, ls=":")
    _name_locomotives(force, consist)
    _legend_above(force, offset=1.08)
    return figure


def history_figure(consist: Consist, history: History, events: Sequence[BrakeEvent], title: str) -> Figure:
    """Force of every coupler over time as colours, with the brake events; speed of head and tail below."""
    figure = Figure(figsize=_SIZE, layout="constrained")
    force, speed = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    figure.suptitle(title)

    edges = history.force_edges
    limit = max(float(np.abs(history.force).max()) / 1e3, 1.0)
    rows = np.arange(len(consist.couplers) + 1) + 0.5
    mesh = force.pcolormesh(
        edges, rows, history.force.T / 1e3, cmap="RdBu_r", vmin=-limit, vmax=limit, shading="flat", rasterized=True
    )
    figure.colorbar(mesh, ax=force, label="coupler force [kN], compression positive", pad=0.01)
    force.set_ylabel("coupler, counted from the head")
    force.set_ylim(len(consist.vehicles), 0.0)
    _mark_events(force, events)

    speed.plot(history.speed_time, mps_to_kmh(1.0) * history.head_speed, color=HEAD_COLOUR, label="head")
    speed.plot(history.speed_time, mps_to_kmh(1.0) * history.tail_speed, color=TAIL_COLOUR, ls="--", label="tail")
    speed.set_ylabel("speed [km/h]")
    speed.set_xlabel("simulation time [s]")
    speed.set_xlim(edges[0], edges[-1])
    speed.grid(alpha=0.3)
    _legend_above(speed, offset=1.0)
    return figure


def save_png(figure: Figure, path: Path) -> None:
    """Write a figure as PNG; needs no display."""
    figure.savefig(path, format="png", dpi=DPI)


def _place(vehicle: int) -> float:
    """Where a vehicle lies on the axis of couplers: between the one before (index) and the one behind (index + 1)."""
    return vehicle + 0.5


def _name_locomotives(axes: Axes, consist: Consist) -> None:
    """Names above the axes; locomotives coupled to one another share a label."""
    top = axes.secondary_xaxis("top")
    # Index minus rank is the same for neighbours
    ranked = enumerate(consist.locomotives)
    groups = [[loco for _, loco in group] for _, group in groupby(ranked, lambda item: item[1].vehicle - item[0])]
    top.set_xticks([float(np.mean([_place(loco.vehicle) for loco in group])) for group in groups])
    top.set_xticklabels([", ".join(loco.name.replace("_", " ") for loco in group) for group in groups])
    top.tick_params(length=0, labelcolor=LOCOMOTIVE_COLOUR)


def _mark_events(axes: Axes, events: Sequence[BrakeEvent]) -> None:
    for applied, face, label in ((True, "black", "brake applied"), (False, "white", "brake released")):
        chosen = [event for event in events if event.applied is applied]
        if chosen:
            axes.scatter(
                [event.time for event in chosen],
                [_place(event.vehicle) for event in chosen],
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
        _legend_above(axes, offset=1.0)


def _legend_above(axes: Axes, offset: float) -> None:
    axes.legend(
        loc="lower right", bbox_to_anchor=(1.0, offset), ncol=3, frameon=False, borderaxespad=0.2, borderpad=0.0
    )
