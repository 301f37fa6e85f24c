"""Messages of one channel from the chunks of a file, many at once, without looking at them one by one.

The format: https://mcap.dev/spec, records Chunk, Message and MessageIndex.
"""

from __future__ import annotations

import os
import struct
from collections import deque
from collections.abc import Collection, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.records import ChunkIndex
from numpy.typing import NDArray

from haul_ros.recording.ordered import chunk_data, read_chunk

_HEAD = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)
"""What stands before the bytes of a message."""
MESSAGE_HEAD = _HEAD.itemsize
"""Bytes of a message record without data."""
_RECORD_HEAD = 9
"""Bytes of opcode and length before any record."""
_COUNTED_IN_LENGTH = _HEAD.itemsize - _RECORD_HEAD
"""Part of the head that the length of the record counts: all behind opcode and length."""

_ENTRY = np.dtype([("log_time", "<u8"), ("offset", "<u8")])
_INDEX_HEAD = struct.Struct("<BQHI")
"""Opcode and length of a message index, channel, bytes of its entries."""

_LOADERS = 2
"""Threads that decompress, and chunks that wait in memory; more are of no use to the one that puts them together."""


class Run(NamedTuple):
    """Messages of one size at equal distances: log times (n,) [ns] and bytes (n, size), a view of the chunk."""

    time_ns: NDArray[np.int64]
    messages: NDArray[np.uint8]


class LoadedChunk(NamedTuple):
    """Records of a chunk, decompressed, and the entries of some channels in its index, by channel."""

    data: bytes
    entries: dict[int, NDArray[Any]]


def load_chunks(file: int, indexes: Iterable[ChunkIndex], channels: Collection[int]) -> Iterator[LoadedChunk]:
    """Chunks of an open file descriptor that hold any of the channels, read and decompressed ahead by other threads.

    Raises
    ------
    ValueError
        An index that does not point to a chunk, or a chunk that has another checksum.
    """
    with ThreadPoolExecutor(_LOADERS) as pool:
        ahead: deque[Future[LoadedChunk]] = deque()
        for index in indexes:
            if wanted := [channel for channel in channels if channel in index.message_index_offsets]:
                ahead.append(pool.submit(_load, file, index, wanted))
            if len(ahead) > _LOADERS:
                yield ahead.popleft().result()
        while ahead:
            yield ahead.popleft().result()


def _load(file: int, index: ChunkIndex, channels: Iterable[int]) -> LoadedChunk:
    data = chunk_data(read_chunk(file, index))
    return LoadedChunk(data, {channel: _entries(file, index, channel) for channel in channels})


def _entries(file: int, index: ChunkIndex, channel: int) -> NDArray[Any]:
    start = index.message_index_offsets[channel]
    opcode, _, found, length = _INDEX_HEAD.unpack(os.pread(file, _INDEX_HEAD.size, start))
    if (opcode, found) != (Opcode.MESSAGE_INDEX, channel) or length > index.message_index_length:
        raise ValueError("chunk index does not point to a message index")
    return np.frombuffer(os.pread(file, length, start + _INDEX_HEAD.size), _ENTRY)


def runs(chunk: LoadedChunk, channel: int, size: int) -> Iterator[Run]:
    """All messages of a channel in a chunk, each of ``size`` bytes, in the order of the file.

    Raises
    ------
    ValueError
        A message of another size, or an index that does not fit the chunk.
    """
    entries, data = chunk.entries[channel], np.frombuffer(chunk.data, np.uint8)
    offsets = entries["offset"].astype(np.int64)
    if len(offsets) and not 0 <= offsets.min() <= offsets.max() <= len(data) - _HEAD.itemsize:
        raise ValueError("message index points outside of its chunk")
    heads: NDArray[Any] = data[offsets[:, None] + np.arange(_HEAD.itemsize)].view(_HEAD)[:, 0]
    fits = (heads["opcode"] == Opcode.MESSAGE) & (heads["channel"] == channel)
    if not (fits & (heads["log_time"] == entries["log_time"])).all():
        raise ValueError("message index does not fit its chunk")
    for length in heads["length"][heads["length"] != size + _COUNTED_IN_LENGTH]:
        found = int(length) - _COUNTED_IN_LENGTH
        raise ValueError(f"message of {found} bytes has not the expected layout of {size} bytes")
    time_ns = entries["log_time"].astype(np.int64)
    distances = np.diff(offsets)
    for run in np.split(np.arange(len(offsets)), np.flatnonzero(np.diff(distances)) + 2):
        if len(run):
            strides = (int(distances[run[0]]) if len(run) > 1 else size, 1)
            start = int(offsets[run[0]]) + _HEAD.itemsize
            yield Run(time_ns[run], np.ndarray((len(run), size), np.uint8, data, start, strides))
