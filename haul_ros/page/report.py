"""A report: the page of a recording as a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from haul_ros.errors import HaulError
from haul_ros.files import write_new_file
from haul_ros.page.contents import report_contents
from haul_ros.page.document import page
from haul_ros.recording.trains import open_train


class ReportError(HaulError):
    """A report that cannot be written."""


@dataclass(frozen=True, slots=True)
class Report:
    """A file that was written, and its size in bytes."""

    path: Path
    size: int


def default_report(recording: Path) -> Path:
    """``<name of the file>.html`` in the current folder."""
    return Path(f"{recording.resolve().stem}.html")


def write_report(
    recording: Path,
    path: Path,
    *,
    node: str | None = None,
    run: int | None = None,
    show: Callable[[int, int], None] = lambda _done, _of: None,
) -> Report:
    """Write the report of a recording of any kind to a new file, once all of the recording has been read.

    ``node`` and ``run`` choose a train as `open_train` does; ``show`` is told how many samples of how many are read.

    Raises
    ------
    HaulError
        The recording cannot be used, or the file cannot be written or is there already.
    """
    if path.exists():
        raise ReportError(f"{path}: exists already, expected the name of a new file (-o)")
    with open_train(recording, node, run) as source:
        data = page(report_contents(source, show)).encode()
    try:
        write_new_file(path, data)
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise ReportError(f"{path}: cannot be written: {getattr(error, 'strerror', None) or error}") from error
    return Report(path, len(data))
