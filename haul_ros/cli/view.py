"""``haul view``: the live page of a node."""

from __future__ import annotations

import argparse
from importlib.util import find_spec

from haul_ros.cli.ros import node_name
from haul_ros.errors import HaulError
from haul_ros.ros.errors import require_ros


class ViewError(HaulError):
    """A live page that cannot be had."""


def view(arguments: argparse.Namespace) -> int:
    """Serve the page until SIGINT, SIGTERM or SIGHUP, which end it with status 0."""
    name = None if arguments.node is None else node_name(arguments)
    if not 0 <= arguments.port <= 65535:
        raise ViewError(f"--port {arguments.port}: expected 1 to 65535, or 0 for any that is free")
    require_ros()
    if find_spec("tornado") is None:
        raise ViewError("needs tornado; install it with: pip install 'haul_ros[view]'")
    from haul_ros.ros.view.serve import serve  # needs rclpy and tornado

    what = "look and drive" if arguments.drive else "look"
    serve(name, arguments.port, drive=arguments.drive, tell=lambda address: print(f"{what}: {address}", flush=True))
    return 0
