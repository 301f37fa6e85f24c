"""Recordings read back: what a file is, and its series as arrays."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
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
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.sample import FloatArray
from haul_ros.recording.channels import BOOL, FLOAT64, ChannelTable, channel_table
from haul_ros.recording.encoding import ArrayCodec, JointStateCodec, decode_bool, decode_float64
from haul_ros.recording.run_file import ACTIVE_SUFFIX, RECORD_NAME, SCENARIO_NAME
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
                size = os.fstat(self._stream.fileno()).st_size  # no record is longer, whatever a damaged one says
                self._reader = SeekingReader(self._stream, validate_crcs=True, record_size_limit=size)
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
                size=os.fstat(self._stream.fileno()).st_size,
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

    def max_compression(self) -> JointSeries:
        """Largest buff force of every coupler so far, with stroke and time."""
        return self._joints(self.channels.max_compression.topic)

    def max_tension(self) -> JointSeries:
        """Largest draft force of every coupler so far, with stroke and time; force and stroke negative."""
        return self._joints(self.channels.max_tension.topic)

    def pressure(self) -> PressureSeries:
        """Brake cylinder pressure of every vehicle; names are those of the vehicles' topic."""
        topic = self.channels.brake_cylinder_pressure.topic
        with self._border():
            count, names = self._count(topic), self._joint_codec(self.channels.vehicles.topic).names
            codec = ArrayCodec("vehicle", len(names))
            time_ns, values = np.empty(count, np.int64), np.empty((count, len(names)))
            for i, message in enumerate(self._messages(topic)):
                time_ns[i] = message.log_time
                values[i] = codec.decode(message.data)
            return PressureSeries(time_ns, names, values)

    def scalars(self, topic: str) -> ScalarSeries:
        """A Float64 or Bool topic, by full name or relative to the node: ``slave_1/radio_delay``.

        Raises
        ------
        RecordingError
            There is no such topic, or it is of another type.
        """
        if not topic.startswith("/"):
            topic = f"{self.channels.prefix}/{topic}"
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
        senders: dict[str, tuple[str, CommandKind]] = {
            channel.topic: (locomotive, kind)
            for kind, by_locomotive in self.channels.commands.items()
            for locomotive, channel in by_locomotive.items()
        }
        with self._border():
            commands = []
            for _, channel, message in self._reader.iter_messages(topics=list(senders)):
                locomotive, kind = senders[channel.topic]
                decode = decode_bool if kind is CommandKind.EMERGENCY else decode_float64
                commands.append((message.log_time, Command(locomotive, kind, float(decode(message.data)))))
            return tuple(commands)

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
            count, codec = self._count(topic), self._joint_codec(topic)
            shape = (count, len(codec.names))
            time_ns = np.empty(count, np.int64)
            position, velocity, effort = np.empty(shape), np.empty(shape), np.empty(shape)
            for i, message in enumerate(self._messages(topic)):
                time_ns[i] = message.log_time
                position[i], velocity[i], effort[i] = codec.decode(message.data)
            return JointSeries(time_ns, codec.names, position, velocity, effort)

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


def _open(path: Path) -> BinaryIO:
    """Open a file that begins and ends as MCAP files do, or say what is wrong with it."""
    active = path.with_name(path.name + ACTIVE_SUFFIX)
    try:
        stream = path.open("rb")
    except FileNotFoundError:
        hint = f"; an unfinished recording {active.name} lies there" if active.exists() else ""
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
        raise RecordingError(f"{path}: unfinished: its recorder still writes or was killed")
    raise RecordingError(f"{path}: unfinished or cut off: does not end as an MCAP file does")
