"""What can go wrong with a study by the user's doing."""

from __future__ import annotations

from haul_ros.errors import HaulError


class StudyError(HaulError):
    """A study that cannot be defined, run or written."""
