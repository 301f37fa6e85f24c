"""One train in a bag by any recorder: ``ros2 bag record``, split or not, or an unfinished recording of haul_ros.

Bags have the clock of their recorder. Couplers and vehicles carry simulation time in their stamps; that of other
messages lies between the stamps of the couplers that were recorded before and behind them.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from haul_ros.errors import RecordingError
from haul_ros.messages.cdr import typestore
from haul_ros.messages.channels import BOOL, FLOAT64, INT32, JOINT_STATE, LOG
from haul_ros.messages.quantities import ExtremeArrays, extremes_of
from haul_ros.model.event import Event, EventKind
from haul_ros.recording.batches import JointBatch, PressureBatch, joint_names, stamp_of
from haul_ros.recording.description import MOST_VEHICLES
from haul_ros.recording.opening import reading
from haul_ros.recording.raw_messages import RawMessage, RawMessages
from haul_ros.recording.series import (
    CouplerSeries,
    PressureSeries,
    RecordedExtremes,
    Samples,
    ScalarSeries,
    TimeArray,
    VehicleSeries,
)
from haul_ros.recording.train_source import TrainSource
from haul_ros.units import NS_PER_S

MOST_ENTRIES = 2_000_000
"""Numbers and events of all topics but the samples: some 200 MB of memory."""
MOST_SAMPLES = 10_000_000
"""Samples of couplers, 55 hours at 50 Hz: 160 MB of memory for their times."""
MOST_KEPT = 256 * 1024 * 1024
"""Bytes of events, and of the first messages of topics that may be a train's."""
_BATCH, _BATCH_BYTES = 400, 32 * 1024 * 1024
"""Samples of a block, and bytes of their messages."""
_COUPLERS, _VEHICLES, _EVENTS = "/couplers", "/vehicles", "/events"
_EXTREMES = ("max_compression", "max_tension", "max_compression_time", "max_tension_time")
_NUMBERS = (FLOAT64, BOOL, INT32)
_LARGEST_NUMBER = 1024
"""Bytes of a message of a number or an event."""


@dataclass(slots=True)
class _Seen:
    """What a first reading of a topic keeps: times by the recorder's clock [ns], and values or messages."""

    msgtype: str
    log_times: array[int] = field(default_factory=lambda: array("q"))
    stamps: array[int] = field(default_factory=lambda: array("q"))
    values: array[float] = field(default_factory=lambda: array("d"))
    messages: list[bytes] = field(default_factory=list)


class TrainBag(TrainSource):
    """The train that ``node`` (full name; None: the only one) has published; see `TrainSource`.

    Where the node was reset, simulation time begins anew; ``run`` (1, 2 ...; None: the only one) chooses.

    Raises
    ------
    RecordingError
        The bag cannot be read, holds no train, several and none is chosen, or another than the chosen.
    """

    def __init__(self, path: Path, node: str | None = None, run: int | None = None) -> None:
        self.path = path
        self._raw = RawMessages(path)
        self._seen = _survey(self._raw)
        self.node = self._choose(node)
        self._first_log, self._end_log, self._clock = self._choose_run(run)
        self.couplers = self._names(_COUPLERS)
        self.vehicles = self._names(_VEHICLES)
        self.samples = len(self._clock[0])
        self.begin_ns, self.end_ns = int(self._clock[1][0]), int(self._clock[1][-1])
        locomotives = sorted(
            (topic.removeprefix(f"{self.node}/").partition("/")[0] for topic in self._of_node("applied_brake")),
            key=lambda name: (name != "master", len(name), name),
        )
        self.locomotives = tuple(locomotives)
        self.scenario_document = self._raw.scenario_document
        self.title = f"{path.name}, recorded by {self._raw.library or 'another program'}"
        self.notes = (self._raw.cut_off,) if self._raw.cut_off else ()

    def blocks(self) -> Iterator[Samples]:
        """Couplers, vehicles and cylinder pressure piece by piece."""
        couplers = JointBatch(self.couplers)
        vehicles = JointBatch(self.vehicles)
        pressure = PressureBatch(len(self.vehicles))
        by_topic = {
            self.node + _COUPLERS: couplers.add,
            self.node + _VEHICLES: vehicles.add,
            f"{self.node}/brake_cylinder_pressure": pressure.add,
        }
        with reading(self.path):
            for message in self._messages(by_topic):
                by_topic[message.topic](message)
                count = max(len(couplers), len(vehicles), len(pressure))
                if count >= _BATCH or couplers.size + vehicles.size + pressure.size >= _BATCH_BYTES:
                    yield self._block(couplers, vehicles, pressure)
            yield self._block(couplers, vehicles, pressure)

    def scalars(self, name: str) -> ScalarSeries:
        """A Float64, Int32 or Bool topic by its name under the node; empty: it is not there."""
        seen = self._seen.get(f"{self.node}/{name}")
        if seen is None or seen.msgtype not in _NUMBERS:
            return ScalarSeries(np.empty(0, np.int64), np.empty(0))
        log_times, values = np.array(seen.log_times), np.array(seen.values)
        inside = (log_times >= self._first_log) & (log_times < self._end_log)
        # What is latched was sent before the recorder came: the last value before the run holds at its start
        before = np.flatnonzero(log_times < self._first_log)[-1:]
        chosen = np.concatenate((before, np.flatnonzero(inside)))
        return ScalarSeries(self._simulation_time(log_times[chosen]), values[chosen])

    def events(self) -> tuple[Event, ...]:
        """What happened, in order of time; of kinds that this version knows."""
        seen = self._seen.get(f"{self.node}{_EVENTS}")
        events = []
        known = {kind.value: kind for kind in EventKind}
        with reading(self.path):
            for log_time, data in zip(seen.log_times, seen.messages, strict=True) if seen else ():
                entry: Any = typestore().deserialize_cdr(data, LOG)
                kind = known.get(entry.name.rpartition(".")[2])
                if kind is not None and self._first_log <= log_time < self._end_log:
                    events.append(Event(entry.stamp.sec * NS_PER_S + entry.stamp.nanosec, kind, entry.msg))
        return tuple(events)

    def final_extremes(self) -> RecordedExtremes | None:
        """The largest values of every time step, as recorded last in the run; None: they are not all there."""
        last: dict[str, RawMessage] = {}
        topics = {f"{self.node}/{name}": name for name in _EXTREMES}
        if not all(topic in self._seen for topic in topics):
            return None
        with reading(self.path):
            for message in self._messages(topics):
                last[topics[message.topic]] = message
            if len(last) < len(_EXTREMES):
                return None
            names = self.couplers
            sides = []
            for side in _EXTREMES[:2]:
                joints, times = JointBatch(names), PressureBatch(len(names))
                joints.add(last[side])
                times.add(last[f"{side}_time"])
                time_ns, (stroke, _, force) = joints.take()
                sides.append(ExtremeArrays(stroke[0], times.take()[1][0], force[0]))
        return RecordedExtremes(int(time_ns[0]), extremes_of(*sides))

    def air(self) -> Iterator[tuple[PressureSeries, PressureSeries]]:
        """Pressure of brake pipe and auxiliary reservoirs piece by piece; nothing without a pneumatic brake."""
        names = [f"{self.node}/{name}" for name in ("brake_pipe_pressure", "auxiliary_reservoir_pressure")]
        if not self.vehicles or not all(name in self._seen for name in names):
            return
        pipe, auxiliary = (PressureBatch(len(self.vehicles)) for _ in names)
        batches = dict(zip(names, (pipe, auxiliary), strict=True))
        with reading(self.path):
            for message in self._messages(batches):
                batches[message.topic].add(message)
                if max(len(pipe), len(auxiliary)) >= _BATCH or pipe.size + auxiliary.size >= _BATCH_BYTES:
                    yield self._pressure(pipe), self._pressure(auxiliary)
            yield self._pressure(pipe), self._pressure(auxiliary)

    def _choose(self, node: str | None) -> str:
        nodes = sorted(
            topic.removesuffix(_COUPLERS)
            for topic, seen in self._seen.items()
            if seen.msgtype == JOINT_STATE and topic.endswith(_COUPLERS) and seen.stamps
        )
        if node is None and len(nodes) > 1:
            raise RecordingError(f"{self.path}: holds {len(nodes)} trains, choose one by --node: {', '.join(nodes)}")
        if not nodes:
            end = f" ({self._raw.cut_off})" if self._raw.cut_off else ""
            expected = f"expected a topic .../couplers of {JOINT_STATE} with messages"
            raise RecordingError(f"{self.path}: holds no train{end}, {expected}")
        if node is not None and node not in nodes:
            raise RecordingError(f"{self.path}: no train of node {node}, it has {', '.join(nodes)}")
        return node or nodes[0]

    def _choose_run(self, run: int | None) -> tuple[int, int, tuple[TimeArray, TimeArray]]:
        """From and until when by the recorder's clock [ns], and the clock: its times and simulation times [ns]."""
        seen = self._seen[self.node + _COUPLERS]
        log_times, stamps = np.array(seen.log_times), np.array(seen.stamps)
        begins = np.concatenate(([0], np.flatnonzero(np.diff(stamps) < 0) + 1, [len(stamps)]))
        runs = len(begins) - 1
        if run is None and runs > 1:
            lengths = np.diff(begins).tolist()
            told = f"its node was reset: of {', '.join(map(str, lengths))} samples"
            raise RecordingError(f"{self.path}: holds {runs} runs, {told}; choose one by --run 1 to {runs}")
        if run is not None and not 1 <= run <= runs:
            raise RecordingError(f"{self.path}: no run {run}, it has {runs}")
        number = run or 1
        first, end = begins[number - 1], begins[number]
        begin_log = int(log_times[first]) if number > 1 else 0
        end_log = int(log_times[end]) if end < len(stamps) else 2**62
        return begin_log, end_log, (np.maximum.accumulate(log_times[first:end]), stamps[first:end])

    def _names(self, topic: str) -> tuple[str, ...]:
        seen = self._seen.get(self.node + topic)
        if seen is None or not seen.messages:
            return ()
        with reading(self.path):
            names = joint_names(seen.messages[0])
            if not 1 <= len(names) <= MOST_VEHICLES or len(set(names)) < len(names):
                expected = f"expected 1 to {MOST_VEHICLES} different ones"
                raise ValueError(f"{self.node}{topic}: {len(names)} names, {expected}")
            return names

    def _of_node(self, name: str) -> list[str]:
        return [topic for topic in self._seen if topic.startswith(f"{self.node}/") and topic.endswith(f"/{name}")]

    def _messages(self, topics: Mapping[str, object]) -> Iterator[RawMessage]:
        for message in self._raw.select(topics.keys()):
            if self._first_log <= message.log_time < self._end_log:
                yield message

    def _block(self, couplers: JointBatch, vehicles: JointBatch, pressure: PressureBatch) -> Samples:
        time_ns, (stroke, rate, force) = couplers.take()
        vehicle_time_ns, (chainage, speed, brake_force) = vehicles.take()
        return Samples(
            CouplerSeries(time_ns, self.couplers, stroke, rate, force),
            VehicleSeries(vehicle_time_ns, self.vehicles, chainage, speed, brake_force),
            self._pressure(pressure),
        )

    def _pressure(self, batch: PressureBatch) -> PressureSeries:
        log_times, values = batch.take()
        return PressureSeries(self._simulation_time(log_times), self.vehicles, values)

    def _simulation_time(self, log_times: TimeArray) -> TimeArray:
        """Between the stamps of the couplers recorded before and behind; beyond them at the recorder's pace."""
        clock, stamps = self._clock
        inside = np.interp(log_times - clock[0], clock - clock[0], stamps - stamps[0])
        early, late = np.minimum(0, log_times - clock[0]), np.maximum(0, log_times - clock[-1])
        times = np.rint(inside).astype(np.int64) + stamps[0] + early + late
        return np.asarray(np.maximum(0, times))


def _survey(raw: RawMessages) -> dict[str, _Seen]:
    """All numbers and events, the times of all couplers, and the first message of each topic of names."""
    found: dict[str, _Seen] = {}
    entries = samples = kept = 0
    for topic, msgtype, log_time, data in raw.select():
        seen = found.get(topic)
        if seen is None:
            seen = found[topic] = _Seen(msgtype)
        if msgtype in _NUMBERS and len(data) <= _LARGEST_NUMBER:
            seen.values.append(_number(raw.path, topic, msgtype, data))
        elif msgtype == JOINT_STATE and topic.endswith((_COUPLERS, _VEHICLES)):
            if not seen.messages:
                seen.messages.append(data)
                kept += len(data)
            if not topic.endswith(_COUPLERS):
                continue
            seen.stamps.append(stamp_of(data))
            samples += 1
        elif msgtype == LOG and topic.endswith(_EVENTS):
            seen.messages.append(data)
            kept += len(data)
        else:
            continue
        seen.log_times.append(log_time)
        entries += not seen.stamps
        for count, most, what in (
            (entries, MOST_ENTRIES, "numbers and events"),
            (samples, MOST_SAMPLES, "samples of couplers"),
            (kept, MOST_KEPT, "bytes of events and names"),
        ):
            if count > most:
                raise RecordingError(f"{raw.path}: more than {most} {what}, expected fewer")
    return found


def _number(path: Path, topic: str, msgtype: str, data: bytes) -> float:
    with reading(path):
        message: Any = typestore().deserialize_cdr(data, msgtype)
        return float(message.data)
