"""What happened in a run that its numbers do not show: separations, brakes that did what nobody asked of them."""

from __future__ import annotations

from typing import Any

from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import PeriodLog
from haul_ros.units import NS_PER_S

_NAMES = {
    EventKind.SEPARATION: "separation",
    EventKind.VALVE: "control valves",
    EventKind.APPLICATION: "brake application",
}
"""Names of the lines by the kinds of events that are told of, in order."""


class Notices:
    """Counts events of the kinds that a summary tells of, and keeps the first of each."""

    def __init__(self) -> None:
        self._first: dict[EventKind, Event] = {}
        self._count = dict.fromkeys(_NAMES, 0)
        self.unintended_releases = 0
        """How many vehicles have released unasked."""

    def add(self, log: PeriodLog) -> None:
        """Take in what is new."""
        for entry in log.entries:
            if isinstance(entry, Event) and entry.kind in self._count:
                self._count[entry.kind] += 1
                self._first.setdefault(entry.kind, entry)

    def entries(self) -> list[tuple[str, str]]:
        """Names and values of lines of the summary; none of what did not happen."""
        found = []
        for kind, event in self._first.items():
            first = f"at {event.time_ns / NS_PER_S:.3f} s {event.text}"
            more = self._count[kind] - 1
            found.append((_NAMES[kind], f"{first}{f'; and {more} more' if more else ''}"))
        if self.unintended_releases:
            found.append(("released unasked", f"{self.unintended_releases} vehicles"))
        return found

    def json(self) -> dict[str, Any]:
        """The same for programs: how many of each kind, and when the first was."""
        events = {
            kind.value: {
                "count": count,
                "first_time_s": event.time_ns / NS_PER_S if (event := self._first.get(kind)) else None,
                "first": event.text if event else None,
            }
            for kind, count in self._count.items()
        }
        return {"events": events, "unintended_releases": self.unintended_releases}
