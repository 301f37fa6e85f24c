"""The signals that ask a process to end, handled together."""

from __future__ import annotations

import signal
from collections.abc import Callable

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
