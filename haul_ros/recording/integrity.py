"""Whether a recording is what was written, before anything of it is believed: checksums, places and sizes.

The format: https://mcap.dev/spec. The seeking reader of the mcap library checks the checksums of chunks, and no other.
"""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections.abc import Mapping, Sequence
from io import BytesIO

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, AttachmentIndex, Chunk, ChunkIndex, Metadata, MetadataIndex
from mcap.writer import MCAP0_MAGIC

LARGEST_CHUNK = 64 * 1024 * 1024
"""Bytes of memory for one chunk; those of this package have little more than 1 MiB, those of others 4 MiB."""
LARGEST_RECORD = 16 * 1024 * 1024
"""Bytes of memory for one attachment or description of a run."""
CHECKSUM = "crc32"
"""Entry of the description of a run: checksum of the others."""
WRITTEN = "messages_written"
"""Entry of the description at the end: how many messages the recorder wrote."""
DROPPED = "messages_dropped"
"""Entry of the description at the end: how many messages it could not write."""

_FOOTER = struct.Struct("<BQQQI")
_CHUNK_HEAD = struct.Struct("<BQQQQII")
_DATA_END = struct.Struct("<BQI")
_RECORD_HEAD = struct.Struct("<BQ")
_PIECE = 1024 * 1024
_MOST_EXPANSION_OF_LZ4 = 255
_MOST_DIGITS = 18


def checksum_of(description: Mapping[str, str]) -> str:
    """Checksum of a description of a run without its own."""
    entries = sorted((key, value) for key, value in description.items() if key != CHECKSUM)
    return f"{zlib.crc32(json.dumps(entries).encode()):08x}"


def checked_description(metadata: Mapping[str, str]) -> dict[str, str]:
    """A description of a run as read, without its checksum, which older versions did not write.

    Raises
    ------
    ValueError
        It has another checksum.
    """
    if metadata.get(CHECKSUM, checksum_of(metadata)) != checksum_of(metadata):
        raise ValueError("description of the run: checksum does not fit")
    return {key: value for key, value in metadata.items() if key != CHECKSUM}


def message_count(description: Mapping[str, str], key: str) -> int | None:
    """A number of messages in the description of a run; None: it says nothing of it.

    Raises
    ------
    ValueError
        It is no such number.
    """
    text = description.get(key)
    if text is None:
        return None
    if not (text.isascii() and text.isdecimal() and len(text) <= _MOST_DIGITS):
        raise ValueError(f"description of the run: {key} is {text[:30]!r}, expected a number of messages")
    return int(text)


def check_summary(file: int, size: int) -> None:
    """Compare the checksum of the summary section of an open file of this size, if there is one.

    Raises
    ------
    ValueError
        It does not fit, or there is no footer.
    """
    start, end, expected = _summary_section(file, size)
    if expected not in (0, _checksum(file, start, end)):
        raise ValueError("summary section: checksum does not fit")


def _summary_section(file: int, size: int) -> tuple[int, int, int]:
    """Where it begins, where what its checksum covers ends, and that checksum."""
    place = size - len(MCAP0_MAGIC) - _FOOTER.size
    if place < len(MCAP0_MAGIC):
        raise ValueError("no room for a footer")
    opcode, length, start, _, expected = _FOOTER.unpack(os.pread(file, _FOOTER.size, place))
    if opcode != Opcode.FOOTER or length != _FOOTER.size - _RECORD_HEAD.size:
        raise ValueError("no footer at its end")
    if not len(MCAP0_MAGIC) <= (start or place) <= place:
        raise ValueError("footer does not point to a summary section")
    return start or place, place + _FOOTER.size - 4, expected


def _checksum(file: int, start: int, end: int) -> int:
    found = 0
    for begin in range(start, end, _PIECE):
        found = zlib.crc32(os.pread(file, min(_PIECE, end - begin), begin), found)
    return found


def check_data(file: int, size: int) -> None:
    """Compare the checksum of the data section of an open file of this size, if it has one: recorders of others do.

    Raises
    ------
    ValueError
        It does not fit, or the data section has no end.
    """
    start, _, _ = _summary_section(file, size)
    place = start - _DATA_END.size
    opcode, length, expected = _DATA_END.unpack(os.pread(file, _DATA_END.size, place) if place > 0 else bytes(13))
    if opcode != Opcode.DATA_END or length != _DATA_END.size - _RECORD_HEAD.size:
        raise ValueError("data section: does not end before the summary section")
    check_data_checksum(file, place, expected)


def check_data_checksum(file: int, end: int, expected: int) -> None:
    """Compare the checksum of all before the end of the data section; 0 stands for none.

    Raises
    ------
    ValueError
        It does not fit.
    """
    if expected and expected != _checksum(file, 0, end):
        raise ValueError("data section: checksum does not fit")


def check_chunks(file: int, size: int, indexes: Sequence[ChunkIndex]) -> None:
    """See that chunks lie where and are as large as the index says, one behind the other, and fit into memory.

    Raises
    ------
    ValueError
        They do not.
    """
    end = 0
    for index in sorted(indexes, key=lambda index: index.chunk_start_offset):
        begin, end_before = index.chunk_start_offset, end
        end = begin + index.chunk_length
        if begin < end_before or end + index.message_index_length > size:
            raise ValueError("chunk index points outside of the file, or chunks overlap")
        head = os.pread(file, _CHUNK_HEAD.size + 64, begin)
        opcode, length, _, _, uncompressed, _, name = _CHUNK_HEAD.unpack_from(head)
        if opcode != Opcode.CHUNK or length + _RECORD_HEAD.size != index.chunk_length or name > 32:
            raise ValueError("chunk index does not point to a chunk")
        compression = head[_CHUNK_HEAD.size :][:name].decode()
        if (compression, uncompressed) != (index.compression, index.uncompressed_size):
            raise ValueError("chunk index does not fit its chunk")
        compressed = length - (_CHUNK_HEAD.size - _RECORD_HEAD.size) - name - 8
        _check_size(compression, head[_CHUNK_HEAD.size + name + 8 :], compressed, uncompressed)


def _check_size(compression: str, beginning: bytes, compressed: int, uncompressed: int) -> None:
    """Refuse compressed data whose own head asks for other memory than the record says, or for too much."""
    stated = -1
    if compression == "zstd":
        stated = zstandard.frame_content_size(beginning)
    elif compression == "lz4":
        stated = lz4.frame.get_frame_info(beginning)["content_size"] or -1
        if stated < 0 and compressed * _MOST_EXPANSION_OF_LZ4 > 8 * LARGEST_CHUNK:
            raise ValueError("chunk of lz4 without its size, too large to be read safely")
    elif uncompressed != compressed:
        raise ValueError("chunk has another size than it says")
    if uncompressed > LARGEST_CHUNK:
        raise ValueError(f"chunk of {uncompressed} bytes, expected at most {LARGEST_CHUNK}")
    if stated not in (-1, uncompressed):
        raise ValueError("chunk has another size than it says")


def check_chunk(chunk: Chunk) -> None:
    """See that a chunk, as read from its record, can be decompressed in the memory that it may take.

    Raises
    ------
    ValueError
        It asks for more, or for other memory than it says.
    """
    _check_size(chunk.compression, chunk.data[:64], len(chunk.data), chunk.uncompressed_size)


def descriptions(file: int, indexes: Sequence[MetadataIndex], name: str) -> list[dict[str, str]]:
    """The metadata records of this name, whose checksums fit, in the order of the file.

    Raises
    ------
    ValueError
        An index that does not point to such a record, or a checksum that does not fit or is missing in some.
    """
    found = [dict(_metadata(file, index).metadata) for index in indexes if index.name == name]
    if len({CHECKSUM in metadata for metadata in found}) > 1:
        raise ValueError("description of the run: a checksum is missing")
    return [checked_description(metadata) for metadata in found]


def _metadata(file: int, index: MetadataIndex) -> Metadata:
    body = _record(file, index, Opcode.METADATA, f"metadata {index.name}")
    metadata: Metadata = Metadata.read(ReadDataStream(BytesIO(body)))
    if metadata.name != index.name:
        raise ValueError(f"metadata {index.name}: is called {metadata.name}")
    return metadata


def attachment(file: int, index: AttachmentIndex) -> bytes:
    """Content of an attachment whose checksum fits.

    Raises
    ------
    ValueError
        It does not, or the index does not point to an attachment of its size.
    """
    body = _record(file, index, Opcode.ATTACHMENT, f"attachment {index.name}")
    stream = BytesIO(body)
    data: bytes = Attachment.read(ReadDataStream(stream)).data
    if stream.read():
        raise ValueError(f"attachment {index.name}: has another size than it says")
    if int.from_bytes(body[-4:], "little") not in (0, zlib.crc32(body[:-4])):
        raise ValueError(f"attachment {index.name}: checksum does not fit")
    return data


def _record(file: int, index: AttachmentIndex | MetadataIndex, opcode: Opcode, name: str) -> bytes:
    """The content of a record, ``name`` in messages, which lies where and is as long as the index says."""
    if not _RECORD_HEAD.size < index.length <= LARGEST_RECORD:
        raise ValueError(f"{name} of {index.length} bytes, expected at most {LARGEST_RECORD}")
    record = os.pread(file, index.length, index.offset)
    if len(record) != index.length or _RECORD_HEAD.unpack_from(record) != (opcode, index.length - _RECORD_HEAD.size):
        raise ValueError(f"{name}: its index does not point to it")
    return record[_RECORD_HEAD.size :]
