"""Ctrl-C as a wish to end well."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event


@contextmanager
def interruption() -> Iterator[Callable[[], bool]]:
    """Inside the block the first SIGINT only makes the given function true; a second one interrupts as ever.

    For the main thread.
    """
    asked = Event()

    def note(_signal: int, _frame: object) -> None:
        asked.set()
        signal.signal(signal.SIGINT, previous)

    previous = signal.signal(signal.SIGINT, note)
    try:
        yield asked.is_set
    finally:
        signal.signal(signal.SIGINT, previous)
