"""Recordings side by side: the same numbers with their differences, and measured line tests beside them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from haul_ros.analysis.line_test import (
    BANDS,
    ErrorStatistics,
    LineTestError,
    Measurement,
    Signal,
    error_statistics,
    signals,
)
from haul_ros.analysis.numbers import Numbers, Window, numbers_of
from haul_ros.analysis.scenarios import scenario_of
from haul_ros.analysis.tables import Table
from haul_ros.analysis.train_layout import TrainLayout
from haul_ros.model.sample import FloatArray
from haul_ros.recording.series import Samples
from haul_ros.recording.trains import open_train
from haul_ros.units import NS_PER_S, mps_to_kmh


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """A recording that is compared, ``label`` its short name; ``simulated`` has its values (n,) at the times of each
    measurement, by measurement and signal, in the unit of the signal."""

    label: str
    path: Path
    layout: TrainLayout
    numbers: Numbers
    simulated: tuple[tuple[tuple[Signal, FloatArray], ...], ...] = ()


@dataclass(frozen=True, slots=True)
class LineTest:
    """A measurement, to whose times ``offset`` [s] is added to get simulation times, and targets by column."""

    measurement: Measurement
    targets: Mapping[str, str]
    offset: float = 0.0


def labels(paths: Sequence[Path]) -> list[str]:
    """Short names of files, different from one another: their stems, numbered where these are the same."""
    stems = [path.resolve().stem for path in paths]
    again = Counter(stems)
    return [f"{number}_{stem}" if again[stem] > 1 else stem for number, stem in enumerate(stems, 1)]


def compared(
    label: str,
    path: Path,
    tests: Sequence[LineTest],
    window: Window,
    limit: float,
    node: str | None = None,
    run: int | None = None,
    *,
    show: Callable[[int, int], None] = lambda _done, _of: None,
) -> Compared:
    """Read a recording for a comparison.

    ``node`` and ``run`` are as `open_train` takes them; ``show`` is told how many samples of how many have been read.

    Raises
    ------
    HaulError
        It cannot be used, or has no coupler or vehicle to which a signal is put.
    """
    with open_train(path, node, run) as source:
        scenario = scenario_of(source)
        layout = TrainLayout.for_source(source, scenario)
        chosen = [signals(test.measurement, test.targets, source.couplers, source.vehicles) for test in tests]
        followers = [_Follower(signal) for of_test in chosen for signal in of_test]
        read = 0

        def also(block: Samples, count: int) -> None:
            nonlocal read
            read += count
            show(read, source.samples)
            for follower in followers:
                follower.add(block)

        numbers = numbers_of(source, scenario, window, limit=limit, also=also)
    by_signal = iter(followers)
    simulated = tuple(
        tuple((signal, next(by_signal).at(test.measurement.time + test.offset)) for signal in of_test)
        for test, of_test in zip(tests, chosen, strict=True)
    )
    return Compared(label, path, layout, numbers, simulated)


class _Follower:
    """What a recording has in place of a measured signal, at every sample."""

    def __init__(self, signal: Signal) -> None:
        self._signal = signal
        self._pieces: list[tuple[FloatArray, FloatArray]] = []

    def add(self, block: Samples) -> None:
        index = self._signal.index
        if self._signal.is_force:
            time_ns, values = block.couplers.time_ns, block.couplers.force[:, index] / 1e3
        else:
            time_ns, values = block.vehicles.time_ns, mps_to_kmh(1.0) * block.vehicles.speed[:, index]
        self._pieces.append((time_ns / NS_PER_S, values))

    def at(self, time: FloatArray) -> FloatArray:
        """Straight between samples; NaN before the first and behind the last."""
        times, values = (np.concatenate(part) for part in zip(*self._pieces, strict=True))
        if not len(times):
            return np.full(len(time), np.nan)
        return np.asarray(np.interp(time, times, values, left=np.nan, right=np.nan))


def quantities(numbers: Numbers) -> dict[str, float | None]:
    """The numbers that are compared, with their units; None: not known, or not come to."""
    couplers, train = numbers.couplers, numbers.train
    best, found = couplers.best, couplers.contacts
    stop = train.stops[0] if train.stops else None
    n = len(couplers.names) + 1
    values: dict[str, float | None] = {}
    for name, force, time in (
        ("compression", best.compression, best.compression_time),
        ("tension", best.tension, best.tension_time),
    ):
        at = int(np.argmax(force)) if len(force) else 0
        bears = bool(force.any())
        values[f"peak_{name}_kN"] = float(force[at]) / 1e3 if bears else 0.0
        values[f"peak_{name}_time_s"] = float(time[at]) if bears else None
        values[f"peak_{name}_position"] = (at + 1) / n if bears else None
    values |= {
        "largest_stroke_mm": float(np.maximum(best.compression_stroke, best.tension_stroke).max(initial=0.0)) * 1e3,
        "run_ins": float(found.run_in.sum()),
        "fastest_run_in_m_per_s": float(found.speed[found.run_in].max(initial=0.0)),
        "run_outs": float((~found.run_in).sum()),
        "fastest_run_out_m_per_s": float(found.speed[~found.run_in].max(initial=0.0)),
        "force_reversals": float((couplers.to_buff + couplers.to_draft).sum()),
        "longest_time_above_limit_s": float((couplers.above_compression + couplers.above_tension).max(initial=0.0)),
        "gears_dissipated_kJ": None if couplers.dissipated is None else float(couplers.dissipated.sum()) / 1e3,
        "largest_damage_equivalent_range_kN": (
            None if couplers.spectrum is None else float(couplers.spectrum.equivalent_range().max(initial=0.0)) / 1e3
        ),
        "distance_m": train.motion.distance if len(train.motion.time) else None,
        "standing_since_s": train.motion.standing_since,
        "first_application_initial_speed_kmh": None if stop is None else mps_to_kmh(stop.initial_speed),
        "first_application_stopping_time_s": None if stop is None else stop.stopping_time,
        "first_application_stopping_distance_m": None if stop is None else stop.stopping_distance,
        "first_application_mean_deceleration_m_per_s2": None if stop is None else stop.mean_deceleration,
        "longest_radio_delay_s": max((d.delay for d in train.radio if d.delay is not None), default=None),
        "brake_work_MJ": None if train.energy is None else train.energy.brake_work / 1e6,
    }
    return values


def comparison_table(runs: Sequence[Compared]) -> Table:
    """One row per quantity: the value of each run, and behind the first also its difference to that one."""
    found = {run.label: quantities(run.numbers) for run in runs}
    names = list(found[runs[0].label])
    table: dict[str, Sequence[object]] = {"quantity": names}
    first = found[runs[0].label]
    for run in runs:
        table[run.label] = [found[run.label][name] for name in names]
        if run is not runs[0]:
            table[f"{run.label}_difference"] = [_difference(found[run.label][name], first[name]) for name in names]
    return table


def profile_table(runs: Sequence[Compared]) -> Table:
    """One row per coupler of trains of as many vehicles: the largest forces of each run and their differences to the
    first's. Empty for trains of different lengths."""
    first = runs[0].numbers.couplers
    if any(len(run.numbers.couplers.names) != len(first.names) for run in runs):
        return {}
    count = len(first.names)
    table: dict[str, Sequence[object]] = {
        "coupler": list(first.names),
        "position": [j / (count + 1) for j in range(1, count + 1)],
    }
    for run in runs:
        for side in ("compression", "tension"):
            values, own = getattr(run.numbers.couplers.best, side), getattr(first.best, side)
            table[f"{run.label}_max_{side}_kN"] = (values / 1e3).tolist()
            if run is not runs[0]:
                table[f"{run.label}_max_{side}_difference_kN"] = ((values - own) / 1e3).tolist()
    return table


def error_table(runs: Sequence[Compared], tests: Sequence[LineTest]) -> Table:
    """One row per run and measured signal, and one for all forces of a run together.

    Raises
    ------
    LineTestError
        No time of a measurement lies in a run.
    """
    rows: list[dict[str, object]] = []
    for run in runs:
        forces: list[tuple[FloatArray, FloatArray]] = []
        for test, of_test in zip(tests, run.simulated, strict=True):
            of_file = 0
            for signal, simulated in of_test:
                measured = signal.sign * test.measurement.columns[signal.column]
                found = error_statistics(simulated, measured)
                of_file += found.samples
                rows.append(_error_row(run.label, test.measurement.path.stem, signal, found))
                if signal.is_force:
                    forces.append((simulated, measured))
            if not of_file:
                raise _nothing_in_common(run, test)
        if len(forces) > 1:
            simulated, measured = (np.concatenate(part) for part in zip(*forces, strict=True))
            rows.append(_error_row(run.label, "all", None, error_statistics(simulated, measured)))
    return {name: [row[name] for row in rows] for name in rows[0]} if rows else {}


def _nothing_in_common(run: Compared, test: LineTest) -> LineTestError:
    measured = test.measurement.time + test.offset
    own = f"{run.numbers.begin:g} to {run.numbers.end:g} s"
    times = f"measured from {measured[0]:g} to {measured[-1]:g} s of simulation"
    return LineTestError(f"{test.measurement.path}: {times}, {run.path} has {own}: expected --offset")


def _error_row(label: str, file: str, signal: Signal | None, found: ErrorStatistics) -> dict[str, object]:
    is_force = signal is None or signal.is_force
    return {
        "recording": label,
        "measurement": file,
        "column": "all forces" if signal is None else signal.column,
        "target": "" if signal is None else signal.target,
        "unit": "kN" if signal is None else signal.unit,
        "samples": found.samples,
        "mean_error": found.mean,
        "rms_error": found.rms,
        "standard_deviation": found.standard_deviation,
        "largest_error": found.largest,
        "correlation": found.correlation,
        **{
            f"share_within_{band:g}_kN": share if is_force else None
            for (band, _), share in zip(BANDS, found.within, strict=True)
        },
    }


def _difference(value: float | None, first: float | None) -> float | None:
    return None if value is None or first is None else value - first
