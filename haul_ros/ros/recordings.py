"""Names of the recordings that one node writes: as asked for, and one more for every reset."""

from __future__ import annotations

from datetime import datetime
from itertools import count
from pathlib import Path

from haul_ros.recording.run_file import ACTIVE_SUFFIX
from haul_ros.ros.parameters import NO_RECORDING


def recording_path(record_path: str, scenario_name: str, begins: datetime, *, again: bool = False) -> Path | None:
    """File to record a run to that ``begins`` now (UTC), by the parameter ``record_path``; None: no recording.

    A path that was asked for is used as it is once, and ``again`` with a number, as a name that the time gives where it
    is taken.
    """
    if record_path == NO_RECORDING:
        return None
    if record_path:
        return _numbered(Path(record_path)) if again else Path(record_path)
    path = Path(f"{scenario_name}_{begins:%Y%m%dT%H%M%SZ}.mcap")
    return _numbered(path) if _is_taken(path) else path


def _numbered(first: Path) -> Path:
    """The first of ``run_2.mcap``, ``run_3.mcap`` ... after ``run.mcap`` that is not taken."""
    candidates = (first.with_name(f"{first.stem}_{number}{first.suffix}") for number in count(2))
    return next(path for path in candidates if not _is_taken(path))


def _is_taken(path: Path) -> bool:
    """Whether there is such a file, be it unfinished."""
    return path.exists() or Path(f"{path}{ACTIVE_SUFFIX}").exists()
