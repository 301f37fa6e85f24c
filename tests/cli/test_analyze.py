from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from haul_ros.analysis import tables
from haul_ros.cli import analyze as analyze_module
from tests.waiting import WAIT

if TYPE_CHECKING:
    from tests.cli.conftest import Haul


@pytest.fixture
def recorded(haul: Haul) -> Haul:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--quiet").status == 0
    return haul


def test_analyze_writes_into_the_default_folder_and_prints_the_summary_of_the_run(recorded: Haul) -> None:
    pytest.importorskip("pyarrow")
    ran = recorded("run", "short.yaml").out.splitlines()
    outcome = recorded("analyze", "run.mcap")
    assert (outcome.status, outcome.err) == (0, "")
    said = outcome.out.splitlines()
    for name in ("short:", "  train", "  peak compression", "  peak tension", "  largest stroke", "  fitted values in"):
        assert [line for line in said if line.startswith(name)] == [line for line in ran if line.startswith(name)]
    assert "(to 0.02 s, from samples)" in outcome.out
    written = [line.split()[1] for line in said if line.startswith("  written")]
    assert [Path(name).name for name in written] == ["peaks.csv", "peaks.parquet", "profile.png", "history.png"]
    assert sorted(map(str, Path("run_analysis").iterdir())) == sorted(written)


def test_json_has_the_numbers_and_the_files(recorded: Haul) -> None:
    ran = json.loads(recorded("run", "short.yaml", "--json").out)
    outcome = recorded("analyze", "run.mcap", "-o", "results", "--json")
    found = json.loads(outcome.out)
    for key in ("peak_compression_kN", "peak_tension_coupler", "largest_stroke_mm", "mass_t", "caveats"):
        assert found[key] == ran[key]
    assert (found["energy"], found["newton"]) == (None, None)
    assert "results/peaks.csv" in found["files"]
    assert all(Path(name).is_file() for name in found["files"])


def test_a_missing_parquet_file_is_explained(recorded: Haul, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (tables, analyze_module):
        monkeypatch.setattr(module, "parquet_available", lambda: False)
    outcome = recorded("analyze", "run.mcap")
    assert outcome.status == 0
    assert outcome.err == "haul: peaks.parquet not written: needs pyarrow, pip install 'haul_ros[parquet]'\n"
    assert not Path("run_analysis/peaks.parquet").exists()


def test_a_backend_of_matplotlib_that_is_not_there_does_not_matter(recorded: Haul, environment: dict[str, str]) -> None:
    command = [sys.executable, "-m", "haul_ros", "analyze", str(Path("run.mcap").resolve())]
    done = subprocess.run(
        command, env=environment | {"MPLBACKEND": "nothing"}, capture_output=True, text=True, timeout=WAIT
    )
    assert done.returncode == 0, done.stderr
    assert Path("run_analysis/history.png").stat().st_size > 0
