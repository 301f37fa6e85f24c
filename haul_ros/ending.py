"""The signals that ask a process to end, handled together."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import NoReturn

_AGAIN = 0.05
"""Wall time [s] after which a lost KeyboardInterrupt arises once more."""
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class EndingHandler:
    """Lets SIGINT, SIGTERM and SIGHUP call ``handle`` with their number, until `restore`; for the main thread.

    One that is ignored, as SIGHUP is under nohup, stays so.
    """

    def __init__(self, handle: Callable[[int], None]) -> None:
        self._previous = {
            number: signal.signal(number, lambda number, _frame: handle(number))
            for number in _SIGNALS
            if signal.getsignal(number) is not signal.SIG_IGN
        }

    def restore(self) -> None:
        """Give the signals back to who had them."""
        for number, handler in self._previous.items():
            signal.signal(number, handler)


@contextmanager
def no_interrupt_lost() -> Iterator[None]:
    """Inside the block a KeyboardInterrupt that cannot get out of where it arises does so again a little later.

    One that meets a callback of compiled code, as those of the compiler are, or compiled code that prints what it
    cannot use, as that of message types does, is only printed, as if nobody had asked for the end. For the main
    thread; takes SIGALRM.
    """
    unraisable, uncaught = sys.unraisablehook, sys.excepthook
    handler = signal.signal(signal.SIGALRM, _interrupt)

    def note_unraisable(lost: sys.UnraisableHookArgs) -> None:
        if issubclass(lost.exc_type, KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, _AGAIN)
        else:
            unraisable(lost)

    def note_printed(kind: type[BaseException], error: BaseException, traceback: TracebackType | None) -> None:
        if issubclass(kind, KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, _AGAIN)
        else:
            uncaught(kind, error, traceback)

    sys.unraisablehook, sys.excepthook = note_unraisable, note_printed
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        sys.unraisablehook, sys.excepthook = unraisable, uncaught
        signal.signal(signal.SIGALRM, handler)


def _interrupt(*_: object) -> NoReturn:
    raise KeyboardInterrupt
