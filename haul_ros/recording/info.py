"""Facts about a recording."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from haul_ros.model.recording_plan import RecordingPlan
from haul_ros.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class TopicInfo:
    """A topic of a recording and how many messages it has."""

    topic: str
    msgtype: str
    count: int


@dataclass(frozen=True, slots=True)
class RecordingInfo:
    """What is in a recording. Times are simulation times; without messages both are 0.

    ``compression`` is that of the chunks; ``dropped`` is how many messages the recorder could not write
    (None: not known, it did not end), ``written`` how many it wrote (None: an older version); ``topics`` are sorted by
    name. Samples were recorded at ``record_rate`` [Hz] (None: all that were published), as ``plan`` says;
    the couplers ``measured`` have sensors.
    """

    path: Path
    size: int
    version: str
    scenario: str
    description: str
    time_step: float
    vehicles: int
    couplers: int
    locomotives: tuple[str, ...]
    compression: str
    topics: tuple[TopicInfo, ...]
    messages: int
    start_ns: int
    end_ns: int
    dropped: int | None
    written: int | None
    record_rate: float | None = None
    plan: RecordingPlan = field(default_factory=RecordingPlan)
    measured: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """From the first to the last message [s]."""
        return (self.end_ns - self.start_ns) / NS_PER_S

    @property
    def lost(self) -> int:
        """How many messages the recorder wrote that the file no longer has."""
        return max(0, (self.written or 0) - self.messages)

    @property
    def complete(self) -> bool:
        """The recorder ended well and dropped nothing, and all that it wrote is there."""
        return self.dropped == 0 and not self.lost
