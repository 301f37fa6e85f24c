"""Where the shipped catalogue, scenarios, lines and schemas are, and what calls the command `haul`."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from haul_ros.errors import HaulError


def _candidates(package: Path) -> Iterator[Path]:
    yield package.parent / "config"
    for parent in package.parents:
        yield parent / "share" / "haul_ros" / "config"


@cache
def config_dir() -> Path:
    """Folder with ``catalogue``, ``lines``, ``scenarios`` and ``schema``.

    In a source tree (also an editable or symlinked install) it lies beside the package; pip and
    colcon install it as ``<prefix>/share/haul_ros/config``, and the prefix is above the package.

    Raises
    ------
    HaulError
        There is no such folder.
    """
    package = Path(__file__).resolve().parent
    for folder in _candidates(package):
        if (folder / "catalogue").is_dir():
            return folder
    raise HaulError(f"the data files of haul_ros (share/haul_ros/config) are missing above {package}: install it again")


def haul_command() -> str:
    """What the user types for the command ``haul``: in a ROS workspace it is no program on the path."""
    prefixes = filter(None, os.getenv("AMENT_PREFIX_PATH", "").split(os.pathsep))
    if shutil.which("haul") is None and any(Path(prefix, "lib/haul_ros/haul").exists() for prefix in prefixes):
        return "ros2 run haul_ros haul"
    return "haul"


def shipped_scenarios() -> dict[str, Path]:
    """Names of the shipped scenarios, sorted, and their files."""
    return {path.stem: path for path in sorted((config_dir() / "scenarios").glob("*.yaml"))}


def shipped_lines() -> dict[str, Path]:
    """Names of the shipped lines, sorted, and their files."""
    files = (config_dir() / "lines").glob("*")
    return {path.stem: path for path in sorted(files) if path.suffix in (".csv", ".yaml")}
