"""Recordings of a train's topics by other programs, such as ``ros2 bag record``: what they hold."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from mcap.reader import SeekingReader
from mcap.writer import MCAP0_MAGIC

from haul_ros.errors import RecordingError
from haul_ros.messages.channels import JOINT_STATE
from haul_ros.recording.info import TopicInfo
from haul_ros.recording.integrity import check_chunks, check_data, check_summary
from haul_ros.recording.opening import open_existing, open_finished, reading
from haul_ros.recording.run_file import RECORD_NAME
from haul_ros.units import NS_PER_S

_OWN_LIBRARY = "haul_ros "
_COUPLERS = "/couplers"
_LONGEST_HEADER = 256
"""Bytes from the start of a file in which its header names its library."""


@dataclass(frozen=True, slots=True)
class ForeignRecording:
    """An MCAP file by the program that calls itself ``library``; times are those of its clock [ns]."""

    path: Path
    size: int
    library: str
    topics: tuple[TopicInfo, ...]
    messages: int
    start_ns: int
    end_ns: int

    @property
    def duration(self) -> float:
        """From the first to the last message [s]."""
        return (self.end_ns - self.start_ns) / NS_PER_S


def is_own(path: Path) -> bool:
    """Whether a file is a finished recording of haul_ros, as far as its ends tell, one that tools have rewritten too.

    Raises
    ------
    RecordingError
        There is no such file.
    """
    with open_existing(path) as stream, reading(path):
        head = stream.read(_LONGEST_HEADER)
        stream.seek(max(0, os.fstat(stream.fileno()).st_size - len(MCAP0_MAGIC)))
        finished = head.startswith(MCAP0_MAGIC) and stream.read() == MCAP0_MAGIC
    return finished and (_OWN_LIBRARY.encode() in head or _describes_a_run(path))


def _describes_a_run(path: Path) -> bool:
    """Whether a finished file has the record in which haul_ros describes a run; False of what cannot be read."""
    try:
        with open_finished(path) as stream, reading(path):
            size = os.fstat(stream.fileno()).st_size
            check_summary(stream.fileno(), size)
            summary = SeekingReader(stream, record_size_limit=size).get_summary()
    except RecordingError:
        return False
    return summary is not None and any(index.name == RECORD_NAME for index in summary.metadata_indexes)


def foreign_recording(path: Path) -> ForeignRecording | None:
    """The facts about a recording by another program that has the couplers of a train; None: it is no such file.

    Raises
    ------
    RecordingError
        It cannot be read, is unfinished, damaged or no MCAP file.
    """
    with open_finished(path) as stream, reading(path):
        size = os.fstat(stream.fileno()).st_size
        check_summary(stream.fileno(), size)
        check_data(stream.fileno(), size)
        reader = SeekingReader(stream, validate_crcs=True, record_size_limit=size)
        library, summary = reader.get_header().library, reader.get_summary()
        if summary is None or summary.statistics is None or library.startswith(_OWN_LIBRARY):
            return None
        check_chunks(stream.fileno(), size, summary.chunk_indexes)
        counts, statistics = summary.statistics.channel_message_counts, summary.statistics
        topics = [
            TopicInfo(channel.topic, summary.schemas[channel.schema_id].name, counts.get(channel.id, 0))
            for channel in summary.channels.values()
            if channel.schema_id in summary.schemas
        ]
        has_train = any(topic.msgtype == JOINT_STATE and topic.topic.endswith(_COUPLERS) for topic in topics)
        if not has_train or any(index.name == RECORD_NAME for index in summary.metadata_indexes):
            return None
        return ForeignRecording(
            path=path,
            size=size,
            library=library,
            topics=tuple(sorted(topics, key=lambda topic: topic.topic)),
            messages=statistics.message_count,
            start_ns=statistics.message_start_time,
            end_ns=statistics.message_end_time,
        )
