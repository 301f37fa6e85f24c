"""Logs of runs, by kind of entry."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from haul_ros.model.command import Command
from haul_ros.model.log import PeriodLog
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import Sample

Entry = TypeVar("Entry")


def of_kind(kind: type[Entry], *logs: PeriodLog) -> list[Entry]:
    """All entries of a kind, in order."""
    return [entry for log in logs for entry in log.entries if isinstance(entry, kind)]


def commands(*logs: PeriodLog) -> list[tuple[int, Command]]:
    """All commands with their times [ns]."""
    timed = of_kind(TimedRequest, *logs)
    return [(entry.time_ns, entry.request) for entry in timed if isinstance(entry.request, Command)]


def samples(logs: Iterable[PeriodLog]) -> list[Sample]:
    """All samples."""
    return [log.sample for log in logs if log.sample is not None]
