"""Starting and ending ROS in a process."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path

import rclpy
from rclpy.signals import SignalHandlerOptions, uninstall_signal_handlers
from rclpy.utilities import try_shutdown

from haul_ros.files import open_file
from haul_ros.ros.errors import INSTALL_HINT, RosError

MOST_BYTES = 64 * 1024
"""Longest parameter file: rcl takes time with the square of the length of a list in it."""


def shut_down() -> None:
    """Shut ROS down, if it runs; a signal may be doing the same."""
    with suppress(RuntimeError):  # RCLError, which rclpy does not export
        try_shutdown()


@contextmanager
def ros_node_context(argv: Sequence[str]) -> Iterator[None]:
    """ROS running inside the block for a node that ends by signals, with the ROS arguments in ``argv``.

    The first item of ``argv`` is the program's name.

    Raises
    ------
    RosError
        No middleware is installed, or the ROS arguments are wrong.
    """
    try:
        _init(argv, SignalHandlerOptions.ALL)
        yield
    finally:
        shut_down()
        uninstall_signal_handlers()


@contextmanager
def ros_client_context(argv: Sequence[str]) -> Iterator[None]:
    """ROS running inside the block, signals left alone; otherwise as `ros_node_context`."""
    try:
        _init(argv, SignalHandlerOptions.NO)
        yield
    finally:
        try_shutdown()


def _init(argv: Sequence[str], signals: SignalHandlerOptions) -> None:
    for option, path in pairwise(argv):
        if option == "--params-file":
            _check_size(Path(path))
    try:
        rclpy.init(args=list(argv), signal_handler_options=signals)
    except ImportError as error:
        raise RosError(f"ROS 2 has no middleware here ({_first_line(error)}); {INSTALL_HINT}") from error
    except RuntimeError as error:  # RCLError or UnknownROSArgsError, which rclpy does not export
        raise RosError(f"ROS 2 cannot be started with these arguments: {_first_line(error)}") from error


def _check_size(path: Path) -> None:
    """Refuse a parameter file that is too long, or has no end: rcl reads it whole, and hears no signal meanwhile."""
    try:
        with open_file(path) as file:
            long = len(file.read(MOST_BYTES + 1)) > MOST_BYTES
    except OSError as error:
        raise RosError(f"{path}: parameter file cannot be read: {error.strerror}") from error
    except ValueError as error:  # a null byte in the name
        raise RosError(f"{str(path)!r}: parameter file cannot be read: {error}") from error
    if long:
        raise RosError(f"{path}: more than {MOST_BYTES // 1024} KiB, expected a parameter file of less")


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0].rstrip(": ")
