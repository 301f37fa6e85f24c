"""What signals do to the process of a node, from its first instant; importable where there is no ROS."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from haul_ros.ending import EndingHandler


class EndingSignals:
    """What SIGINT, SIGTERM and SIGHUP do to a node: interrupt it while it starts, then shut ROS down.

    After ``started`` no KeyboardInterrupt arises, so a second Ctrl-C cannot break into a clean end;
    a spinning executor ends with ExternalShutdownException. To be installed in the main thread, before rclpy is
    imported: it passes a signal on to the handler that it found.
    """

    def __init__(self) -> None:
        self._shut_down: Callable[[], object] | None = None
        self._taken = False
        self._handler = EndingHandler(self._take)

    def started(self, shut_down: Callable[[], object]) -> None:
        """From now on the node ends by the shutdown of ROS alone, which is ``shut_down`` where rclpy sees no signal."""
        self._shut_down = shut_down

    def restore(self) -> None:
        """Give the signals back to who had them."""
        self._handler.restore()

    @property
    def taken(self) -> bool:
        """Whether there was one: a KeyboardInterrupt is lost where it meets code that lets no exception out."""
        return self._taken

    @property
    def interrupted_start(self) -> bool:
        """There was one before the node had started."""
        return self._taken and self._shut_down is None

    def _take(self, number: int) -> None:
        self._taken = True
        if self._shut_down is None:
            raise KeyboardInterrupt
        if number == signal.SIGHUP:  # of which rclpy knows nothing
            self._shut_down()


@contextmanager
def ending_signals() -> Iterator[EndingSignals]:
    """Signals end the node inside the block."""
    signals = EndingSignals()
    try:
        yield signals
    finally:
        signals.restore()
