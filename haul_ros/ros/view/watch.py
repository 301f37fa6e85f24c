"""``haul watch``: the live train in a terminal."""

from __future__ import annotations

from collections.abc import Callable
from os import getpid
from time import monotonic, sleep
from typing import Any

import rclpy
from rich.console import Console
from rich.live import Live

from haul_ros.page.terminal import TerminalPage
from haul_ros.ros.context import ros_client_context
from haul_ros.ros.view.watcher import TrainWatcher

_POLL = 0.1
_REDRAW = 0.25
"""Wall time [s] between two pictures."""
_LINE = 1.0
"""Between two lines, where the output is no terminal."""


def watch(name: str | None, ended: Callable[[], bool]) -> None:
    """Show the train of the node ``name``, None: of any, until ``ended``.

    Raises
    ------
    RosError
        ROS cannot be started.
    """
    console, page = Console(), TerminalPage()
    with ros_client_context(["haul_watch"]):
        made: dict[str, Any] = {"enable_rosout": False, "start_parameter_services": False}
        watcher = TrainWatcher(rclpy.create_node(f"haul_watch_{getpid()}", **made), name, page.take)
        try:
            if console.is_terminal:
                _draw(console, page, watcher, ended)
            else:
                _tell(page, watcher, ended)
        finally:
            watcher.close()


def _draw(console: Console, page: TerminalPage, watcher: TrainWatcher, ended: Callable[[], bool]) -> None:
    with Live(console=console, screen=True, auto_refresh=False) as live:
        due = monotonic()
        while not ended():
            watcher.poll()
            if monotonic() >= due:
                due = monotonic() + _REDRAW
                live.update(page.screen(console.width, console.height), refresh=True)
            sleep(_POLL)


def _tell(page: TerminalPage, watcher: TrainWatcher, ended: Callable[[], bool]) -> None:
    due = monotonic() + _LINE
    while not ended():
        watcher.poll()
        if monotonic() >= due:
            due += _LINE
            print(page.line(), flush=True)
        sleep(_POLL)
