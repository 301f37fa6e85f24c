"""What happens to a train that is worth a line in its log."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class EventKind(enum.Enum):
    """What an event is about."""

    EMERGENCY = "emergency"
    WAVE = "brake_wave"
    BOTTOMED = "bottomed"
    SLACK = "slack"
    STOPPED = "stopped"
    RADIO = "radio"
    VALVE = "valve"
    APPLICATION = "application"
    OVERSPEED = "overspeed"
    FAULT = "fault"
    SEPARATION = "separation"


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened at a simulation time [ns], in words: where first, then what."""

    time_ns: int
    kind: EventKind
    text: str
