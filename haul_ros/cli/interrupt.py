"""Signals that end a run early, but whole."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from haul_ros.ending import EndingHandler


class Interruption:
    """Whether a signal has come, by calling it, and which."""

    def __init__(self) -> None:
        self._signal: int | None = None
        self._handler = EndingHandler(self._note)

    def __call__(self) -> bool:
        """A signal has come."""
        return self._signal is not None

    @property
    def exit_status(self) -> int:
        """As shells count it: 130 after SIGINT, 143 after SIGTERM, 129 after SIGHUP; 0 without any."""
        return 0 if self._signal is None else 128 + self._signal

    def restore(self) -> None:
        """Give the signals back."""
        self._handler.restore()

    def _note(self, number: int) -> None:
        self._signal = number
        self.restore()


@contextmanager
def interruption() -> Iterator[Interruption]:
    """Inside the block the first SIGINT, SIGTERM or SIGHUP is only noted; a second one acts as ever.

    For the main thread.
    """
    noted = Interruption()
    try:
        yield noted
    finally:
        noted.restore()
