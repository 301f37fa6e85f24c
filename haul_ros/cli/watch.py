"""``haul watch``: the live train in a terminal."""

from __future__ import annotations

import argparse

from haul_ros.cli.interrupt import interruption
from haul_ros.cli.view import require_view, watched_node
from haul_ros.ros.errors import require_ros


def watch(arguments: argparse.Namespace) -> int:
    """Show the train until SIGINT, SIGTERM or SIGHUP, which end it with status 0."""
    name = watched_node(arguments)
    require_ros()
    require_view("rich")
    from haul_ros.ros.view.watch import watch as show  # needs rclpy and rich

    with interruption() as ended:
        show(name, ended)
    return 0
