"""All numbers of a train from its recording, in one reading of its samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from haul_ros.analysis.brake_timing import Filling, FillingRecorder
from haul_ros.analysis.energy_flow import GearWork, SampledEnergy, TrainWork
from haul_ros.analysis.fatigue import FatigueCounter, Spectrum, rainflow_available
from haul_ros.analysis.limits import STRENGTH_LIMIT, LimitWatch
from haul_ros.analysis.motion import Motion, MotionRecorder, Stop, applications, stop
from haul_ros.analysis.peaks import PeakFinder, SampledPeaks
from haul_ros.analysis.radio_delays import RadioDelay, radio_delays
from haul_ros.analysis.reversals import ReversalCounter
from haul_ros.analysis.run_in import ContactFinder, Contacts
from haul_ros.analysis.sample_check import SampleCheck
from haul_ros.errors import RecordingError
from haul_ros.model.sample import CouplerExtremes, FloatArray
from haul_ros.model.scenario import Scenario
from haul_ros.recording.series import CouplerSeries, PressureSeries, Samples, VehicleSeries
from haul_ros.recording.train_source import TrainSource
from haul_ros.units import NS_PER_S

Series = TypeVar("Series", CouplerSeries, VehicleSeries, PressureSeries)

_LEAST_PIECE = 1000
"""Samples that are worked on at a time; more make nothing faster."""


@dataclass(frozen=True, slots=True)
class Window:
    """What of a recording counts: from ``begin`` to ``end`` [s], both included."""

    begin: float = -np.inf
    end: float = np.inf

    @property
    def is_whole(self) -> bool:
        """Whether it has all of the time."""
        return self.begin == -np.inf and self.end == np.inf


@dataclass(frozen=True, slots=True, eq=False)
class CouplerNumbers:
    """Of each of the k couplers, ``names``; compression is positive.

    ``peaks`` are those of the samples, ``extremes`` those of every time step (None: not recorded, or of another time);
    ``to_buff`` and ``to_draft`` (k,) count force reversals; ``above_compression`` and ``above_tension`` (k,) [s] are
    the times above ``limit`` [N]; ``work_taken`` (k,) [J] is that of force along stroke, ``dissipated`` (k,) [J] what
    of it is not stored in the end by the curves of the gears (None: not known without scenario); ``spectrum`` None: the
    library that counts is not there.
    """

    names: tuple[str, ...]
    peaks: SampledPeaks
    extremes: CouplerExtremes | None
    contacts: Contacts
    to_buff: NDArray[np.intp]
    to_draft: NDArray[np.intp]
    limit: float
    above_compression: FloatArray
    above_tension: FloatArray
    work_taken: FloatArray
    dissipated: FloatArray | None
    spectrum: Spectrum | None

    @property
    def best(self) -> CouplerExtremes:
        """The extremes of every time step, or where there are none those of the samples."""
        if self.extremes is not None:
            return self.extremes
        peaks = self.peaks
        return CouplerExtremes(
            compression=peaks.compression,
            compression_time=peaks.compression_time,
            tension=peaks.tension,
            tension_time=peaks.tension_time,
            compression_stroke=peaks.compression_stroke,
            tension_stroke=peaks.tension_stroke,
            bottomed_time=np.full(len(peaks.compression), np.nan),
        )


@dataclass(frozen=True, slots=True, eq=False)
class TrainNumbers:
    """Of the train: its motion, what each brake application of the first locomotive came to, how cylinders filled, the
    answers of the slaves, and energies (None: not known without scenario)."""

    motion: Motion
    stops: tuple[Stop, ...]
    fillings: tuple[Filling, ...]
    radio: tuple[RadioDelay, ...]
    energy: SampledEnergy | None


@dataclass(frozen=True, slots=True, eq=False)
class Numbers:
    """All numbers of a train. ``samples`` of couplers from ``begin`` to ``end`` [s], at most ``largest_gap`` [s] apart
    and ``period`` [s] in the median; ``notes`` say what was left out and why, a line each."""

    couplers: CouplerNumbers
    train: TrainNumbers
    samples: int
    begin: float
    end: float
    period: float
    largest_gap: float
    notes: tuple[str, ...]


def numbers_of(
    source: TrainSource,
    scenario: Scenario | None,
    window: Window | None = None,
    *,
    limit: float = STRENGTH_LIMIT,
    also: Callable[[Samples, int], None] = lambda _chosen, _read: None,
) -> Numbers:
    """All numbers of a train, with its scenario (None: not known).

    Every piece of the samples in the window is shown to ``also``, with how many samples were read for it.

    Raises
    ------
    HaulError
        The recording is damaged or holds no couplers in the window.
    """
    window = window or Window()
    gathering = _Gathering(source, scenario, window, limit)
    for block in merged(source.blocks()):
        chosen = within(block, window)
        gathering.add(chosen)
        also(chosen, len(block.couplers.time_ns))
    return gathering.numbers()


def within(block: Samples, window: Window) -> Samples:
    """The samples of a piece that lie in a window."""
    if window.is_whole:
        return block
    couplers, vehicles, pressure = block
    return Samples(series_within(couplers, window), series_within(vehicles, window), series_within(pressure, window))


def series_within(series: Series, window: Window) -> Series:
    """The part of a series that lies in a window."""
    time = series.time_ns / NS_PER_S
    rows = slice(int(np.searchsorted(time, window.begin)), int(np.searchsorted(time, window.end, side="right")))
    changed = {name: getattr(series, name)[rows] for name in series.__dataclass_fields__ if name != "names"}
    return replace(series, **changed)


def merged(blocks: Iterable[Samples]) -> Iterator[Samples]:
    """The same samples in pieces of some thousand, in place of those of a chunk."""
    waiting: list[Samples] = []
    count = 0
    for block in blocks:
        waiting.append(block)
        count += max(len(series.time_ns) for series in block)
        if count >= _LEAST_PIECE:
            yield _joined(waiting)
            waiting, count = [], 0
    if waiting:
        yield _joined(waiting)


class _Gathering:
    """What is gathered of the samples of one train."""

    def __init__(self, source: TrainSource, scenario: Scenario | None, window: Window, limit: float) -> None:
        self._source, self._scenario, self._window = source, scenario, window
        count = len(source.couplers)
        self._peaks, self._contacts = PeakFinder(count), ContactFinder(count)
        self._reversals, self._limit = ReversalCounter(count), LimitWatch(count, limit)
        self._fatigue = FatigueCounter(count) if rainflow_available() else None
        self._gears = GearWork(count)
        self._work = TrainWork(scenario.consist, scenario.track) if scenario and source.vehicles else None
        self._motion = MotionRecorder()
        self._efforts = _efforts(source, scenario) if self._work else {}
        self._applications = _applications(source, window)
        self._fillings = FillingRecorder([(begin, end) for begin, end, _ in self._applications])
        self._times: list[FloatArray] = []
        self._check = SampleCheck(source.path)

    def add(self, block: Samples) -> None:
        self._check.add(block)
        couplers, vehicles, pressure = block
        time = couplers.time_ns / NS_PER_S
        force, stroke = couplers.force, couplers.stroke
        self._gears.add(force, stroke)
        self._times.append(time)
        self._peaks.add(time, force, stroke)
        self._contacts.add(time, force, couplers.stroke_rate)
        self._reversals.add(force)
        self._limit.add(time, force)
        if self._fatigue is not None:
            self._fatigue.add(force)
        if len(vehicles.time_ns):
            vehicle_time = vehicles.time_ns / NS_PER_S
            self._motion.add(vehicle_time, vehicles.chainage, vehicles.speed)
            if self._work is not None:
                effort = _held(self._efforts, vehicle_time, vehicles.speed.shape[1])
                self._work.add(vehicles.chainage, vehicles.speed, vehicles.brake_force, effort)
        self._fillings.add(pressure.time_ns / NS_PER_S, pressure.pressure)

    def numbers(self) -> Numbers:
        time = np.concatenate([*self._times, np.empty(0)])
        if not len(time):
            where = "" if self._window.is_whole else f" from {self._window.begin:g} to {self._window.end:g} s"
            raise RecordingError(f"{self._source.path}: holds no {self._source.node}/couplers{where}: nothing was run")
        gaps = np.diff(time)
        return Numbers(
            couplers=self._coupler_numbers(float(time[-1])),
            train=self._train_numbers(),
            samples=len(time),
            begin=float(time[0]),
            end=float(time[-1]),
            period=float(np.median(gaps)) if len(gaps) else 0.0,
            largest_gap=float(gaps.max(initial=0.0)),
            notes=tuple(self._notes()),
        )

    def _coupler_numbers(self, end: float) -> CouplerNumbers:
        peaks, taken = self._peaks.peaks(), self._gears.taken
        dissipated = None if self._scenario is None else taken - self._gears.stored(self._scenario.consist)
        return CouplerNumbers(
            names=self._source.couplers,
            peaks=peaks,
            extremes=self._extremes(peaks, end),
            contacts=self._contacts.contacts(),
            to_buff=self._reversals.to_buff,
            to_draft=self._reversals.to_draft,
            limit=self._limit.limit,
            above_compression=self._limit.compression,
            above_tension=self._limit.tension,
            work_taken=taken,
            dissipated=dissipated,
            spectrum=self._fatigue.spectrum() if self._fatigue is not None else None,
        )

    def _extremes(self, peaks: SampledPeaks, end: float) -> CouplerExtremes | None:
        """Those of every time step; of a run that ended between two of them with what samples show behind the last."""
        recorded = self._source.final_extremes() if self._window.is_whole else None
        if recorded is None:
            return None
        found = CouplerExtremes(**{name: getattr(recorded.extremes, name).copy() for name in _EXTREME_FIELDS})
        if recorded.time_ns / NS_PER_S < end:
            for name in ("compression", "tension"):
                later = getattr(peaks, name) > getattr(found, name)
                for field in (name, f"{name}_time"):
                    getattr(found, field)[later] = getattr(peaks, field)[later]
                stroke = f"{name}_stroke"
                np.maximum(getattr(found, stroke), getattr(peaks, stroke), out=getattr(found, stroke))
        return found

    def _train_numbers(self) -> TrainNumbers:
        motion = self._motion.motion()
        stops: list[Stop] = []
        if len(motion.time):
            last = float(motion.time[-1])
            stops = [stop(motion, begin, min(end, last), demand) for begin, end, demand in self._applications]
        energy = self._work.energy(self._gears) if self._work is not None and len(motion.time) else None
        return TrainNumbers(motion, tuple(stops), tuple(self._fillings.fillings()), self._radio(), energy)

    def _radio(self) -> tuple[RadioDelay, ...]:
        if not self._source.locomotives:
            return ()
        master, *slaves = (_series(self._source, f"{name}/applied_brake") for name in self._source.locomotives)
        found = [
            delay
            for slave, applied in zip(self._source.locomotives[1:], slaves, strict=True)
            for delay in radio_delays(slave, master, applied)
            if self._window.begin <= delay.time <= self._window.end
        ]
        return tuple(sorted(found, key=lambda delay: delay.time))

    def _notes(self) -> Iterator[str]:
        yield from self._source.notes
        if self._scenario is None:
            yield "no scenario in it: energy balance, dissipated energy, masses and names of wagons are left out"
        if not self._source.vehicles:
            yield f"no {self._source.node}/vehicles in it: speeds, stops and energies are left out"
        if not self._source.locomotives:
            yield f"no {self._source.node}/master/applied_brake in it: brake applications and radio delays are left out"
        if self._fatigue is None:
            yield "fatigue is left out: needs rainflow, pip install 'haul_ros[fatigue]'"


_EXTREME_FIELDS = tuple(CouplerExtremes.__dataclass_fields__)


def _series(source: TrainSource, name: str) -> tuple[FloatArray, FloatArray]:
    found = source.scalars(name)
    return found.time_ns / NS_PER_S, found.values


def _applications(source: TrainSource, window: Window) -> list[tuple[float, float, float]]:
    if not source.locomotives:
        return []
    found = applications(*_series(source, f"{source.locomotives[0]}/applied_brake"), until=np.inf)
    return [
        (begin, min(end, window.end), demand) for begin, end, demand in found if window.begin <= begin <= window.end
    ]


def _efforts(source: TrainSource, scenario: Scenario | None) -> dict[int, tuple[FloatArray, FloatArray]]:
    """Tractive efforts by vehicle, of those locomotives of which any was recorded."""
    if scenario is None:
        return {}
    found = {loco.vehicle: _series(source, f"{loco.name}/tractive_effort") for loco in scenario.consist.locomotives}
    return {vehicle: series for vehicle, series in found.items() if series[1].any()}


def _held(efforts: Mapping[int, tuple[FloatArray, FloatArray]], time: FloatArray, vehicles: int) -> FloatArray:
    """Efforts (m, n_vehicles) [N] at times (m,) [s]: each holds until the next."""
    held = np.zeros((len(time), vehicles))
    for vehicle, (changes, values) in efforts.items():
        at = np.searchsorted(changes, time, side="right") - 1
        held[:, vehicle] = np.where(at >= 0, values[np.maximum(at, 0)], 0.0)
    return held


def _joined(blocks: Sequence[Samples]) -> Samples:
    if len(blocks) == 1:
        return blocks[0]
    parts = []
    for pieces in zip(*blocks, strict=True):
        first = pieces[0]
        joined = {
            name: np.concatenate([getattr(piece, name) for piece in pieces])
            for name in first.__dataclass_fields__
            if name != "names"
        }
        parts.append(replace(first, **joined))
    return Samples(*parts)
