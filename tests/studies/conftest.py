"""Short trains that brake in a few milliseconds of computing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from haul_ros.studies.case import Case

SHORT = """\
description: short train
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 10}
  - {vehicle: SS4, role: slave}
coupler: paper_set_b
brakes: paper_set_b
initial_speed_kmh: 30
max_duration_s: 60
commands:
  - {at_s: 0.25, locomotive: master, emergency: true}
"""


@pytest.fixture
def short(tmp_path: Path) -> str:
    """A scenario file."""
    path = tmp_path / "short.yaml"
    path.write_text(SHORT, "utf-8")
    return str(path)


@pytest.fixture
def speeds(short: str) -> Callable[[int], list[Case]]:
    """Cases of the short train from so many different speeds."""

    def cases(count: int) -> list[Case]:
        overrides = [{"initial_speed_kmh": 20.0 + n} for n in range(count)]
        return [Case(f"case {n}", short, values, values) for n, values in enumerate(overrides)]

    return cases
