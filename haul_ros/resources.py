"""Where the shipped catalogue, scenarios, lines and schemas are."""

from __future__ import annotations

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


def shipped_scenarios() -> dict[str, Path]:
    """Names of the shipped scenarios, sorted, and their files."""
    return {path.stem: path for path in sorted((config_dir() / "scenarios").glob("*.yaml"))}


def shipped_lines() -> dict[str, Path]:
    """Names of the shipped lines, sorted, and their files."""
    files = (config_dir() / "lines").glob("*")
    return {path.stem: path for path in sorted(files) if path.suffix in (".csv", ".yaml")}
