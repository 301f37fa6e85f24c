"""Topics of fixed layout read into arrays, chunk by chunk."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from mcap.records import ChunkIndex

from haul_ros.messages.cdr import ArrayCodec, Float64Codec, JointStateCodec
from haul_ros.recording.chunks import Run, load_chunks, runs
from haul_ros.recording.topics import TopicIndex


class Columns:
    """Arrays of a topic while they are filled: ``time_ns`` (n,) and the ``arrays`` (n, k) of its codec, k ``names``.

    Those that its messages do without are of shape (n, 0).
    """

    def __init__(self, topic: str, codec: JointStateCodec | ArrayCodec | Float64Codec, names: tuple[str, ...]) -> None:
        self.topic = topic
        self.codec = codec
        self.names = names
        self.allocate(0)

    def allocate(self, count: int) -> None:
        """New arrays for so many messages."""
        self.time_ns = np.empty(count, np.int64)
        self.arrays = [np.empty((count, length)) for length in self.codec.counts]
        self._end = 0

    def add(self, pieces: Sequence[Run]) -> None:
        """Append messages."""
        for run in pieces:
            start, self._end = self._end, self._end + len(run.time_ns)
            self.time_ns[start : self._end] = run.time_ns
            for array, values in zip(self.arrays, self.codec.decode_many(run.messages), strict=True):
                array[start : self._end] = values


class ColumnReader:
    """Fills columns from the chunks of an open file descriptor.

    Both methods raise ValueError for messages of another layout, out of order of time, or more or fewer than the index
    of the file says.
    """

    def __init__(self, file: int, chunks: Sequence[ChunkIndex], index: TopicIndex) -> None:
        self._file = file
        self._chunks = chunks
        self._index = index

    def read(self, columns: Sequence[Columns]) -> None:
        """Fill the columns with all messages of their topics."""
        room = sum(chunk.uncompressed_size for chunk in self._chunks)
        for column in columns:
            count = self._index.count(column.topic)
            if count * column.codec.size > room:
                raise ValueError(f"{column.topic}: {count} messages, more than its chunks have room for")
            column.allocate(count)
        for pieces in self._runs_by_chunk(columns):
            for column, found in zip(columns, pieces, strict=True):
                column.add(found)

    def read_by_chunk(self, columns: Sequence[Columns]) -> Iterator[None]:
        """Fill the columns, in new arrays, with the messages of one chunk after another."""
        for pieces in self._runs_by_chunk(columns):
            for column, found in zip(columns, pieces, strict=True):
                column.allocate(sum(len(run.time_ns) for run in found))
                column.add(found)
            yield

    def _runs_by_chunk(self, columns: Sequence[Columns]) -> Iterator[list[list[Run]]]:
        """Messages of each column's topic."""
        channels = [self._index.channel_id(column.topic) for column in columns]
        present = [channel for channel in channels if channel is not None]
        read, last_ns = [0] * len(columns), [0] * len(columns)
        for chunk in load_chunks(self._file, self._chunks, present):
            pieces = []
            for i, (column, channel) in enumerate(zip(columns, channels, strict=True)):
                found: list[Run] = []
                if channel is not None and channel in chunk.entries:
                    found = list(runs(chunk, channel, column.codec.size))
                for time_ns in (run.time_ns for run in found):
                    if time_ns[0] < last_ns[i] or (np.diff(time_ns) < 0).any():
                        raise ValueError(f"{column.topic}: messages are not in order of time")
                    read[i], last_ns[i] = read[i] + len(time_ns), int(time_ns[-1])
                pieces.append(found)
            yield pieces
        for column, count in zip(columns, read, strict=True):
            if count != self._index.count(column.topic):
                raise ValueError(f"{column.topic}: {count} messages, expected {self._index.count(column.topic)}")
