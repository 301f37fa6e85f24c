"""Names of the recordings that one node writes: as asked for, and one more for every reset."""

from __future__ import annotations

from datetime import datetime
from itertools import count
from pathlib import Path

from haul_ros.recording.run_file import ACTIVE_SUFFIX
from haul_ros.ros.parameters import NO_RECORDING


def first_recording(record_path: str, scenario_name: str, now: datetime) -> Path | None:
    """File to record to, from the parameter ``record_path`` and the time ``now`` in UTC; None: no recording."""
    if record_path == NO_RECORDING:
        return None
    return Path(record_path or f"{scenario_name}_{now:%Y%m%dT%H%M%SZ}.mcap")


def following_recording(first: Path) -> Path:
    """The first of ``run_2.mcap``, ``run_3.mcap`` ... after ``run.mcap`` that is not taken, not even unfinished."""
    candidates = (first.with_name(f"{first.stem}_{number}{first.suffix}") for number in count(2))
    return next(path for path in candidates if not (path.exists() or Path(f"{path}{ACTIVE_SUFFIX}").exists()))
