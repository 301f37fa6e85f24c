"""Recordings read back."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sized
from contextlib import AbstractContextManager
from itertools import groupby
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from mcap.reader import SeekingReader
from mcap.records import Message as McapMessage
from mcap.records import Statistics
from mcap.summary import Summary

from haul_ros.errors import RecordingError
from haul_ros.messages.cdr import Float64Codec, JointStateCodec, decode_bool, decode_float64, decode_int32, typestore
from haul_ros.messages.channels import BOOL, FLOAT64, INT32, LOG, Channel, ChannelTable
from haul_ros.messages.encoder import Message
from haul_ros.messages.quantities import (
    CouplerArrays,
    ExtremeArrays,
    VehicleArrays,
    extremes_of,
    measured_codec,
    pressure_codec,
    time_codec,
)
from haul_ros.messages.requests import RequestCodec
from haul_ros.model.command import Command
from haul_ros.model.event import Event, EventKind
from haul_ros.model.request import TimedRequest
from haul_ros.recording.batches import LARGEST_STATE
from haul_ros.recording.chunks import MESSAGE_HEAD
from haul_ros.recording.columns import ColumnReader, Columns
from haul_ros.recording.description import (
    check_form,
    described_channels,
    locomotive_names,
    measured_couplers,
    recording_plan,
)
from haul_ros.recording.info import RecordingInfo
from haul_ros.recording.integrity import (
    DROPPED,
    WRITTEN,
    attachment,
    check_chunks,
    check_data,
    check_summary,
    descriptions,
    message_count,
)
from haul_ros.recording.opening import open_finished, reading
from haul_ros.recording.ordered import chunk_data, ordered_messages, read_chunk
from haul_ros.recording.run_file import RECORD_NAME, SCENARIO_NAME
from haul_ros.recording.series import (
    CouplerSeries,
    MeasuredSeries,
    PressureSeries,
    RecordedExtremes,
    Samples,
    ScalarSeries,
    VehicleSeries,
)
from haul_ros.recording.topics import TopicIndex

LATEST_NS = 2**60
"""Simulation time [ns] that no run reaches: 36 years."""
MOST_ENTRIES = 500_000
"""Commands, and events, of one recording: some 200 MB of memory."""
_SCALARS: Mapping[str, Callable[[bytes], float]] = {
    FLOAT64: decode_float64,
    BOOL: decode_bool,
    INT32: decode_int32,
}


class Recording:
    """A finished recording of haul_ros, opened for reading; a context manager.

    Every method reads what it returns from the file, in order of simulation time, and raises RecordingError if the
    file turns out to be damaged there. What an older version did not record yet, there is none of.

    Raises
    ------
    RecordingError
        The file cannot be opened, is unfinished or cut off, is no MCAP file or no recording of haul_ros.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._stream = open_finished(self.path)
        try:
            with self._border():
                self._size = os.fstat(self._stream.fileno()).st_size
                check_summary(self._stream.fileno(), self._size)
                check_data(self._stream.fileno(), self._size)
                # No record is longer than the file, whatever a damaged one says.
                self._reader = SeekingReader(self._stream, validate_crcs=True, record_size_limit=self._size)
                self._summary, self._statistics = self._read_summary()
                check_chunks(self._stream.fileno(), self._size, self._summary.chunk_indexes)
                self.metadata = self._read_metadata()
                """Description of the run by the recorder, as text."""
                self._check_statistics()  # other recorders count from another time
                self.channels: ChannelTable = described_channels(self.metadata)
                """The topics of such a train; a recording by an older version may lack some."""
                self._topics = TopicIndex(self.path, self._summary, self._statistics, self.channels)
                self._columns = ColumnReader(self._stream.fileno(), self._summary.chunk_indexes, self._topics)
        except BaseException:
            self._stream.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._stream.close()

    def __enter__(self) -> Recording:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    @property
    def scenario_document(self) -> str:
        """The scenario as recorded: self-contained YAML text."""
        with self._border():
            for index in self._summary.attachment_indexes:
                if index.name == SCENARIO_NAME:
                    return attachment(self._stream.fileno(), index).decode()
        raise RecordingError(f"{self.path}: has no attachment {SCENARIO_NAME}")

    def info(self) -> RecordingInfo:
        """Facts about the file, without reading its messages."""
        with self._border():
            statistics = self._statistics
            return RecordingInfo(
                path=self.path,
                size=self._size,
                version=self.metadata["version"],
                scenario=self.metadata["scenario"],
                description=self.metadata["description"],
                time_step=float(self.metadata["time_step"]),
                vehicles=int(self.metadata["vehicles"]),
                couplers=int(self.metadata["couplers"]),
                locomotives=tuple(locomotive_names(self.metadata)),
                compression=", ".join(sorted({c.compression or "none" for c in self._summary.chunk_indexes})) or "none",
                topics=self._topics.infos(),
                messages=statistics.message_count,
                start_ns=statistics.message_start_time,
                end_ns=statistics.message_end_time,
                dropped=message_count(self.metadata, DROPPED),
                written=message_count(self.metadata, WRITTEN),
                record_rate=float(self.metadata["record_rate"]) if "record_rate" in self.metadata else None,
                plan=recording_plan(self.metadata),
                measured=measured_couplers(self.metadata),
            )

    def check_chunks(self, enough: Callable[[], bool] = lambda: False) -> tuple[int, int]:
        """Compare the checksums of chunks, until there is ``enough``; of how many, and of how many there are.

        Raises
        ------
        RecordingError
            One does not fit.
        """
        checked, indexes = 0, self._summary.chunk_indexes
        with self._border():
            for index in indexes:
                if enough():
                    break
                chunk_data(read_chunk(self._stream.fileno(), index))
                checked += 1
        return checked, len(indexes)

    def count(self, channel: Channel) -> int:
        """How many messages a channel has."""
        return self._topics.count(channel.topic)

    def names(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Of couplers and of vehicles, as in the samples; empty where there are none."""
        with self._border():
            couplers, vehicles = (self._joint_codec(c).names for c in (self.channels.couplers, self.channels.vehicles))
            return couplers, vehicles

    def couplers(self) -> CouplerSeries:
        """Stroke, stroke rate and force of every coupler."""
        with self._border():
            return _couplers(self._filled(self._joint_columns(self.channels.couplers)))

    def vehicles(self) -> VehicleSeries:
        """Chainage, speed and brake force of every vehicle."""
        with self._border():
            return _vehicles(self._filled(self._joint_columns(self.channels.vehicles)))

    def pressure(self) -> PressureSeries:
        """Brake cylinder pressure of every vehicle; names are those of the vehicles' topic."""
        return self._pressure_series(self.channels.brake_cylinder_pressure)

    def pipe_pressure(self) -> PressureSeries | None:
        """Brake pipe pressure at every vehicle; None without a pneumatic brake."""
        channel = self.channels.brake_pipe_pressure
        return None if channel is None else self._pressure_series(channel)

    def auxiliary_pressure(self) -> PressureSeries | None:
        """Pressure of every vehicle's auxiliary reservoir; None without a pneumatic brake."""
        channel = self.channels.auxiliary_reservoir_pressure
        return None if channel is None else self._pressure_series(channel)

    def air_blocks(self) -> Iterator[tuple[PressureSeries, PressureSeries]]:
        """Both of these piece by piece, as `blocks`; nothing without a pneumatic brake."""
        with self._border():
            channels = self.channels.brake_pipe_pressure, self.channels.auxiliary_reservoir_pressure
            names = self._joint_codec(self.channels.vehicles).names
            columns = [_pressure_columns(channel, names) for channel in channels if channel is not None]
            for _ in self._columns.read_by_chunk(columns) if columns else ():
                pipe, auxiliary = map(_pressure, columns)
                yield pipe, auxiliary

    def _pressure_series(self, channel: Channel) -> PressureSeries:
        with self._border():
            names = self._joint_codec(self.channels.vehicles).names
            return _pressure(self._filled(_pressure_columns(channel, names)))

    def measured_couplers(self) -> MeasuredSeries | None:
        """What the sensors of couplers showed; None without sensors."""
        channel = self.channels.measured_couplers
        if channel is None:
            return None
        with self._border():
            first = next(self._messages(channel.topic), None)
            codec = measured_codec((), stroke=True) if first is None else self._measured_codec(first.data)
            columns = self._filled(Columns(channel.topic, codec, codec.names))
            stroke, _, force = columns.arrays
            return MeasuredSeries(columns.time_ns, columns.names, stroke if codec.counts[0] else None, force)

    def _measured_codec(self, data: bytes) -> JointStateCodec:
        _check_length(self.channels.measured[0], data)
        codec = JointStateCodec.of(data, may_lack=("position", "velocity"))
        if codec.names != measured_couplers(self.metadata):
            raise ValueError(f"{self.channels.measured[0].topic}: a message of other couplers")
        return codec

    def samples(self) -> Samples:
        """Couplers, vehicles and brake cylinder pressure in one go, faster than one by one."""
        with self._border():
            columns = self._sample_columns()
            self._columns.read(columns)
            return _samples(*columns)

    def blocks(self) -> Iterator[Samples]:
        """The same piece by piece, for files larger than memory.

        A piece is what lies in one chunk of the file, so its series may differ in length by a sample, or be empty.
        """
        with self._border():
            columns = self._sample_columns()
            for _ in self._columns.read_by_chunk(columns):
                yield _samples(*columns)

    def extremes(self) -> Iterator[RecordedExtremes]:
        """Largest values of every coupler since the start of the run, at each time at which they were recorded."""
        return self._extremes(reverse=False)

    def last_extremes(self) -> RecordedExtremes:
        """The newest of `extremes`.

        Raises
        ------
        RecordingError
            There are none.
        """
        newest = next(self._extremes(reverse=True), None)
        if newest is None:
            raise RecordingError(f"{self.path}: holds no {self.channels.max_compression.topic}: nothing was run")
        return newest

    def has_times_in_velocity(self) -> bool:
        """Whether the times of the largest forces are where older versions had them."""
        return not self.count(self.channels.max_compression_time)

    def scalars(self, topic: str) -> ScalarSeries:
        """A Float64, Int32 or Bool topic, by full name or relative to the node: ``slave_1/radio_delay``.

        Raises
        ------
        RecordingError
            There is no such topic, or it is of another type.
        """
        topic = self._full_name(topic)
        with self._border():
            msgtype = self._topics.msgtype(topic)
            if msgtype not in _SCALARS:
                raise RecordingError(f"{self.path}: {topic} is {msgtype}, expected {', '.join(_SCALARS)}")
            if msgtype == FLOAT64:  # efforts have as many messages as samples
                columns = self._filled(Columns(topic, Float64Codec(), ()))
                return ScalarSeries(columns.time_ns, columns.arrays[0][:, 0])
            decode = _SCALARS[msgtype]
            count = self._topics.count(topic)
            time_ns, values = np.empty(count, np.int64), np.empty(count)
            for i, message in enumerate(self._messages(topic)):
                time_ns[i] = message.log_time
                values[i] = decode(message.data)
            return ScalarSeries(time_ns, values)

    def commands(self) -> tuple[tuple[int, Command], ...]:
        """Every recorded command with its simulation time [ns]; at the same time in the order in which they came."""
        return tuple((timed.time_ns, timed.request) for timed in self.requests() if isinstance(timed.request, Command))

    def requests(self) -> tuple[TimedRequest, ...]:
        """All that was asked of the run: commands, and changes of radio links after its start, as they came."""
        codec = RequestCodec(self.channels)
        begun: set[str] = set()
        requests: list[TimedRequest] = []
        with self._border():
            for topic, message in self._ordered(codec.topics):
                if message.log_time > LATEST_NS:
                    raise ValueError(f"{topic}: a message at {message.log_time} ns")
                if codec.is_state(topic) and topic not in begun:
                    begun.add(topic)  # how the link was when the run began
                else:
                    _check_room(requests, "commands")
                    requests.append(TimedRequest(message.log_time, codec.decode(topic, message.data)))
            return tuple(requests)

    def events(self) -> tuple[Event, ...]:
        """What happened, in order of time."""
        with self._border():
            events: list[Event] = []
            for message in self._messages(self.channels.events.topic):
                _check_room(events, "events")
                entry: Any = typestore().deserialize_cdr(message.data, LOG)
                events.append(Event(message.log_time, EventKind(entry.name.rpartition(".")[2]), entry.msg))
            return tuple(events)

    def state_messages(self) -> Iterator[Message]:
        """Couplers, vehicles, pressures, measurements and extremes as recorded, byte for byte, in order of time."""
        by_topic = {channel.topic: channel for channel in self.channels.state}
        with self._border():
            for topic, message in self._ordered(by_topic):
                yield Message(by_topic[topic], message.log_time, message.data)

    def _read_summary(self) -> tuple[Summary, Statistics]:
        profile = self._reader.get_header().profile
        if profile != "ros2":
            raise RecordingError(f"{self.path}: MCAP profile {profile!r}, expected 'ros2'")
        summary = self._reader.get_summary()
        if summary is None or summary.statistics is None:
            raise RecordingError(f"{self.path}: MCAP file without index, expected a recording of haul_ros")
        return summary, summary.statistics

    def _check_statistics(self) -> None:
        statistics, room = self._statistics, sum(chunk.uncompressed_size for chunk in self._summary.chunk_indexes)
        if statistics.message_end_time > LATEST_NS:
            raise ValueError(f"a message at {statistics.message_end_time} ns")
        if statistics.message_count * MESSAGE_HEAD > room:
            raise ValueError("more messages than its chunks have room for")

    def _read_metadata(self) -> dict[str, str]:
        records = descriptions(self._stream.fileno(), self._summary.metadata_indexes, RECORD_NAME)
        if not records:
            raise RecordingError(f"{self.path}: an MCAP file, but no recording of haul_ros")
        first, last = records[0], records[-1]
        if first.items() - last.items():
            raise ValueError("the descriptions of the run at its start and at its end differ")
        check_form(last)
        return last

    def _messages(self, topic: str) -> Iterator[McapMessage]:
        """As many messages as the statistics say, or ValueError."""
        read, expected = 0, self._topics.count(topic)
        for _, message in self._ordered([topic]):
            read += 1
            yield message
        if read != expected:
            raise ValueError(f"{topic}: {read} messages, expected {expected}")

    def _ordered(self, topics: Iterable[str], *, reverse: bool = False) -> Iterator[tuple[str, McapMessage]]:
        """Messages of topics, each with its topic, in order of time."""
        wanted = set(topics)
        by_id = {key: channel.topic for key, channel in self._summary.channels.items() if channel.topic in wanted}
        indexes = self._summary.chunk_indexes
        for message in ordered_messages(self._stream.fileno(), indexes, by_id.keys(), reverse=reverse):
            yield by_id[message.channel_id], message

    def _extremes(self, reverse: bool) -> Iterator[RecordedExtremes]:
        topics = [channel.topic for channel in self.channels.extremes]
        if self.has_times_in_velocity():
            topics = topics[:2]
        codec: JointStateCodec | None = None
        with self._border():
            found = self._ordered(topics, reverse=reverse)
            for time_ns, group in groupby(found, lambda entry: entry[1].log_time):
                data = {topic: message.data for topic, message in group}
                if len(data) < len(topics):  # cut off between them
                    continue
                codec = codec or self._codec_of(self.channels.couplers, data[topics[0]])
                compression, tension = (ExtremeArrays(*codec.decode(data[topic])) for topic in topics[:2])
                if len(topics) > 2:
                    times = (time_codec(codec.count).decode(data[topic]) for topic in topics[2:])
                    compression, tension = (
                        arrays._replace(time=time) for arrays, time in zip((compression, tension), times, strict=True)
                    )
                yield RecordedExtremes(time_ns, extremes_of(compression, tension))

    def _joint_codec(self, channel: Channel) -> JointStateCodec:
        """The codec for the messages of a channel, from the first of them; without names if there is none."""
        first = next(self._messages(channel.topic), None)
        return JointStateCodec(()) if first is None else self._codec_of(channel, first.data)

    def _codec_of(self, channel: Channel, data: bytes) -> JointStateCodec:
        _check_length(channel, data)
        codec = JointStateCodec.of(data)
        expected = int(self.metadata["vehicles" if channel == self.channels.vehicles else "couplers"])
        if codec.count != expected:
            raise ValueError(f"{channel.topic}: a message of {codec.count} names, expected {expected}")
        return codec

    def _joint_columns(self, channel: Channel) -> Columns:
        codec = self._joint_codec(channel)
        return Columns(channel.topic, codec, codec.names)

    def _sample_columns(self) -> tuple[Columns, Columns, Columns]:
        couplers, vehicles = map(self._joint_columns, (self.channels.couplers, self.channels.vehicles))
        return couplers, vehicles, _pressure_columns(self.channels.brake_cylinder_pressure, vehicles.names)

    def _filled(self, columns: Columns) -> Columns:
        self._columns.read([columns])
        return columns

    def _full_name(self, topic: str) -> str:
        if topic.startswith("/"):
            return topic
        name = f"{self.channels.prefix}/{topic}"
        return self.channels.remapped.get(name, name)

    def _border(self) -> AbstractContextManager[None]:
        return reading(self.path)


def _check_room(found: Sized, name: str) -> None:
    if len(found) >= MOST_ENTRIES:
        raise ValueError(f"more than {MOST_ENTRIES} {name}")


def _check_length(channel: Channel, data: bytes) -> None:
    if len(data) > LARGEST_STATE:
        raise ValueError(f"{channel.topic}: a message of {len(data)} bytes, expected at most {LARGEST_STATE}")


def _couplers(columns: Columns) -> CouplerSeries:
    return CouplerSeries(columns.time_ns, columns.names, **CouplerArrays(*columns.arrays)._asdict())


def _vehicles(columns: Columns) -> VehicleSeries:
    return VehicleSeries(columns.time_ns, columns.names, **VehicleArrays(*columns.arrays)._asdict())


def _pressure_columns(channel: Channel, vehicles: tuple[str, ...]) -> Columns:
    return Columns(channel.topic, pressure_codec(len(vehicles)), vehicles)


def _pressure(columns: Columns) -> PressureSeries:
    return PressureSeries(columns.time_ns, columns.names, *columns.arrays)


def _samples(couplers: Columns, vehicles: Columns, pressure: Columns) -> Samples:
    return Samples(_couplers(couplers), _vehicles(vehicles), _pressure(pressure))
