"""``haul watch``: the live train in a terminal."""

from __future__ import annotations

import argparse
from importlib.util import find_spec

from haul_ros.cli.interrupt import interruption
from haul_ros.cli.ros import node_name
from haul_ros.errors import HaulError
from haul_ros.ros.errors import require_ros


class WatchError(HaulError):
    """A terminal that cannot show a train."""


def watch(arguments: argparse.Namespace) -> int:
    """Show the train until SIGINT, SIGTERM or SIGHUP, which end it with status 0."""
    name = None if arguments.node is None else node_name(arguments)
    require_ros()
    if find_spec("rich") is None:
        raise WatchError("needs rich; install it with: pip install 'haul_ros[view]'")
    from haul_ros.ros.view.watch import watch as show  # needs rclpy and rich

    with interruption() as ended:
        show(name, ended)
    return 0
