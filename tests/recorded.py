"""Bytes of a recording, and all that a reader gives of it."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import Message
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from haul_ros.recording.integrity import CHECKSUM, checksum_of
from haul_ros.recording.reader import Recording

_FOOTER = 29


def summary_section(data: bytes | bytearray) -> tuple[int, int]:
    """Where the summary section of a file begins, and where its footer stands."""
    footer = len(data) - len(MCAP0_MAGIC) - _FOOTER
    return struct.unpack_from("<Q", data, footer + 9)[0], footer


def sign_summary(data: bytearray) -> None:
    """Write the checksum that fits the summary section."""
    begin, footer = summary_section(data)
    struct.pack_into("<I", data, footer + 25, zlib.crc32(data[begin : footer + 25]))


def content(path: Path) -> list[object]:
    """All that a reader gives of a recording."""
    with Recording(path) as recording:
        info, samples = recording.info(), recording.samples()
        return [
            recording.scenario_document,
            recording.metadata,
            info.topics,
            (info.messages, info.start_ns, info.end_ns, info.dropped, info.written),
            recording.requests(),
            recording.events(),
            [(m.channel.topic, m.time_ns, m.data) for m in recording.state_messages()],
            [(series.time_ns.tobytes(), series.names) for series in samples],
            (samples.couplers.force.tobytes(), samples.pressure.pressure.tobytes()),
            [found.extremes.tension.tobytes() for found in recording.extremes()],
        ]


def forge(
    source: Path,
    target: Path,
    *,
    messages: Callable[[list[tuple[str, Message]]], Iterable[tuple[str, Message]]] = lambda found: found,
    description: Callable[[dict[str, str]], dict[str, str]] = lambda found: found,
    scenario: Callable[[bytes], bytes] = lambda found: found,
    topic: Callable[[str], str] = lambda found: found,
    compression: CompressionType = CompressionType.NONE,
    chunk_size: int = 2**20,
    data_checksum: bool = False,
) -> None:
    """Write a recording again, changed but with checksums that fit."""
    with source.open("rb") as stream, target.open("wb") as new:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        writer = Writer(new, chunk_size, compression, enable_data_crcs=data_checksum)
        writer.start("ros2", "somebody else")
        records = [dict(found.metadata) for found in reader.iter_metadata() if found.name == "haul_ros"]
        changed = [description({key: value for key, value in found.items() if key != CHECKSUM}) for found in records]
        signed = [found | {CHECKSUM: checksum_of(found)} for found in changed]
        writer.add_metadata("haul_ros", signed[0])
        for found in reader.iter_attachments():
            data = scenario(found.data)
            writer.add_attachment(found.create_time, found.log_time, found.name, found.media_type, data)
        ids: dict[str, int] = {}
        for channel in summary.channels.values():
            schema = summary.schemas[channel.schema_id]
            number = writer.register_schema(schema.name, schema.encoding, schema.data)
            ids[channel.topic] = writer.register_channel(topic(channel.topic), "cdr", number, channel.metadata)
        kept = [(channel.topic, message) for _, channel, message in reader.iter_messages()]
        for name, message in messages(kept):
            writer.add_message(ids[name], message.log_time, message.data, message.publish_time, message.sequence)
        writer.add_metadata("haul_ros", signed[-1])
        writer.finish()
