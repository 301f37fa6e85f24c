"""Messages of any bag one by one, in the order of its files: MCAP, finished or not, chunked or not, and SQLite."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

from mcap.records import Attachment, Channel, Chunk, DataEnd, Header, Message, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC
from rosbags.rosbag2 import Reader

from haul_ros.errors import RecordingError
from haul_ros.files import open_file
from haul_ros.recording.integrity import LARGEST_CHUNK, LARGEST_RECORD, check_chunk
from haul_ros.recording.opening import another_kind, open_existing, reading
from haul_ros.recording.ordered import chunk_data, chunk_records
from haul_ros.recording.run_file import SCENARIO_NAME

_METADATA = "metadata.yaml"
_COMPRESSED = re.compile(r"^\s*compression_mode:\s*['\"]?(file|message)\b", re.IGNORECASE | re.MULTILINE)
_MOST_METADATA = 4 * 1024 * 1024
"""Bytes of a bag's metadata.yaml, as of any YAML file."""
_MOST_FILES = 10_000
_SUFFIXES = (".mcap", ".db3")
_SQLITE = b"SQLite format 3\0"


class RawMessage(NamedTuple):
    """A message as recorded: topic, message type, time by the clock of its recorder [ns], CDR bytes."""

    topic: str
    msgtype: str
    log_time: int
    data: bytes


class RawMessages:
    """The messages of a file or of the folder of a bag, split or not; may be iterated again and again.

    ``library`` is the program that has written the first MCAP file ("": not known), ``scenario_document`` the scenario
    that a recording of haul_ros carries, ``cut_off`` what is wrong with the end of an unfinished file, each None or
    empty before it has been come to.

    Raises
    ------
    RecordingError
        There are no such files, or they are of another kind. Iterating: one is damaged.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.files = _files(path)
        self.library = ""
        self.scenario_document: str | None = None
        self.cut_off: str | None = None

    def select(self, topics: Collection[str] | None = None) -> Iterator[RawMessage]:
        """Messages of some topics, None: of all."""
        for file in self.files:
            with reading(file):
                yield from self._mcap(file, topics) if _is_mcap(file) else _rosbag(file, topics)

    def _mcap(self, path: Path, topics: Collection[str] | None) -> Iterator[RawMessage]:
        """Of a file without its end all that is whole before; of one with its end all, or it is damaged."""
        schemas: dict[int, str] = {}
        channels: dict[int, tuple[str, str]] = {}
        with open_file(path) as stream:
            finished = _ends_well(path, stream.fileno())
            reader = StreamReader(stream, emit_chunks=True, record_size_limit=LARGEST_CHUNK)
            records = iter(reader.records)
            while True:
                try:
                    record = next(records, None)
                    whole = list(_whole(record)) if record is not None else []
                except OSError:
                    raise
                except Exception as error:  # whatever the libraries raise on bytes that are cut off
                    if finished:
                        raise
                    self.cut_off = f"{path.name}: unfinished or cut off, {type(error).__name__}"
                    return
                if record is None or isinstance(record, DataEnd):
                    return
                for entry in whole:
                    if isinstance(entry, Schema):
                        schemas[entry.id] = entry.name
                    elif isinstance(entry, Channel):
                        channels[entry.id] = entry.topic, schemas.get(entry.schema_id, "")
                    elif isinstance(entry, Message):
                        topic, msgtype = channels[entry.channel_id]
                        if topics is None or topic in topics:
                            yield RawMessage(topic, msgtype, entry.log_time, entry.data)
                    elif isinstance(entry, Header):
                        self.library = self.library or entry.library
                    elif entry.name == SCENARIO_NAME and len(entry.data) <= LARGEST_RECORD:
                        self.scenario_document = entry.data.decode()


def _whole(record: object) -> Iterator[Schema | Channel | Message | Header | Attachment]:
    """A record, or those of a chunk."""
    if isinstance(record, Chunk):
        check_chunk(record)
        yield from chunk_records(chunk_data(record))
    elif isinstance(record, Schema | Channel | Message | Header | Attachment):
        yield record


def _rosbag(path: Path, topics: Collection[str] | None) -> Iterator[RawMessage]:
    """Of SQLite, or of a folder whose files or messages are compressed."""
    with Reader(path) as reader:
        chosen = [c for c in reader.connections if topics is None or c.topic in topics]
        if chosen:
            for connection, log_time, data in reader.messages(connections=chosen):
                yield RawMessage(connection.topic, connection.msgtype, log_time, bytes(data))


def _ends_well(path: Path, file: int) -> bool:
    """Whether a file ends as MCAP files do; RecordingError: it does not begin so."""
    size, length = os.fstat(file).st_size, len(MCAP0_MAGIC)
    if (head := os.pread(file, length, 0)) != MCAP0_MAGIC:
        raise RecordingError(f"{path}: {another_kind(head)}, or a bag")
    return size >= 2 * length and os.pread(file, length, size - length) == MCAP0_MAGIC


def _is_mcap(path: Path) -> bool:
    """Whether a file is read as MCAP; a database or a folder is left to the library."""
    if path.is_dir():
        return False
    with open_existing(path) as stream:
        return stream.read(len(_SQLITE)) != _SQLITE


def _files(path: Path) -> list[Path]:
    """The files of a bag in their order; the folder itself where its files or messages are compressed."""
    if not path.is_dir():
        open_existing(path).close()
        return [path]
    with reading(path):
        if _is_compressed(path / _METADATA):
            return [path]
        files = [file for file in path.iterdir() if file.suffix in _SUFFIXES]
    if not files:
        raise RecordingError(f"{path}: a folder without files of a bag, expected {' or '.join(_SUFFIXES)} in it")
    if len(files) > _MOST_FILES:
        raise RecordingError(f"{path}: a folder of {len(files)} files of a bag, expected at most {_MOST_FILES}")
    return sorted(files, key=_numbered)


def _numbered(path: Path) -> tuple[str, int, str]:
    """``bag_2.mcap`` comes before ``bag_10.mcap``."""
    stem, number = re.fullmatch(r"(.*?)([0-9]{0,18})", path.stem, re.DOTALL).groups()  # type: ignore[union-attr]
    return stem, int(number or 0), path.suffix


def _is_compressed(metadata: Path) -> bool:
    if not metadata.exists():
        return False
    with open_file(metadata) as stream:
        text = stream.read(_MOST_METADATA).decode(errors="replace")
    return _COMPRESSED.search(text) is not None
