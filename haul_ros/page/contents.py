"""What the page shows of a recording."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from haul_ros.analysis.envelopes import bottomed_couplers
from haul_ros.analysis.number_tables import number_tables
from haul_ros.analysis.numbers import Numbers, numbers_of
from haul_ros.analysis.scenarios import scenario_of
from haul_ros.analysis.tables import Table
from haul_ros.analysis.train_layout import TrainLayout
from haul_ros.errors import one_line
from haul_ros.messages.channels import channel_table
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.sample import FloatArray
from haul_ros.model.scenario import Scenario
from haul_ros.page.gathering import PageSamples
from haul_ros.page.packing import packed_multiples, packed_numbers, packing_step
from haul_ros.page.train import command_entry, locomotive_vehicles, peaks, train
from haul_ros.recording.series import Samples
from haul_ros.recording.train_source import TrainSource
from haul_ros.units import NS_PER_S, mps_to_kmh

MOST_INSTANTS = 6000
"""That a page shows: of a longer recording several samples are one."""
_MOST_VALUES = 8_000_000
"""Of all quantities."""
_MOST_EVENTS = 20_000
_MOST_CHANGES = 20_000
_MOST_ROWS = 5000
"""Of a table."""
_LONGEST_TEXT = 400
"""Characters of an event."""


def report_contents(
    source: TrainSource, show: Callable[[int, int], None] = lambda _done, _of: None
) -> dict[str, object]:
    """Everything in a report of a recording, ready for JSON, in the units of the field.

    ``show`` is told how many samples of how many have been read.

    Raises
    ------
    HaulError
        The file is damaged, holds no samples, or its scenario is not one that this version understands.
    """
    scenario = scenario_of(source)
    layout = TrainLayout.for_source(source, scenario)
    samples = PageSamples(source, min(MOST_INSTANTS, max(_MOST_VALUES // (4 * len(layout.vehicles)), 2)))
    done = 0

    def also(block: Samples, read: int) -> None:
        nonlocal done
        samples.add(block)
        done += read
        show(done, source.samples)

    numbers = numbers_of(source, scenario, also=also)
    for pipe, _ in source.air():
        samples.add_pipe(pipe)
    quantities = samples.quantities()
    known = {locomotive.name: locomotive.vehicle for locomotive in layout.locomotives}
    locomotives = known or locomotive_vehicles(layout.vehicles, source.locomotives)
    name, _, description = source.title.partition(": ")
    return {
        "live": False,
        "title": one_line(name, _LONGEST_TEXT),
        "description": one_line(description, _LONGEST_TEXT),
        "train": train(layout.couplers, layout.vehicles, locomotives, samples.places, pneumatic="pipe" in quantities),
        "time": packed_numbers(samples.time),
        "quantities": {key: packed_multiples(values) for key, values in quantities.items()},
        "peaks": peaks(numbers.couplers.best),
        "summary": _figures(numbers, layout, scenario),
        "events": _events(source),
        "commands": _commands(source),
        "applied": {name: _changes(source, f"{name}/applied_brake") for name in locomotives},
        "effort": {name: _changes(source, f"{name}/tractive_effort") for name in locomotives},
        "tables": {name: _table(found) for name, found in number_tables(numbers, layout).items()},
        "notes": [one_line(note) for note in _notes(source, numbers, scenario, quantities, len(samples.time))],
    }


def _figures(numbers: Numbers, layout: TrainLayout, scenario: Scenario | None) -> list[dict[str, str]]:
    motion, best = numbers.train.motion, numbers.couplers.best
    count = f"{len(layout.vehicles)} vehicles"
    if scenario is None:
        figures = [("train", count, "")]
    else:
        figures = [("train", f"{scenario.consist.mass / 1e3:.0f} t", f"{count}, {scenario.consist.length:.0f} m")]
    if len(motion.time):
        begin, end = (mps_to_kmh(float(motion.head_speed[at])) for at in (0, -1))
        stands = motion.standing_since is not None and math.isfinite(motion.standing_since)
        seconds = motion.standing_since if stands else numbers.end
        figures.append(("stopped after" if stands else "moving after", f"{seconds:.2f} s", f"from {begin:.1f} km/h"))
        figures.append(("distance", f"{motion.distance:.1f} m", f"at the end {end:.1f} km/h"))
    figures += [
        (f"largest {word}", f"{values.max() * factor:.{digits}f} {unit}", _where(layout, values, times))
        for word, values, times, factor, digits, unit in (
            ("compression", best.compression, best.compression_time, 1e-3, 1, "kN"),
            ("tension", best.tension, best.tension_time, 1e-3, 1, "kN"),
            ("stroke", np.maximum(best.compression_stroke, best.tension_stroke), None, 1e3, 2, "mm"),
        )
        if values.any()
    ]
    if scenario is not None and (bottomed := bottomed_couplers(scenario.consist, best)):
        names = ", ".join(layout.couplers[coupler] for coupler in bottomed)
        figures.append(("closed draft gears", str(len(bottomed)), one_line(names, 80)))
    return [{"label": label, "value": value, "more": more} for label, value, more in figures]


def _where(layout: TrainLayout, values: FloatArray, times: FloatArray | None) -> str:
    coupler = int(values.argmax())
    at = "" if times is None else f" at {times[coupler]:.3f} s"
    return f"{layout.couplers[coupler]}{at}, {(coupler + 1) / len(layout.vehicles):.3f} of the train"


def _events(source: TrainSource) -> list[dict[str, object]]:
    return [
        {"time": event.time_ns / NS_PER_S, "kind": event.kind.value, "text": one_line(event.text, _LONGEST_TEXT)}
        for event in source.events()[:_MOST_EVENTS]
    ]


def _commands(source: TrainSource) -> list[dict[str, object]]:
    channels = channel_table(source.locomotives, source.node)
    found = [
        (time, Command(locomotive, kind, value))
        for kind, by_locomotive in channels.commands.items()
        for locomotive, channel in by_locomotive.items()
        for time, value in _changes(source, channel.name.removeprefix(f"{source.node}/"))
    ]
    order = {kind: number for number, kind in enumerate(CommandKind)}
    found.sort(key=lambda entry: (entry[0], order[entry[1].kind]))
    return [command_entry(time, command) for time, command in found[:_MOST_CHANGES]]


def _changes(source: TrainSource, name: str) -> list[list[float]]:
    """Times [s] and values of a topic; none where it is not there."""
    series = source.scalars(name)
    values = np.nan_to_num(series.values[:_MOST_CHANGES])
    return [[time / NS_PER_S, value] for time, value in zip(series.time_ns.tolist(), values.tolist(), strict=False)]


def _table(table: Table) -> dict[str, object]:
    columns = {name: [_entry(value) for value in column[:_MOST_ROWS]] for name, column in table.items()}
    rows = max((len(column) for column in table.values()), default=0)
    return {"columns": list(columns), "rows": list(zip(*columns.values(), strict=True)), "count": rows}


def _entry(value: object) -> object:
    """A value as JSON has it: what is no finite number is null."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def _notes(
    source: TrainSource, numbers: Numbers, scenario: Scenario | None, quantities: Mapping[str, FloatArray], shown: int
) -> Iterator[str]:
    yield f"{source.path.name}: {numbers.samples} samples of {source.node}."
    yield "Compression (buff) is positive, tension (draft) negative."
    if shown < numbers.samples:
        yield f"The samples are shown as {shown}, each the one of largest magnitude of several."
    steps = ", ".join(f"{packing_step(quantities[key]):.2g} {unit}" for key, unit in _UNITS)
    yield f"Curves and colours have a resolution of {steps}."
    every = "every time step" if numbers.couplers.extremes is not None else "the samples"
    yield f"Peaks are of {every}."
    yield from numbers.notes
    if scenario is not None and scenario.caveats:
        yield f"Of the data used: {'; '.join(scenario.caveats)}."


_UNITS: Sequence[tuple[str, str]] = (("force", "kN"), ("stroke", "mm"), ("cylinder", "kPa"))
