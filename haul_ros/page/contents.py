"""What the page shows of a recording."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from haul_ros.analysis.history import Thinning
from haul_ros.analysis.summary import CouplerPeak, RunSummary, recorded_scenario, summarize_recording
from haul_ros.errors import RecordingError, one_line
from haul_ros.model.command import Command
from haul_ros.model.sample import CouplerExtremes, FloatArray
from haul_ros.page.packing import packed_multiples, packed_numbers, packing_step
from haul_ros.recording.reader import Recording
from haul_ros.recording.series import ScalarSeries
from haul_ros.units import NS_PER_S, mps_to_kmh

Message = str | bytes
"""To a live page: JSON text, or the bytes of a frame."""

MOST_INSTANTS = 6000
"""That a page shows: of a longer recording several samples are one."""
_MOST_VALUES = 8_000_000
"""Of all quantities."""
_MOST_EVENTS = 20_000
_MOST_CHANGES = 20_000
_LONGEST_TEXT = 400
"""Characters of an event."""


def report_contents(recording: Recording) -> dict[str, object]:
    """Everything in a report of a recording, ready for JSON, in the units of the field.

    Raises
    ------
    HaulError
        The file is damaged, holds no samples, or its scenario is not one that this version understands.
    """
    scenario = recorded_scenario(recording)
    summary = summarize_recording(recording, scenario)
    extremes = recording.last_extremes().extremes
    consist = scenario.consist
    count = recording.count(recording.channels.couplers)
    instants = min(MOST_INSTANTS, max(_MOST_VALUES // (4 * len(consist.vehicles)), 2))
    time, quantities = _quantities(recording, instants)
    locomotives = [locomotive.name for locomotive in consist.locomotives]
    return {
        "live": False,
        "title": one_line(scenario.name, _LONGEST_TEXT),
        "description": one_line(scenario.description, _LONGEST_TEXT),
        "train": train(
            consist.coupler_names,
            consist.vehicle_names,
            {locomotive.name: locomotive.vehicle for locomotive in consist.locomotives},
            consist.centre_offsets,
            pneumatic="pipe" in quantities,
        ),
        "time": packed_numbers(time),
        "quantities": {key: packed_multiples(values) for key, values in quantities.items()},
        "peaks": peaks(extremes),
        "summary": _figures(summary),
        "events": _events(recording),
        "commands": _commands(recording),
        "applied": {name: _changes(recording.scalars(f"{name}/applied_brake")) for name in locomotives},
        "effort": {name: _changes(_effort(recording, name)) for name in locomotives},
        "notes": _notes(recording, summary, quantities, count, len(time)),
    }


def train(
    couplers: Sequence[str],
    vehicles: Sequence[str],
    locomotives: Mapping[str, int | None],
    places: Sequence[float],
    *,
    pneumatic: bool,
) -> dict[str, object]:
    """The train as the page knows it; ``locomotives`` are indices of vehicles by name, None: not known.

    ``places`` says how far each vehicle is behind the head [m].
    """
    return {
        "couplers": list(couplers),
        "vehicles": list(vehicles),
        "locomotives": [{"name": name, "vehicle": vehicle} for name, vehicle in locomotives.items()],
        "places": list(places),
        "pneumatic": pneumatic,
    }


def peaks(extremes: CouplerExtremes) -> dict[str, list[float]]:
    """Largest forces [kN] and strokes [mm] of each coupler as magnitudes, times [s]."""
    found = {
        "compression": extremes.compression / 1e3,
        "compression_time": extremes.compression_time,
        "tension": extremes.tension / 1e3,
        "tension_time": extremes.tension_time,
        "compression_stroke": extremes.compression_stroke * 1e3,
        "tension_stroke": extremes.tension_stroke * 1e3,
    }
    return {name: np.nan_to_num(values, posinf=0.0, neginf=0.0).tolist() for name, values in found.items()}


def head_middle_tail(values: FloatArray) -> FloatArray:
    """Of values (n, vehicles) those of head, middle and tail (n, 3)."""
    last = values.shape[1] - 1
    return values[:, [0, last // 2, last]]


def _quantities(recording: Recording, instants: int) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Times (n,) [s] and quantities (n, k) in the units of the page, of at most so many instants."""
    channels = recording.channels
    for channel in (channels.couplers, channels.vehicles, channels.brake_cylinder_pressure):
        if not recording.count(channel):
            raise RecordingError(f"{recording.path}: holds no {channel.topic}: nothing was run")
    counts = [recording.count(channel) for channel in channels.samples]
    if len(set(counts)) > 1:
        raise RecordingError(f"{recording.path}: has samples of some topics that others lack: {counts}")
    taken = {key: Thinning(counts[0], instants) for key in ("force", "stroke", "speed", "cylinder")}
    for block in recording.blocks():
        taken["force"].add(block.couplers.time_ns, block.couplers.force / 1e3)
        taken["stroke"].add(block.couplers.time_ns, block.couplers.stroke * 1e3)
        taken["speed"].add(block.vehicles.time_ns, mps_to_kmh(1.0) * head_middle_tail(block.vehicles.speed))
        taken["cylinder"].add(block.pressure.time_ns, block.pressure.pressure / 1e3)
    if (pipe := recording.pipe_pressure()) is not None:
        taken["pipe"] = Thinning(counts[0], instants)
        taken["pipe"].add(pipe.time_ns, pipe.pressure / 1e3)
    return taken["force"].time, {key: thinned.values for key, thinned in taken.items()}


def _figures(summary: RunSummary) -> list[dict[str, str]]:
    end = "stopped after" if summary.stop_time is not None else "moving after"
    seconds = summary.stop_time if summary.stop_time is not None else summary.duration
    resolution = max(0, -math.floor(math.log10(summary.stop_time_resolution)))
    figures = [
        ("train", f"{summary.mass / 1e3:.0f} t", f"{summary.vehicles} vehicles, {summary.length:.0f} m"),
        (end, f"{seconds:.{resolution}f} s", f"from {mps_to_kmh(summary.initial_speed):.1f} km/h"),
        ("distance", f"{summary.distance:.1f} m", f"at the end {mps_to_kmh(summary.final_speed):.1f} km/h"),
    ]
    figures += [
        (f"largest {word}", f"{peak.value * factor:.{digits}f} {unit}", _where(peak))
        for word, peak, factor, digits, unit in (
            ("compression", summary.compression, 1e-3, 1, "kN"),
            ("tension", summary.tension, 1e-3, 1, "kN"),
            ("stroke", summary.stroke, 1e3, 2, "mm"),
        )
        if peak is not None
    ]
    if summary.bottomed:
        figures.append(("closed draft gears", str(len(summary.bottomed)), one_line(", ".join(summary.bottomed), 80)))
    return [{"label": label, "value": value, "more": more} for label, value, more in figures]


def _where(peak: CouplerPeak) -> str:
    at = f" at {peak.time:.3f} s" if peak.time is not None else ""
    return f"{peak.coupler}{at}, {peak.position:.3f} of the train"


def _events(recording: Recording) -> list[dict[str, object]]:
    return [
        {"time": event.time_ns / NS_PER_S, "kind": event.kind.value, "text": one_line(event.text, _LONGEST_TEXT)}
        for event in recording.events()[:_MOST_EVENTS]
    ]


def _commands(recording: Recording) -> list[dict[str, object]]:
    return [command_entry(time_ns / NS_PER_S, command) for time_ns, command in recording.commands()[:_MOST_CHANGES]]


def command_entry(time: float, command: Command) -> dict[str, object]:
    """A command at a time [s], as the page draws it."""
    return {"time": time, "locomotive": command.locomotive, "kind": command.kind.value, "value": command.value}


def _effort(recording: Recording, locomotive: str) -> ScalarSeries:
    """Older versions recorded none."""
    channel = recording.channels.tractive_effort[locomotive]
    return (
        recording.scalars(channel.topic)
        if recording.count(channel)
        else ScalarSeries(np.empty(0, np.int64), np.empty(0))
    )


def _changes(series: ScalarSeries) -> list[list[float]]:
    values = np.nan_to_num(series.values[:_MOST_CHANGES])
    return [[time / NS_PER_S, value] for time, value in zip(series.time_ns.tolist(), values.tolist(), strict=False)]


def _notes(
    recording: Recording, summary: RunSummary, quantities: Mapping[str, FloatArray], count: int, shown: int
) -> list[str]:
    facts = recording.info()
    steps = [
        f"{packing_step(quantities[key]):.2g} {unit}"
        for key, unit in (("force", "kN"), ("stroke", "mm"), ("cylinder", "kPa"))
    ]
    notes = [f"{facts.path.name}, recorded by haul_ros {facts.version}."]
    notes.append("Compression (buff) is positive, tension (draft) negative.")
    if shown < count:
        notes.append(f"{count} samples are shown as {shown}, each the one of largest magnitude of several.")
    notes.append(
        f"Curves and colours have a resolution of {', '.join(steps)}; summary and peaks are of every time step."
    )
    if summary.caveats:
        notes.append(f"Of the data used: {'; '.join(summary.caveats)}.")
    return [one_line(note) for note in notes]
