"""Messages of some channels one by one, in order of time, in bounded memory."""

from __future__ import annotations

import heapq
import os
import struct
from collections.abc import Collection, Iterator, Sequence
from io import BytesIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, Message, Schema
from mcap.stream_reader import get_chunk_data_stream

MOST_IN_CHUNK = 200_000
"""Records of one chunk; the smallest messages fill the chunks of this package, 1 MiB, with 30 000."""
MOST_WAITING = 500_000
"""Messages in memory at a time, of chunks that overlap in time; those of this package do not."""
MOST_BYTES_WAITING = 256 * 1024 * 1024
"""Bytes of their data."""

_RECORD_HEAD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")


def chunk_data(chunk: Chunk) -> bytes:
    """The records of a chunk, decompressed; ValueError or an McapError if it is damaged."""
    data, length = get_chunk_data_stream(chunk, validate_crc=True)
    return data.read(length)


def chunk_records(data: bytes) -> Iterator[Schema | Channel | Message]:
    """Schemas, channels and messages in the records of a chunk.

    Raises
    ------
    ValueError
        There are more than `MOST_IN_CHUNK` records, or one that is longer than the chunk.
    """
    place = count = 0
    while place < len(data):
        if place + _RECORD_HEAD.size > len(data):
            raise ValueError("chunk ends within a record")
        opcode, length = _RECORD_HEAD.unpack_from(data, place)
        begin, place = place + _RECORD_HEAD.size, place + _RECORD_HEAD.size + length
        count += 1
        if count > MOST_IN_CHUNK:
            raise ValueError(f"more than {MOST_IN_CHUNK} records in a chunk")
        if place > len(data):
            raise ValueError("chunk ends within a record")
        if opcode == Opcode.MESSAGE:
            if length < _MESSAGE_HEAD.size:
                raise ValueError("message without its head")
            channel, sequence, log_time, publish_time = _MESSAGE_HEAD.unpack_from(data, begin)
            yield Message(
                channel_id=channel,
                log_time=log_time,
                data=data[begin + _MESSAGE_HEAD.size : place],
                publish_time=publish_time,
                sequence=sequence,
            )
        elif opcode == Opcode.CHANNEL:
            yield Channel.read(ReadDataStream(BytesIO(data[begin:place])))
        elif opcode == Opcode.SCHEMA:
            yield Schema.read(ReadDataStream(BytesIO(data[begin:place])))


def read_chunk(file: int, index: ChunkIndex) -> Chunk:
    """The chunk of an open file to which an index points."""
    record = os.pread(file, index.chunk_length, index.chunk_start_offset)
    if len(record) != index.chunk_length or record[0] != Opcode.CHUNK:
        raise ValueError("chunk index does not point to a chunk")
    chunk: Chunk = Chunk.read(ReadDataStream(BytesIO(record[_RECORD_HEAD.size :])))
    return chunk


def ordered_messages(
    file: int, indexes: Sequence[ChunkIndex], channels: Collection[int], *, reverse: bool = False
) -> Iterator[Message]:
    """Messages of these channels in order of log time, at one time in the order of the file; or all of it reversed.

    Raises
    ------
    ValueError
        A chunk is damaged, or too many messages overlap.
    """
    sign = -1 if reverse else 1
    waiting: list[tuple[int, int, int, ChunkIndex | Message]] = []
    for index in indexes:
        if not index.message_index_offsets or not index.message_index_offsets.keys().isdisjoint(channels):
            time = index.message_end_time if reverse else index.message_start_time
            waiting.append((sign * time, sign * index.chunk_start_offset, -MOST_IN_CHUNK, index))
    heapq.heapify(waiting)
    size = 0
    while waiting:
        _, offset, _, item = heapq.heappop(waiting)
        if isinstance(item, Message):
            size -= len(item.data)
            yield item
            continue
        for number, record in enumerate(chunk_records(chunk_data(read_chunk(file, item)))):
            if isinstance(record, Message) and record.channel_id in channels:
                size += len(record.data)
                if size > MOST_BYTES_WAITING or len(waiting) >= MOST_WAITING + len(indexes):
                    raise ValueError("too many messages of chunks that overlap in time")
                heapq.heappush(waiting, (sign * record.log_time, offset, sign * number, record))
