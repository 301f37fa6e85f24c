from __future__ import annotations

import json
import os
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.waiting import WAIT, wait_until

if TYPE_CHECKING:
    from tests.cli.conftest import Haul

ROOT = Path(__file__).parents[2]
SWEEP = ("study", "sweep", "--scenario", "short.yaml")


def test_a_sweep_prints_what_it_wrote(haul: Haul) -> None:
    outcome = haul(*SWEEP, "--over", "initial_speed_kmh=10:20:5", "--set", "time_step_ms=2", "-o", "out")
    assert outcome.status == 0, outcome.err
    assert outcome.out.startswith("sweep: sweep of short, 3 of 3 cases\n")
    assert "out/sweep.csv" in outcome.out
    assert Path("out/sweep.png").is_file()


def test_json_has_findings_and_files(haul: Haul) -> None:
    arguments = ("--draw", "vehicles.C80.mass_t=normal(100,3)", "--samples", "3", "--seed", "2", "--json")
    outcome = haul(*SWEEP, *arguments)
    printed = json.loads(outcome.out)
    assert (printed["finished"], printed["cases"]) == (3, 3)
    assert printed["claims"][0]["claim"] == "largest force"
    assert all(Path(file).is_file() for file in printed["files"])
    assert "sweep_study/sweep_quantiles.csv" in printed["files"]


def test_a_named_study_says_what_becomes_of_each_claim_and_what_is_fitted(haul: Haul) -> None:
    outcome = haul("study", "vibration")
    assert outcome.status == 0
    assert "  predicted: lower stiffness lowers all frequencies" in outcome.out
    assert "  fitted values in   brake_systems.paper_set_b, couplers.paper_set_b, vehicles.C80\n" in outcome.out
    assert Path("vibration_study/vibration.csv").is_file()


def test_a_study_file_runs(haul: Haul) -> None:
    Path("mine.yaml").write_text("scenario: short.yaml\nover: {initial_speed_kmh: [10, 15]}\n", "utf-8")
    outcome = haul("study", "mine.yaml", "--quiet", "--jobs", "1")
    assert (outcome.status, outcome.out, outcome.err) == (0, "", "")
    assert Path("mine_study/mine.csv").is_file()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("study", "nonsense"), "nonsense: no such study"),
        (("study", "sweep", "--over", "a=1"), "expected --scenario"),
        ((*SWEEP,), "nothing is varied"),
        ((*SWEEP, "--over", "initial_sped_kmh=1,2"), "unknown key, did you mean initial_speed_kmh"),
        ((*SWEEP, "--over", "initial_speed_kmh=100:40:20"), "an empty range"),
        ((*SWEEP, "--over", "initial_speed_kmh=10,-3"), "initial_speed_kmh = -3"),
        ((*SWEEP, "--over", "initial_speed_kmh=10", "--jobs", "0"), "--jobs 0: must be 1 or more"),
        ((*SWEEP, "--draw", "initial_speed_kmh=uniform(1,2)"), "--draw and --samples are given together"),
        (("study", "sweep", "--scenario", "no.yaml", "--over", "initial_speed_kmh=1"), "no.yaml: no such scenario"),
        (("study", "validation", "--over", "initial_speed_kmh=10"), "--over: only for haul study sweep"),
    ],
)
def test_a_mistake_is_one_line_status_2_and_no_folder(haul: Haul, arguments: tuple[str, ...], message: str) -> None:
    outcome = haul(*arguments, "-o", "out")
    assert outcome.status == 2
    assert outcome.out == ""
    assert outcome.err.startswith("haul: ")
    assert message in outcome.err
    assert outcome.err.count("\n") == 1
    assert not Path("out").exists()


def test_a_scheduler_that_is_none_is_one_line(haul: Haul) -> None:
    pytest.importorskip("distributed")
    outcome = haul(*SWEEP, "--over", "initial_speed_kmh=10", "--scheduler", "here", "-o", "out")
    assert outcome.status == 2
    assert outcome.err.startswith("haul: scheduler here: not there, expected tcp://HOST:PORT")
    assert outcome.err.count("\n") == 1
    assert not Path("out").exists()


@pytest.mark.slow
def test_ctrl_c_keeps_finished_cases_and_the_same_command_goes_on(haul: Haul) -> None:
    arguments = [*SWEEP, "--over", "initial_speed_kmh=20:60:0.05", "--jobs", "1", "-o", "out"]
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    process = subprocess.Popen(
        [sys.executable, "-m", "haul_ros", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": path},
    )  # fmt: skip
    results = Path("out/results.sqlite")
    wait_until(lambda: _finished(results) > 0, "the first case")
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=WAIT)
    assert process.returncode == 130
    kept = _finished(results)
    assert 1 <= kept < 801
    assert f"interrupted, {kept} of 801 cases are kept in out" in err
    assert len(Path("out/sweep.csv").read_text("utf-8").splitlines()) == kept + 1
    # What is kept is what a whole run gives.
    few = [*SWEEP, "--over", "initial_speed_kmh=20.0", "-o", "out"]
    assert haul(*few).status == 0
    assert _finished(results) == kept


def _finished(results: Path) -> int:
    """Cases in the file, 0 before there is one."""
    if not results.is_file():
        return 0
    database = sqlite3.connect(results)
    try:
        return int(database.execute("SELECT COUNT(*) FROM results").fetchone()[0])
    except sqlite3.OperationalError:
        return 0
    finally:
        database.close()
