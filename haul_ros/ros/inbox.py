"""Requests on their way to the simulation: emergencies first, and no more of anything than can matter."""

from __future__ import annotations

import threading
from collections.abc import Hashable
from concurrent.futures import Future
from typing import NamedTuple

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.fault import Fault
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import Request

REPLACED = "replaced by a newer one before it took effect"


class Waiting(NamedTuple):
    """A request, and what becomes of it."""

    request: Request
    result: Future[str]


class Inbox:
    """Takes requests from any thread; `take` hands them out to one.

    Of requests that set the same (a demand of one kind at one locomotive, a field of a link, a fault at one place),
    one is handed out within ``hold_ns`` [ns] or until `next_period`; of those that come meanwhile, the newest counts.
    An emergency is never replaced by its end.
    """

    def __init__(self, hold_ns: int) -> None:
        self._hold_ns = hold_ns
        self._lock = threading.Lock()
        self._waiting: dict[Hashable, Waiting] = {}
        self._handed_out: dict[Hashable, int] = {}
        self._announced = False
        self._replaced = self._refused = 0

    @property
    def replaced(self) -> int:
        """Requests that were replaced by newer ones, since the start."""
        return self._replaced

    @property
    def refused(self) -> int:
        """Requests that mean nothing, since the start: none of them replaces one that does."""
        return self._refused

    def put(self, request: Request) -> tuple[Future[str], bool]:
        """Add a request; what becomes of it, and whether `take` is to be called for it.

        Raises
        ------
        CommandError
            The request means nothing.
        """
        if not isinstance(request, RadioLinkChange):
            self._check(request)
        key, result = _what_it_sets(request), Future[str]()
        with self._lock:
            before = self._waiting.pop(key, None)
            self._waiting[key] = Waiting(request, result)
            self._replaced += before is not None
            announce, self._announced = not self._announced, True
        if before is not None:
            before.result.set_result(REPLACED)
        return result, announce

    def _check(self, request: Command | Fault) -> None:
        try:
            request.check()
        except CommandError:
            with self._lock:
                self._refused += 1
            raise

    def next_period(self) -> None:
        """A sample period is over: everything may be handed out again."""
        with self._lock:
            self._handed_out.clear()

    def due_ns(self, now_ns: int) -> int | None:
        """When something that waits may be handed out; None: nothing waits."""
        with self._lock:
            if not self._waiting:
                return None
            return min(self._free_at(key, now_ns) for key in self._waiting)

    def take(self, now_ns: int) -> list[Waiting]:
        """What may be handed out now, emergencies first, the others in their order."""
        with self._lock:
            self._announced = False
            ready = [key for key in self._waiting if self._free_at(key, now_ns) <= now_ns]
            self._handed_out |= dict.fromkeys(ready, now_ns)
            found = [self._waiting.pop(key) for key in ready]
        return sorted(found, key=lambda waiting: not _starts_emergency(waiting.request))

    def take_all(self) -> list[Waiting]:
        """Everything, at the end."""
        with self._lock:
            found = list(self._waiting.values())
            self._waiting.clear()
        return found

    def _free_at(self, key: Hashable, now_ns: int) -> int:
        return self._handed_out.get(key, now_ns - self._hold_ns) + self._hold_ns


def _starts_emergency(request: Request) -> bool:
    return isinstance(request, Command) and request.kind is CommandKind.EMERGENCY and request.value != 0.0


def _what_it_sets(request: Request) -> Hashable:
    if isinstance(request, Command):
        return request.locomotive, request.kind, _starts_emergency(request)
    if isinstance(request, Fault):
        return request.kind, request.number
    return request.slave, frozenset(request.values())
