"""Starting and ending ROS in a process."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import rclpy
from rclpy.signals import SignalHandlerOptions, uninstall_signal_handlers
from rclpy.utilities import try_shutdown

from haul_ros.ros.errors import INSTALL_HINT, RosError


class EndingSignals:
    """What SIGINT, SIGTERM and SIGHUP do to a node: interrupt it while it starts, then shut ROS down.

    After ``started`` no KeyboardInterrupt arises, so a second Ctrl-C cannot break into a clean end;
    a spinning executor ends with ExternalShutdownException. To be installed in the main thread.
    """

    def __init__(self) -> None:
        self._starting = True
        self._taken = False
        self._previous = {
            number: signal.signal(number, self._take)
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
            if signal.getsignal(number) is not signal.SIG_IGN  # as under nohup
        }

    def started(self) -> None:
        """From now on the node ends by the shutdown of ROS alone."""
        self._starting = False

    def restore(self) -> None:
        """Give the signals back to who had them."""
        for number, handler in self._previous.items():
            signal.signal(number, handler)

    @property
    def taken(self) -> bool:
        """Whether there was one: a KeyboardInterrupt is lost where it meets code that lets no exception out."""
        return self._taken

    def _take(self, number: int, _frame: object) -> None:
        self._taken = True
        if self._starting:
            raise KeyboardInterrupt
        if number == signal.SIGHUP:  # of which rclpy knows nothing
            try_shutdown()


@contextmanager
def ros_node_context(argv: Sequence[str]) -> Iterator[EndingSignals]:
    """ROS running inside the block for a node that ends by signals, with the ROS arguments in ``argv``.

    The first item of ``argv`` is the program's name.

    Raises
    ------
    RosError
        No middleware is installed, or the ROS arguments are wrong.
    """
    # rclpy passes a signal on to the handler that it found, so these have to be there first
    signals = EndingSignals()
    try:
        _init(argv, SignalHandlerOptions.ALL)
        yield signals
    finally:
        try_shutdown()
        uninstall_signal_handlers()
        signals.restore()


@contextmanager
def ros_client_context(argv: Sequence[str]) -> Iterator[None]:
    """ROS running inside the block, signals left alone; otherwise as `ros_node_context`."""
    try:
        _init(argv, SignalHandlerOptions.NO)
        yield
    finally:
        try_shutdown()


def _init(argv: Sequence[str], signals: SignalHandlerOptions) -> None:
    try:
        rclpy.init(args=list(argv), signal_handler_options=signals)
    except ImportError as error:
        raise RosError(f"ROS 2 has no middleware here ({_first_line(error)}); {INSTALL_HINT}") from error
    except RuntimeError as error:  # RCLError or UnknownROSArgsError, which rclpy does not export
        raise RosError(f"ROS 2 cannot be started with these arguments: {_first_line(error)}") from error


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0].rstrip(": ")
