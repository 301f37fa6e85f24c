"""Results of other sources are other results."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import haul_ros
from haul_ros.studies.sources import results_digest

PACKAGE = Path(haul_ros.__file__).parent


@pytest.mark.parametrize(
    "changed",
    [
        "physics/hinges.py",
        "physics/assembly.py",
        "physics/kernel/coupler.py",
        "scenario/draft_gears.py",
        "simulation/radio.py",
        "model/vehicle.py",
        "studies/case.py",
        "units.py",
    ],
)
def test_a_change_of_any_source_that_makes_results_changes_their_key(tmp_path: Path, changed: str) -> None:
    copy = tmp_path / "haul_ros"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__", "ros", "cli", "recording"))
    assert results_digest(copy) == results_digest()
    (copy / changed).write_text((copy / changed).read_text() + "\n# changed\n")
    results_digest.cache_clear()
    assert results_digest(copy) != results_digest()
