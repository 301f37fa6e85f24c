"""The topics of a finished recording: how the file numbers them, and how many messages each has."""

from __future__ import annotations

from pathlib import Path

from mcap.records import Statistics
from mcap.summary import Summary

from haul_ros.errors import RecordingError
from haul_ros.messages.channels import ChannelTable
from haul_ros.recording.info import TopicInfo


class TopicIndex:
    """Topics by full name. One that is known but not in the file, as an older version wrote it, has no messages.

    Every method raises RecordingError for a topic that is neither.
    """

    def __init__(self, path: Path, summary: Summary, statistics: Statistics, known: ChannelTable) -> None:
        self._path = path
        self._ids = {channel.topic: key for key, channel in summary.channels.items()}
        self._msgtypes = {channel.topic: channel.msgtype for channel in known}
        self._msgtypes |= {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()}
        self._counts = statistics.channel_message_counts

    def channel_id(self, topic: str) -> int | None:
        """Its number in the file; None: it is known but not there."""
        if topic not in self._msgtypes:
            raise RecordingError(f"{self._path}: no topic {topic}; it has {', '.join(sorted(self._ids))}")
        return self._ids.get(topic)

    def msgtype(self, topic: str) -> str:
        """Its message type."""
        self.channel_id(topic)
        return self._msgtypes[topic]

    def count(self, topic: str) -> int:
        """How many messages it has."""
        channel = self.channel_id(topic)
        return 0 if channel is None else self._counts.get(channel, 0)

    def infos(self) -> tuple[TopicInfo, ...]:
        """Those in the file, sorted by name."""
        return tuple(TopicInfo(topic, self._msgtypes[topic], self.count(topic)) for topic in sorted(self._ids))
