"""Unfinished, cut off and damaged recordings made whole, up to the first damage."""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Header, Metadata
from mcap.records import Message as McapMessage
from mcap.stream_reader import breakup_chunk
from mcap.writer import MCAP0_MAGIC

from haul_ros.errors import HaulError, RecordingError
from haul_ros.messages.channels import channel_table
from haul_ros.messages.encoder import Message
from haul_ros.recording.run_file import RECORD_NAME, SCENARIO_NAME, RunFile

RECOVERING_SUFFIX = ".recovering"
"""Added to the name of a file that is being recovered; ``.active`` may be the name of what it is recovered from."""

_RECORD = struct.Struct("<BQ")


_INDEX_HEAD = struct.Struct("<HI")
_DATA_END_LENGTH = 4


@dataclass(frozen=True, slots=True)
class Recovery:
    """What was recovered: messages and the simulation time [ns] of the last of them (0 if there is none).

    ``missing`` messages have left a gap in the numbers of their topic: the recorder dropped them. ``bytes_lost``
    follow the last byte that was of use; ``damage`` says what is wrong there, None: nothing, all was recovered.
    """

    messages: int
    end_ns: int
    missing: int
    bytes_lost: int
    damage: str | None


def recover(source: Path, target: Path) -> Recovery:
    """Write all of a recording that lies before its first damage to a new file, and leave the recording as it is.

    Raises
    ------
    RecordingError
        ``source`` cannot be read, is no recording of haul_ros or is damaged before its first message; ``target``
        exists or cannot be written. There is no ``target`` then.
    """
    try:
        with source.open("rb") as stream:
            return _recover(_Source(source, stream), target)
    except OSError as err:
        raise RecordingError(f"{source}: cannot be recovered: {err.strerror}") from err


def _recover(source: _Source, target: Path) -> Recovery:
    description, document = source.read_beginning()
    try:
        table = channel_table(json.loads(description["locomotives"]), description["topic_prefix"])
        file = RunFile(target, description, document, table, RECOVERING_SUFFIX)
    except (KeyError, ValueError) as err:
        raise RecordingError(f"{source.path}: its description of the run is damaged: {err}") from err
    by_topic = {channel.topic: channel for channel in table}
    highest: dict[str, int] = {}
    counts: Counter[str] = Counter()
    end_ns = 0
    try:
        for messages in source.chunks():
            for topic, message in messages:
                if topic not in file:
                    raise RecordingError(f"{source.path}: {topic} is no topic of a recording of this version")
                put = Message(by_topic[topic], message.log_time, message.data)
                file.add(put, message.sequence, message.publish_time)
                counts[topic] += 1
                highest[topic] = max(highest.get(topic, 0), message.sequence)
                end_ns = max(end_ns, message.log_time)
            file.flush()
        file.finish(dropped=None)
    except BaseException as err:
        if target.exists():  # come into being meanwhile: what was recovered keeps its other name
            raise
        file.abandon()
        file.active.unlink(missing_ok=True)
        if isinstance(err, OSError):
            raise RecordingError(f"{target}: cannot be written: {err.strerror}") from err
        raise
    missing = sum(number + 1 - counts[topic] for topic, number in highest.items())
    return Recovery(counts.total(), end_ns, missing, source.size - source.good, source.damage)


class _Record(NamedTuple):
    opcode: int
    content: bytes


class _Source:
    """A recording read from its start to its first damage; ``good`` bytes of it are of use."""

    def __init__(self, path: Path, stream: BinaryIO) -> None:
        self.path = path
        self.size = os.fstat(stream.fileno()).st_size
        self.good = 0
        self.damage: str | None = None
        self._stream = stream

    def read_beginning(self) -> tuple[dict[str, str], str]:
        """Description of the run and scenario, which are written before the first message."""
        if self._stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            kind = "not an MCAP file" if self.size else "empty"
            raise RecordingError(f"{self.path}: {kind}, expected a recording of haul_ros")
        self.good = len(MCAP0_MAGIC)
        description: dict[str, str] | None = None
        for record in self._records():
            try:
                content = ReadDataStream(BytesIO(record.content))
                if record.opcode == Opcode.HEADER and (profile := Header.read(content).profile) != "ros2":
                    raise RecordingError(f"{self.path}: MCAP profile {profile!r}, expected 'ros2'")
                if record.opcode == Opcode.METADATA and (found := Metadata.read(content)).name == RECORD_NAME:
                    description = found.metadata
                if record.opcode == Opcode.ATTACHMENT and description is not None:
                    if zlib.crc32(record.content[:-4]) != int.from_bytes(record.content[-4:], "little"):
                        raise ValueError("attachment with another checksum")
                    if (attached := Attachment.read(content)).name == SCENARIO_NAME:
                        return description, attached.data.decode()
                if record.opcode == Opcode.CHUNK:
                    break
            except HaulError:
                raise
            except Exception as err:
                self.damage = f"{type(err).__name__}: {err}"
                break
        if self.damage is None:
            raise RecordingError(f"{self.path}: an MCAP file, but no recording of haul_ros")
        raise RecordingError(f"{self.path}: nothing to recover: damaged before its first message: {self.damage}")

    def chunks(self) -> Iterator[list[tuple[str, McapMessage]]]:
        """The messages of each chunk with their topics."""
        topics: dict[int, str] = {}
        for record in self._records():
            before = self.good - _RECORD.size - len(record.content)
            if record.opcode == Opcode.CHUNK:
                try:
                    chunk = Chunk.read(ReadDataStream(BytesIO(record.content)))
                    records = breakup_chunk(chunk, validate_crc=True)
                    topics |= {entry.id: entry.topic for entry in records if isinstance(entry, Channel)}
                    messages = [
                        (topics[entry.channel_id], entry) for entry in records if isinstance(entry, McapMessage)
                    ]
                except Exception as err:  # whatever the libraries raise on damaged bytes
                    self.good, self.damage = before, f"damaged chunk: {type(err).__name__}: {err}"
                    return
                yield messages
            elif not _stands_between_chunks(record):
                self.good, self.damage = before, f"unexpected record {record.opcode}"
                return

    def _records(self) -> Iterator[_Record]:
        """Whole records up to the end of the data; ``damage`` tells if that is not reached."""
        while True:
            head = self._stream.read(_RECORD.size)
            if len(head) < _RECORD.size:
                self.damage = "the file ends too early"
                return
            opcode, length = _RECORD.unpack(head)
            if not Opcode.HEADER <= opcode <= Opcode.DATA_END:
                self.damage = f"no record of MCAP begins with {opcode}"
                return
            if length > self.size - self.good - _RECORD.size:
                self.damage = "the file ends within a record"
                return
            content = self._stream.read(length)
            self.good += _RECORD.size + length
            if opcode == Opcode.DATA_END and length == _DATA_END_LENGTH:
                self.good = self.size
                return
            yield _Record(opcode, content)


def _stands_between_chunks(record: _Record) -> bool:
    """Whether it is a message index of fitting length, or metadata; both are made anew."""
    if record.opcode != Opcode.MESSAGE_INDEX:
        return record.opcode == Opcode.METADATA
    if len(record.content) < _INDEX_HEAD.size:
        return False
    _, length = _INDEX_HEAD.unpack_from(record.content)
    return len(record.content) == _INDEX_HEAD.size + int(length)
