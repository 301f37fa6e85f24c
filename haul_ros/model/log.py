"""The log of a run: what was asked, what was applied and what happened, in order, period by period."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from haul_ros.model.event import Event
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.sensor import CouplerMeasurement


@dataclass(frozen=True, slots=True)
class AppliedBrake:
    """A locomotive's brake changed: ``value`` 0..1 of full service, 1 in emergency."""

    time_ns: int
    locomotive: str
    value: float


@dataclass(frozen=True, slots=True)
class Effort:
    """What a locomotive pulls or brakes electrically with has changed: ``value`` [N], forward positive."""

    time_ns: int
    locomotive: str
    value: float


@dataclass(frozen=True, slots=True)
class RadioSeen:
    """What the ends of a radio link make of it has changed: whether the slave hears the master (``heard``), or whether
    the newest telegram has not been given up by the master for want of an acknowledgement (``acknowledged``)."""

    time_ns: int
    slave: str
    what: Literal["heard", "acknowledged"]
    value: bool


LogEntry = TimedRequest | AppliedBrake | Effort | RadioSeen | Event


@dataclass(frozen=True, slots=True, eq=False)
class PeriodLog:
    """What is new in a run up to ``time_ns``.

    ``entries`` are in order of time, at one time as they occurred: a request before its effects. ``sample`` is the
    state at ``time_ns``, None if the log before had reached that instant already; ``extremes`` are those since the
    start of the run, None where they are not due; so is ``measurement``, what sensors make of the sample.
    """

    time_ns: int
    entries: tuple[LogEntry, ...]
    sample: Sample | None = None
    extremes: CouplerExtremes | None = None
    measurement: CouplerMeasurement | None = None
