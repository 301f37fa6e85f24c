"""Recordings read back: what a file is, and its series as arrays."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, NamedTuple

import numpy as np
from mcap.reader import SeekingReader
from mcap.records import Message as McapMessage
from mcap.records import Statistics
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray

from haul_ros.errors import HaulError, RecordingError
from haul_ros.messages.cdr import ArrayCodec, JointStateCodec, decode_bool, decode_float64, typestore
from haul_ros.messages.channels import BOOL, FLOAT64, LOG, ChannelTable, channel_table
from haul_ros.messages.encoder import LOGGER, Message
from haul_ros.messages.requests import RequestCodec
from haul_ros.model.command import Command
from haul_ros.model.event import Event, EventKind
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import FloatArray
from haul_ros.recording.chunks import Run, load_chunks, runs
from haul_ros.recording.run_file import ACTIVE_SUFFIX, RECORD_NAME, SCENARIO_NAME, recovery_hint
from haul_ros.units import NS_PER_S

TimeArray = NDArray[np.int64]

_SCALARS: Mapping[str, Callable[[bytes], float]] = {FLOAT64: decode_float64, BOOL: decode_bool}


@dataclass(frozen=True, slots=True)
class TopicInfo:
    """A topic of a recording and how many messages it has."""

    topic: str
    msgtype: str
    count: int


@dataclass(frozen=True, slots=True)
class RecordingInfo:
    """What is in a recording. Times are simulation times; without messages both are 0.

    ``compression`` is that of the chunks; ``dropped`` is how many messages the recorder could not write
    (None: not known, it did not end); ``topics`` are sorted by name.
    """

    path: Path
    size: int
    version: str
    scenario: str
    description: str
    time_step: float
    vehicles: int
    couplers: int
    locomotives: tuple[str, ...]
    compression: str
    topics: tuple[TopicInfo, ...]
    messages: int
    start_ns: int
    end_ns: int
    dropped: int | None

    @property
    def duration(self) -> float:
        """From the first to the last message [s]."""
        return (self.end_ns - self.start_ns) / NS_PER_S

    @property
    def complete(self) -> bool:
        """The recorder ended well and dropped nothing."""
        return self.dropped == 0


@dataclass(frozen=True, slots=True, eq=False)
class JointSeries:
    """A JointState topic over time: ``time_ns`` (n,), k ``names``, the others (n, k).

    Couplers: stroke [m], stroke rate [m/s], force [N], compression positive. Vehicles: chainage [m], speed [m/s],
    brake force [N]. Extremes: stroke [m], time of the largest force [s], force [N].
    """

    time_ns: TimeArray
    names: tuple[str, ...]
    position: FloatArray
    velocity: FloatArray
    effort: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class PressureSeries:
    """Brake cylinder pressure [Pa] (n, k) of the k vehicles ``names`` at ``time_ns`` (n,)."""

    time_ns: TimeArray
    names: tuple[str, ...]
    pressure: FloatArray


class ScalarSeries(NamedTuple):
    """A number over time: ``time_ns`` (n,) and ``values`` (n,); a Bool is 0 or 1."""

    time_ns: TimeArray
    values: FloatArray


class Samples(NamedTuple):
    """What was sampled of the train."""

    couplers: JointSeries
    vehicles: JointSeries
    pressure: PressureSeries


class _Columns:
    """Arrays of a topic while they are filled: ``time_ns`` (n,) and the codec's arrays (n, k)."""

    def __init__(self, topic: str, codec: JointStateCodec | ArrayCodec) -> None:
        self.topic = topic
        self.codec = codec
        self.allocate(0)

    def allocate(self, count: int) -> None:
        """New arrays for so many messages."""
        number = 3 if isinstance(self.codec, JointStateCodec) else 1
        self.time_ns = np.empty(count, np.int64)
        self.arrays = [np.empty((count, self.codec.count)) for _ in range(number)]
        self._end = 0

    def add(self, pieces: Iterable[Run]) -> None:
        """Append messages."""
        for run in pieces:
            start, self._end = self._end, self._end + len(run.time_ns)
            self.time_ns[start : self._end] = run.time_ns
            for array, values in zip(self.arrays, self.codec.decode_many(run.messages), strict=True):
                array[start : self._end] = values

    def fill(self, pieces: list[Run]) -> None:
        """Begin anew with these messages alone."""
        self.allocate(sum(len(run.time_ns) for run in pieces))
        self.add(pieces)


class Recording:
    """A finished recording of haul_ros, opened for reading; a context manager.

    Every method reads what it returns from the file, in order of simulation time, and raises RecordingError if the
    file turns out to be damaged there.

    Raises
    ------
    RecordingError
        The file cannot be opened, is unfinished or cut off, is no MCAP file or no recording of haul_ros.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._stream = _open(self.path)
        try:
            with self._border():
                self._size = os.fstat(self._stream.fileno()).st_size
                # No record is longer than the file, whatever a damaged one says.
                self._reader = SeekingReader(self._stream, validate_crcs=True, record_size_limit=self._size)
                self._summary, self._statistics = self._read_summary()
                self.metadata = self._read_metadata()
                """Description of the run by the recorder, as text."""
                locomotives: list[str] = json.loads(self.metadata["locomotives"])
                self.channels: ChannelTable = channel_table(locomotives, self.metadata["topic_prefix"])
                """The topics that the recorder knew."""
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
            for attachment in self._reader.iter_attachments():
                if attachment.name == SCENARIO_NAME:
                    return attachment.data.decode()
        raise RecordingError(f"{self.path}: has no attachment {SCENARIO_NAME}")

    def info(self) -> RecordingInfo:
        """Facts about the file, without reading its messages."""
        with self._border():
            statistics = self._statistics
            dropped = self.metadata.get("messages_dropped")
            names = sorted(channel.topic for channel in self._summary.channels.values())
            return RecordingInfo(
                path=self.path,
                size=self._size,
                version=self.metadata["version"],
                scenario=self.metadata["scenario"],
                description=self.metadata["description"],
                time_step=float(self.metadata["time_step"]),
                vehicles=int(self.metadata["vehicles"]),
                couplers=int(self.metadata["couplers"]),
                locomotives=tuple(json.loads(self.metadata["locomotives"])),
                compression=", ".join(sorted({c.compression or "none" for c in self._summary.chunk_indexes})) or "none",
                topics=tuple(TopicInfo(name, self._msgtype(name), self._count(name)) for name in names),
                messages=statistics.message_count,
                start_ns=statistics.message_start_time,
                end_ns=statistics.message_end_time,
                dropped=None if dropped is None else int(dropped),
            )

    def couplers(self) -> JointSeries:
        """Stroke, stroke rate and force of every coupler."""
        return self._joints(self.channels.couplers.topic)

    def vehicles(self) -> JointSeries:
        """Chainage, speed and brake force of every vehicle."""
        return self._joints(self.channels.vehicles.topic)

    def pressure(self) -> PressureSeries:
        """Brake cylinder pressure of every vehicle; names are those of the vehicles' topic."""
        with self._border():
            codec = self._joint_codec(self.channels.vehicles.topic)
            (pressure,) = self._read([self._pressure_columns(codec)])
            return PressureSeries(pressure.time_ns, codec.names, *pressure.arrays)

    def samples(self) -> Samples:
        """Couplers, vehicles and pressure in one go, faster than one by one."""
        with self._border():
            return _samples(self._read(self._sample_columns()))

    def blocks(self) -> Iterator[Samples]:
        """The same piece by piece, for files larger than memory.

        A piece is what lies in one chunk of the file, so its series may differ in length by a sample, or be empty.
        """
        with self._border():
            columns = self._sample_columns()
            for pieces in self._runs_by_chunk(columns):
                for column, found in zip(columns, pieces, strict=True):
                    column.fill(found)
                yield _samples(columns)

    def max_compression(self) -> JointSeries:
        """Largest buff force of every coupler so far, with stroke and time."""
        return self._joints(self.channels.max_compression.topic)

    def max_tension(self) -> JointSeries:
        """Largest draft force of every coupler so far, with stroke and time; force and stroke negative."""
        return self._joints(self.channels.max_tension.topic)

    def last_extremes(self) -> tuple[JointSeries, JointSeries] | None:
        """The newest of `max_compression` and `max_tension`, each a series of one; None if there is none."""
        topics = (self.channels.max_compression.topic, self.channels.max_tension.topic)
        with self._border():
            found = []
            for topic in topics:
                newest = next(self._reader.iter_messages(topics=[topic], reverse=True), None)
                if newest is None:
                    return None
                codec = JointStateCodec.of(newest[2].data)
                arrays = (values[np.newaxis] for values in codec.decode(newest[2].data))
                found.append(JointSeries(np.array([newest[2].log_time]), codec.names, *arrays))
            return found[0], found[1]

    def scalars(self, topic: str) -> ScalarSeries:
        """A Float64 or Bool topic, by full name or relative to the node: ``slave_1/radio_delay``.

        Raises
        ------
        RecordingError
            There is no such topic, or it is of another type.
        """
        topic = self._full_name(topic)
        with self._border():
            msgtype = self._msgtype(topic)
            if msgtype not in _SCALARS:
                raise RecordingError(f"{self.path}: {topic} is {msgtype}, expected {FLOAT64} or {BOOL}")
            decode = _SCALARS[msgtype]
            count = self._count(topic)
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
            for _, channel, message in self._reader.iter_messages(topics=codec.topics):
                if codec.is_state(channel.topic) and channel.topic not in begun:
                    begun.add(channel.topic)  # how the link was when the run began
                else:
                    requests.append(TimedRequest(message.log_time, codec.decode(channel.topic, message.data)))
            return tuple(requests)

    def events(self) -> tuple[Event, ...]:
        """What happened, in order of time."""
        with self._border():
            entries = [
                (message.log_time, typestore().deserialize_cdr(message.data, LOG))
                for message in self._messages(self.channels.events.topic)
            ]
            return tuple(
                Event(time_ns, EventKind(entry.name.removeprefix(LOGGER)), entry.msg)  # type: ignore[attr-defined]
                for time_ns, entry in entries
            )

    def sample_messages(self) -> Iterator[Message]:
        """Couplers, vehicles and brake cylinder pressure as recorded, byte for byte, in order of time."""
        table = self.channels
        by_topic = {
            channel.topic: channel for channel in (table.couplers, table.vehicles, table.brake_cylinder_pressure)
        }
        with self._border():
            for _, channel, message in self._reader.iter_messages(topics=list(by_topic)):
                yield Message(by_topic[channel.topic], message.log_time, message.data)

    def _read_summary(self) -> tuple[Summary, Statistics]:
        profile = self._reader.get_header().profile
        if profile != "ros2":
            raise RecordingError(f"{self.path}: MCAP profile {profile!r}, expected 'ros2'")
        summary = self._reader.get_summary()
        if summary is None or summary.statistics is None:
            raise RecordingError(f"{self.path}: MCAP file without index, expected a recording of haul_ros")
        return summary, summary.statistics

    def _read_metadata(self) -> dict[str, str]:
        # The record of the end holds all that the one of the start does.
        records = [record.metadata for record in self._reader.iter_metadata() if record.name == RECORD_NAME]
        if not records:
            raise RecordingError(f"{self.path}: an MCAP file, but no recording of haul_ros")
        return records[-1]

    def _channel_id(self, topic: str) -> int:
        for key, channel in self._summary.channels.items():
            if channel.topic == topic:
                return key
        known = ", ".join(sorted(channel.topic for channel in self._summary.channels.values()))
        raise RecordingError(f"{self.path}: no topic {topic}; it has {known}")

    def _msgtype(self, topic: str) -> str:
        channel = self._summary.channels[self._channel_id(topic)]
        return self._summary.schemas[channel.schema_id].name

    def _count(self, topic: str) -> int:
        return self._statistics.channel_message_counts.get(self._channel_id(topic), 0)

    def _messages(self, topic: str) -> Iterator[McapMessage]:
        """As many messages as the statistics say, or ValueError."""
        read = 0
        for _, _, message in self._reader.iter_messages(topics=[topic]):
            read += 1
            yield message
        if read != self._count(topic):
            raise ValueError(f"{topic}: {read} messages, expected {self._count(topic)}")

    def _joint_codec(self, topic: str) -> JointStateCodec:
        """The codec for the messages of a topic, from the first of them; without names if there is none."""
        first = next(self._messages(topic), None)
        return JointStateCodec(()) if first is None else JointStateCodec.of(first.data)

    def _joints(self, topic: str) -> JointSeries:
        with self._border():
            codec = self._joint_codec(topic)
            (column,) = self._read([_Columns(topic, codec)])
            return JointSeries(column.time_ns, codec.names, *column.arrays)

    def _pressure_columns(self, vehicles: JointStateCodec) -> _Columns:
        return _Columns(self.channels.brake_cylinder_pressure.topic, ArrayCodec("vehicle", len(vehicles.names)))

    def _sample_columns(self) -> list[_Columns]:
        couplers, vehicles = self.channels.couplers.topic, self.channels.vehicles.topic
        codec = self._joint_codec(vehicles)
        return [
            _Columns(couplers, self._joint_codec(couplers)),
            _Columns(vehicles, codec),
            self._pressure_columns(codec),
        ]

    def _read(self, columns: list[_Columns]) -> list[_Columns]:
        """The columns, filled with all messages of their topics."""
        for column in columns:
            column.allocate(self._count(column.topic))
        for pieces in self._runs_by_chunk(columns):
            for column, found in zip(columns, pieces, strict=True):
                column.add(found)
        return columns

    def _runs_by_chunk(self, columns: list[_Columns]) -> Iterator[list[list[Run]]]:
        """Messages of each column's topic, in order of time; as many as the statistics say, or ValueError."""
        channels = [self._channel_id(column.topic) for column in columns]
        read, last_ns = [0] * len(columns), [0] * len(columns)
        for chunk in load_chunks(self._stream.fileno(), self._summary.chunk_indexes, channels):
            pieces = []
            for i, (column, channel) in enumerate(zip(columns, channels, strict=True)):
                found = list(runs(chunk, channel, column.codec.size)) if channel in chunk.entries else []
                for time_ns in (run.time_ns for run in found):
                    if time_ns[0] < last_ns[i] or (np.diff(time_ns) < 0).any():
                        raise ValueError(f"{column.topic}: messages are not in order of time")
                    read[i], last_ns[i] = read[i] + len(time_ns), int(time_ns[-1])
                pieces.append(found)
            yield pieces
        for column, count in zip(columns, read, strict=True):
            if count != self._count(column.topic):
                raise ValueError(f"{column.topic}: {count} messages, expected {self._count(column.topic)}")

    def _full_name(self, topic: str) -> str:
        return topic if topic.startswith("/") else f"{self.channels.prefix}/{topic}"

    @contextmanager
    def _border(self) -> Iterator[None]:
        """Whatever the libraries raise on damaged bytes becomes one error that names the file."""
        try:
            yield
        except HaulError:
            raise
        except OSError as err:
            raise RecordingError(f"{self.path}: cannot be read: {err.strerror}") from err
        except Exception as err:
            raise RecordingError(f"{self.path}: damaged recording: {type(err).__name__}: {err}") from err


def _samples(columns: list[_Columns]) -> Samples:
    couplers, vehicles, pressure = columns
    assert isinstance(couplers.codec, JointStateCodec)
    assert isinstance(vehicles.codec, JointStateCodec)
    return Samples(
        JointSeries(couplers.time_ns, couplers.codec.names, *couplers.arrays),
        JointSeries(vehicles.time_ns, vehicles.codec.names, *vehicles.arrays),
        PressureSeries(pressure.time_ns, vehicles.codec.names, *pressure.arrays),
    )


def _open(path: Path) -> BinaryIO:
    """Open a file that begins and ends as MCAP files do, or say what is wrong with it."""
    active = path.with_name(path.name + ACTIVE_SUFFIX)
    try:
        stream = path.open("rb")
    except FileNotFoundError:
        hint = f"; an unfinished recording {active.name} lies there, {recovery_hint(active)}" if active.exists() else ""
        raise RecordingError(f"{path}: no such file{hint}") from None
    except OSError as err:
        raise RecordingError(f"{path}: cannot be read: {err.strerror}") from err
    try:
        head = stream.read(len(MCAP0_MAGIC))
        stream.seek(max(len(head), stream.seek(0, os.SEEK_END) - len(MCAP0_MAGIC)))
        tail = stream.read()
        stream.seek(0)
    except OSError as err:
        stream.close()
        raise RecordingError(f"{path}: cannot be read: {err.strerror}") from err
    if head == tail == MCAP0_MAGIC:
        return stream
    stream.close()
    if head != MCAP0_MAGIC:
        raise RecordingError(f"{path}: {'not an MCAP file' if head else 'empty'}, expected a recording of haul_ros")
    if path.suffix == ACTIVE_SUFFIX:
        raise RecordingError(f"{path}: unfinished: its recorder still writes or was killed; {recovery_hint(path)}")
    raise RecordingError(f"{path}: unfinished or cut off: does not end as an MCAP file does; {recovery_hint(path)}")
