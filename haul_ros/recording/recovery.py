"""Unfinished, cut off and damaged recordings made whole, up to the first damage."""

from __future__ import annotations

import os
import struct
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Header, McapRecord, MessageIndex, Metadata
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC

from haul_ros.errors import RecordingError
from haul_ros.files import open_file
from haul_ros.messages.encoder import Message
from haul_ros.recording.description import check_form, described_channels
from haul_ros.recording.integrity import (
    DROPPED,
    WRITTEN,
    check_chunk,
    check_data_checksum,
    checked_description,
    message_count,
)
from haul_ros.recording.opening import another_kind
from haul_ros.recording.ordered import chunk_data, chunk_records
from haul_ros.recording.run_file import RECORD_NAME, SCENARIO_NAME, RunFile
from haul_ros.recording.sequences import OutOfOrderError, Sequences

RECOVERING_SUFFIX = ".recovering"
"""Added to the name of a file that is being recovered; ``.active`` may be the name of what it is recovered from."""

LONGEST_RECORD = 16 * 1024 * 1024
"""Bytes of memory for one record, whatever a damaged one says of its length; a chunk has little more than 1 MiB."""


@dataclass(frozen=True, slots=True)
class Recovery:
    """What was recovered: messages and the simulation time [ns] of the last of them (0 if there is none).

    ``missing`` messages were dropped while recording, or taken out of the file: they have left a gap in the numbers of
    their topic, between the simulation times [ns] in ``gaps``, but for the last ``unplaced`` ones, behind which none of
    their topic follows: of them the count of the recorder tells, if the file has its end. ``repeated`` messages were
    in the file again, and left out. ``bytes_lost`` follow the last byte that was of use; ``damage`` says what is
    wrong there, None: nothing.
    """

    messages: int
    end_ns: int
    missing: int
    unplaced: int
    gaps: tuple[tuple[int, int], ...]
    repeated: int
    bytes_lost: int
    damage: str | None


@dataclass(frozen=True, slots=True)
class Survey:
    """What can be trusted of a recording that cannot be opened: all before its first damage.

    ``description`` is that of the run, ``counts`` has messages by topic; the others are as in `Recovery`.
    """

    path: Path
    size: int
    description: dict[str, str]
    counts: dict[str, int]
    end_ns: int
    bytes_lost: int
    damage: str | None


def survey(path: Path) -> Survey:
    """Read a recording from its start to its first damage.

    Raises
    ------
    RecordingError
        It cannot be read, is no recording of haul_ros or is damaged before its first message.
    """
    try:
        with _Window(open_file(path).detach()) as stream:
            source = _Source(path, stream)
            description, _ = source.read_beginning()
            counts: Counter[str] = Counter()
            end_ns = 0
            for messages in source.chunks():
                counts.update(topic for topic, _ in messages)
                end_ns = max([end_ns, *(message.log_time for _, message in messages)])
            lost = source.size - source.good
            return Survey(path, source.size, description, dict(sorted(counts.items())), end_ns, lost, source.damage)
    except OSError as err:
        raise RecordingError(f"{path}: cannot be read: {err.strerror}") from err


def recover(source: Path, target: Path) -> Recovery:
    """Write all of a recording that lies before its first damage to a new file, and leave the recording as it is.

    Raises
    ------
    RecordingError
        ``source`` cannot be read, is no recording of haul_ros or is damaged before its first message; ``target``
        exists or cannot be written. There is no ``target`` then.
    """
    try:
        with _Window(open_file(source).detach()) as stream:
            return _recover(_Source(source, stream), target)
    except OSError as err:
        raise RecordingError(f"{source}: cannot be recovered: {err.strerror}") from err


def _recover(source: _Source, target: Path) -> Recovery:
    description, document = source.read_beginning()
    chunks = source.chunks()
    try:
        return _write(source, chunks, description, document, target, Sequences())
    except OutOfOrderError:
        deque(chunks, maxlen=0)  # to learn where all of them are
        return _write(source, source.chunks_by_time(), description, document, target, Sequences(late=True))


def _write(
    source: _Source,
    chunks: Iterable[_Messages],
    description: dict[str, str],
    document: str,
    target: Path,
    sequences: Sequences,
) -> Recovery:
    table = described_channels(description)
    file = RunFile(target, description, document, table, RECOVERING_SUFFIX)
    by_topic = {channel.topic: channel for channel in table}
    count = end_ns = 0
    try:
        for messages in chunks:
            for topic, message in messages:
                if topic not in file:
                    raise RecordingError(f"{source.path}: {topic} is no topic of a recording of this version")
                if not sequences.take(topic, message):
                    continue
                put = Message(by_topic[topic], message.log_time, message.data)
                file.add(put, message.sequence, message.publish_time)
                count += 1
                end_ns = max(end_ns, message.log_time)
            file.flush()
        # Without the recorder's own count it wrote at least what the numbers tell of.
        written = count + sequences.missing if source.written is None else source.written
        file.finish(source.dropped, written)
    except BaseException as err:
        if target.exists():  # come into being meanwhile: what was recovered keeps its other name
            raise
        file.abandon()
        file.active.unlink(missing_ok=True)
        if isinstance(err, OSError):
            raise RecordingError(f"{target}: cannot be written: {err.strerror}") from err
        raise
    unplaced = max(0, written + (source.dropped or 0) - count - sequences.missing)
    return Recovery(
        messages=count,
        end_ns=end_ns,
        missing=sequences.missing + unplaced,
        unplaced=unplaced,
        gaps=tuple(sequences.gaps) if sequences.missing else (),
        repeated=sequences.repeated,
        bytes_lost=source.size - source.good,
        damage=source.damage,
    )


_Messages = list[tuple[str, McapMessage]]
"""Each with its topic."""


class _Window(BufferedReader):
    """A file that is read up to ``end`` and no further, whatever a damaged length asks for."""

    end = 0

    def read(self, size: int | None = -1, /) -> bytes:
        rest = max(0, self.end - self.tell())
        return super().read(rest if size is None or size < 0 else min(size, rest))


class _Source:
    """A recording read from its start to its first damage; ``good`` bytes of it are of use.

    ``written`` and ``dropped`` are what the recorder says at the end (None: it does not).
    """

    def __init__(self, path: Path, stream: _Window) -> None:
        self.path = path
        self.size = os.fstat(stream.fileno()).st_size
        self.good = 0
        self.damage: str | None = None
        self.written: int | None = None
        self.dropped: int | None = None
        self._stream = stream
        self._topics: dict[int, str] = {}
        self._places: list[tuple[int, int]] = []
        self._records = self._read_records()

    def read_beginning(self) -> tuple[dict[str, str], str]:
        """Description of the run and scenario, which are written before the first message."""
        head = os.pread(self._stream.fileno(), len(MCAP0_MAGIC), 0)
        if head != MCAP0_MAGIC:
            raise RecordingError(f"{self.path}: {another_kind(head)}")
        description: dict[str, str] | None = None
        for record in self._records:
            if isinstance(record, Header) and record.profile != "ros2":
                raise RecordingError(f"{self.path}: MCAP profile {record.profile!r}, expected 'ros2'")
            if isinstance(record, Metadata) and record.name == RECORD_NAME:
                description = self._checked(record.metadata)
            if isinstance(record, Attachment) and record.name == SCENARIO_NAME and description is not None:
                try:
                    return description, record.data.decode()
                except UnicodeDecodeError as err:
                    self.damage = f"damaged scenario: {err}"
                    break
            if isinstance(record, Chunk):
                break
        if self.damage is None:
            raise RecordingError(f"{self.path}: an MCAP file, but no recording of haul_ros")
        raise RecordingError(f"{self.path}: nothing to recover: damaged before its first message: {self.damage}")

    def _checked(self, metadata: dict[str, str]) -> dict[str, str]:
        try:
            description = checked_description(metadata)
            check_form(description)
            return description
        except ValueError as err:
            raise RecordingError(f"{self.path}: nothing to recover: {err}") from err

    def chunks(self) -> Iterator[_Messages]:
        """The messages of each chunk, and in the end what the recorder says of their number."""
        for record in self._records:
            if isinstance(record, Chunk):
                try:
                    messages = self._messages(record)
                except Exception as err:  # whatever the libraries raise on damaged bytes
                    self.damage = f"damaged chunk: {type(err).__name__}: {err}"
                    return
                self._places.append((min((message.log_time for _, message in messages), default=0), self.good))
                yield messages
            elif isinstance(record, Metadata):
                if record.name == RECORD_NAME and not self._take_counts(record.metadata):
                    return
            elif not isinstance(record, MessageIndex):  # made anew
                self.damage = f"{type(record).__name__} where a chunk is expected"
                return

    def chunks_by_time(self) -> Iterator[_Messages]:
        """The same once more, in the order of simulation time."""
        for _, place in sorted(self._places):
            self._stream.seek(place)
            self._stream.end = place + LONGEST_RECORD
            record = next(iter(StreamReader(self._stream, skip_magic=True, emit_chunks=True).records))
            assert isinstance(record, Chunk)
            yield self._messages(record)

    def _messages(self, chunk: Chunk) -> _Messages:
        check_chunk(chunk)
        records = list(chunk_records(chunk_data(chunk)))
        self._topics |= {entry.id: entry.topic for entry in records if isinstance(entry, Channel)}
        messages = [entry for entry in records if isinstance(entry, McapMessage)]
        if unknown := {message.channel_id for message in messages} - self._topics.keys():
            raise ValueError(f"messages of channel {min(unknown)}, which is described nowhere before")
        return [(self._topics[message.channel_id], message) for message in messages]

    def _take_counts(self, metadata: dict[str, str]) -> bool:
        """Note how many messages the recorder wrote and dropped; whether it says so in numbers."""
        try:
            description = checked_description(metadata)
            self.written, self.dropped = (message_count(description, key) for key in (WRITTEN, DROPPED))
        except ValueError as err:
            self.damage = f"damaged record: {err}"
        return self.damage is None

    def _read_records(self) -> Iterator[McapRecord]:
        """Whole records up to the end of the data; ``damage`` is set if that is not reached.

        A record counts as good as soon as the next one is asked for.
        """
        self.good = self._stream.seek(len(MCAP0_MAGIC))
        self._stream.end = self.good + LONGEST_RECORD
        reader = StreamReader(self._stream, skip_magic=True, emit_chunks=True, record_size_limit=LONGEST_RECORD)
        try:
            for record in reader.records:
                end = self._stream.tell()
                self._compare(record, end)
                if isinstance(record, DataEnd):
                    begin, self.good = self.good, self.size
                    self._check_data(begin, record.data_section_crc)
                    return
                yield record
                self.good, self._stream.end = end, end + LONGEST_RECORD
        except OSError:
            raise
        except Exception as err:  # whatever the library raises on damaged bytes
            self.damage = self._damage(err)

    def _check_data(self, end: int, expected: int) -> None:
        try:
            check_data_checksum(self._stream.fileno(), end, expected)
        except ValueError as err:
            self.damage = str(err)

    def _compare(self, record: McapRecord, end: int) -> None:
        """Written again, a record must be the bytes from the last good one up to ``end``.

        The library checks neither the checksum of an attachment nor that a record ends where its length says, and
        skips records of unknown kinds without a word.
        """
        builder = RecordBuilder()
        record.write(builder)
        if builder.end() != os.pread(self._stream.fileno(), end - self.good, self.good):
            raise ValueError(f"{type(record).__name__} with another length or checksum")

    def _damage(self, err: Exception) -> str:
        """What is wrong behind the last good record."""
        kind = os.pread(self._stream.fileno(), 1, self.good)
        if kind and kind[0] not in set(Opcode):
            return f"no record of MCAP begins with {kind[0]}"
        if self._stream.tell() == self.size:
            return "the file ends too early"
        if isinstance(err, (EndOfFile, struct.error)):
            return f"damaged record: longer than {LONGEST_RECORD} bytes"
        return f"damaged record: {type(err).__name__}: {err}"
