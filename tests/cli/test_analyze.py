from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from haul_ros.analysis import tables
from haul_ros.cli import analyze as analyze_module
from tests.bags import rebagged
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
    assert said[-1] == (
        "  written            run_analysis: peaks, run_ins, train, rainflow, brake_applications, brake_timing, "
        "radio_delays, events (.csv, .parquet), numbers.npz, profile.png, history.png"
    )
    assert len(list(Path("run_analysis").iterdir())) == 8 * 2 + 3


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
    assert outcome.err == "haul: no Parquet files written: needs pyarrow, pip install 'haul_ros[parquet]'\n"
    assert not Path("run_analysis/peaks.parquet").exists()


def test_a_backend_of_matplotlib_that_is_not_there_does_not_matter(recorded: Haul, environment: dict[str, str]) -> None:
    command = [sys.executable, "-m", "haul_ros", "analyze", str(Path("run.mcap").resolve())]
    done = subprocess.run(
        command, env=environment | {"MPLBACKEND": "nothing"}, capture_output=True, text=True, timeout=WAIT
    )
    assert done.returncode == 0, done.stderr
    assert Path("run_analysis/history.png").stat().st_size > 0


def test_a_part_of_the_time_and_some_couplers_are_chosen(recorded: Haul) -> None:
    outcome = recorded("analyze", "run.mcap", "-o", "part", "--from", "1", "--to", "1.5", "--couplers", "2,4-5")
    assert (outcome.status, outcome.err) == (0, "")
    assert "  samples            26 from 1.000 to 1.500 s, every 0.02 s" in outcome.out
    peaks = Path("part/peaks.csv").read_text("utf-8").splitlines()
    assert [row.split(",")[0] for row in peaks] == ["coupler", "coupler_002", "coupler_004", "coupler_005"]
    series = Path("part/series.csv").read_text("utf-8").splitlines()
    assert series[0].startswith("time_s,coupler_002_force_kN,coupler_002_stroke_mm,coupler_004_force_kN,")
    assert (len(series), series[1].split(",")[0], series[-1].split(",")[0]) == (27, "1", "1.5")
    assert Path("part/series.png").stat().st_size > 0


@pytest.mark.parametrize(("suffix", "head"), [("pdf", b"%PDF"), ("svg", b"<?xml"), ("png", b"\x89PNG")])
def test_pictures_for_print(recorded: Haul, suffix: str, head: bytes) -> None:
    outcome = recorded("analyze", "run.mcap", "-o", "out", "--format", suffix, "--dpi", "100")
    assert outcome.status == 0
    for name in ("profile", "history"):
        assert Path(f"out/{name}.{suffix}").read_bytes().startswith(head)
    if suffix == "svg":  # 174 mm are 493.2 points, and text stays text
        text = Path("out/profile.svg").read_text("utf-8")
        assert 'width="493.2' in text
        assert "compression (buff)</text>" in text


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--couplers", "0"], "argument --couplers: '0', expected numbers from 1 up, the smaller first"),
        (["--couplers", "5-2"], "argument --couplers: '5-2', expected numbers from 1 up, the smaller first"),
        (["--couplers", "a"], "argument --couplers: 'a', expected numbers and ranges such as 1,50-60"),
        (["--couplers", "22"], "run.mcap: no coupler 22, it has 1 to 21"),
        (["--from", "nan"], "argument --from: 'nan', expected seconds"),
        (["--limit", "0"], "argument --limit: 0, expected a number above 0"),
        (["--dpi", "9999"], "argument --dpi: '9999', expected a whole number from 30 to 1200"),
        (["--node", "/train_b"], "run.mcap: no train of node /train_b, it has /haul"),
        (["--run", "2"], "run.mcap: no run 2, it has 1"),
        (["--from", "500", "--to", "900"], "run.mcap: holds no /haul/couplers from 500 to 900 s: nothing was run"),
    ],
)
def test_what_cannot_be_chosen_is_told_in_one_line(recorded: Haul, arguments: list[str], told: str) -> None:
    outcome = recorded("analyze", "run.mcap", "-o", "out", *arguments)
    assert outcome.status == 2
    assert outcome.err.startswith(f"haul: {told}")
    assert outcome.err.count("\n") == 1
    assert not Path("out").exists()


def test_a_bag_by_another_recorder_gives_the_same_numbers(recorded: Haul) -> None:
    """The scenario is not in it: what needs it is left out, and that is said."""
    own = json.loads(recorded("analyze", "run.mcap", "-o", "own", "--json").out)
    rebagged("run.mcap", "bag.mcap", library="libmcap 1.1.0")
    outcome = recorded("analyze", "bag.mcap", "-o", "bag", "--json")
    assert (outcome.status, outcome.err) == (0, "")
    found = json.loads(outcome.out)
    same = ("samples", "train", "brake_applications", "radio_delays", "run_ins", "force_reversals", "limit_kN")
    assert {key: found[key] for key in same} == {key: own[key] for key in same}
    assert found["energy_from_samples"] is None
    assert own["energy_from_samples"]["brake_work_MJ"] > 0.0
    assert "no scenario in it" in found["left_out"][0]
    header, *rows = Path("bag/peaks.csv").read_text("utf-8").splitlines()
    own_header, *own_rows = Path("own/peaks.csv").read_text("utf-8").splitlines()
    taken = [own_header.split(",").index(name) for name in header.split(",")]
    assert [row.split(",") for row in rows] == [[row.split(",")[i] for i in taken] for row in own_rows]
    of_scenario = {"distance_from_head_m", "bottomed", "dissipated_energy_kJ"}
    assert set(own_header.split(",")) - set(header.split(",")) == of_scenario
    words = recorded("analyze", "bag.mcap", "-o", "bag").out
    assert words.startswith("bag.mcap, recorded by libmcap 1.1.0\n  train              22 vehicles, 21 couplers\n")


def test_the_summary_of_the_simulation_has_the_same_numbers(recorded: Haul) -> None:
    ran = json.loads(recorded("run", "short.yaml", "--json").out)
    found = json.loads(recorded("analyze", "run.mcap", "--json").out)
    same = [key for key in ran if key.startswith(("peak_", "largest_", "bottomed")) or key == "distance_m"]
    assert len(same) > 15
    assert {key: found[key] for key in same} == {key: ran[key] for key in same}
    assert found["peaks_from"] == "every time step"
    # 50 samples a second of a stop of seconds: 0.1 % and better, see docs/analysis.md
    for name in ("kinetic_start_MJ", "brake_work_MJ", "resistance_work_MJ"):
        column = name.replace("kinetic_start", "kinetic_energy_start")
        assert found["energy_from_samples"][column] == pytest.approx(ran["energy"][name], rel=1e-3)
