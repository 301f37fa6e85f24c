"""``haul view``: the live page of a node."""

from __future__ import annotations

import argparse
from importlib.util import find_spec

from haul_ros.cli.ros import node_name
from haul_ros.errors import HaulError
from haul_ros.ros.errors import require_ros


class ViewError(HaulError):
    """A live view that cannot be had."""


def watched_node(arguments: argparse.Namespace) -> str | None:
    """The node that is asked for; None: the one that is found."""
    return None if arguments.node is None else node_name(arguments)


def require_view(library: str) -> None:
    """Refuse to go on without a library of the extra ``view``.

    Raises
    ------
    ViewError
        It is missing.
    """
    if find_spec(library) is None:
        raise ViewError(f"needs {library}; install it with: pip install 'haul_ros[view]'")


def view(arguments: argparse.Namespace) -> int:
    """Serve the page until SIGINT, SIGTERM or SIGHUP, which end it with status 0."""
    name = watched_node(arguments)
    if not 0 <= arguments.port <= 65535:
        raise ViewError(f"--port {arguments.port}: expected 1 to 65535, or 0 for any that is free")
    require_ros()
    require_view("tornado")
    from haul_ros.ros.view.serve import serve  # needs rclpy and tornado

    what = "look and drive" if arguments.drive else "look"
    serve(name, arguments.port, drive=arguments.drive, tell=lambda address: print(f"{what}: {address}", flush=True))
    return 0
