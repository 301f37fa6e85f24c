"""Bytes of a recording, and all that a reader gives of it."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

from mcap.writer import MCAP0_MAGIC

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
