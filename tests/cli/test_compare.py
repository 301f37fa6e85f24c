from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.bags import Train, write_mcap

if TYPE_CHECKING:
    from tests.cli.conftest import Haul


@pytest.fixture
def recorded(haul: Haul) -> Haul:
    """The same driver, the slave 1 s and 3 s late."""
    assert haul("run", "short.yaml", "-o", "soon.mcap", "--quiet").status == 0
    late = ("--set", "radio.default.delay_s=3", "-o", "late.mcap", "--quiet")
    assert haul("run", "short.yaml", *late).status == 0
    return haul


def _rows(path: str) -> list[dict[str, str]]:
    with Path(path).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_two_runs_have_the_numbers_of_their_own_summaries_and_the_differences(recorded: Haul) -> None:
    own = {name: json.loads(recorded("analyze", f"{name}.mcap", "--json").out) for name in ("soon", "late")}
    outcome = recorded("compare", "soon.mcap", "late.mcap", "-o", "out")
    assert (outcome.status, outcome.err) == (0, "")
    rows = {row["quantity"]: row for row in _rows("out/comparison.csv")}
    for quantity in ("peak_compression_kN", "peak_tension_kN", "largest_stroke_mm", "distance_m"):
        values = [own[name][quantity] for name in ("soon", "late")]
        row = rows[quantity]
        assert [float(row[name]) for name in ("soon", "late")] == pytest.approx(values, rel=1e-8)
        assert float(row["late_difference"]) == pytest.approx(values[1] - values[0], abs=1e-5)
    delays = rows["longest_radio_delay_s"]
    assert [float(delays[name]) for name in ("soon", "late", "late_difference")] == [1.0, 3.0, 2.0]
    profiles = _rows("out/profiles.csv")
    assert len(profiles) == 21
    largest = max(float(row["late_max_compression_kN"]) for row in profiles)
    assert largest == pytest.approx(own["late"]["peak_compression_kN"], rel=1e-8)
    assert Path("out/profiles.png").stat().st_size > 0
    assert "  longest_radio_delay_s " in outcome.out


def test_a_run_compared_with_itself_has_no_differences(recorded: Haul) -> None:
    found = json.loads(recorded("compare", "soon.mcap", "soon.mcap", "-o", "out", "--json").out)
    differences = [row["2_soon_difference"] for row in found["comparison"]]
    assert set(differences) <= {0.0, None}
    assert len(differences) > 20


def test_a_measured_line_test_by_hand(recorded: Haul) -> None:
    """The samples of a run, moved by known amounts, are a line test whose errors are known."""
    recorded("analyze", "soon.mcap", "-o", "series", "--couplers", "3,9")
    with Path("test.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["clock", "draft at wagon 3", "coupler B"])
        for number, row in enumerate(_rows("series/series.csv")):
            first, second = float(row["coupler_003_force_kN"]), float(row["coupler_009_force_kN"])
            # One 50 kN too high and with the other sign; of the other every second 100 kN too low
            writer.writerow([float(row["time_s"]) + 7.0, -(first - 50.0), second + (100.0 if number % 2 else 0.0)])
    arguments = ["--map", "draft at wagon 3=-coupler_003", "--map", "coupler B=coupler_009", "--map", "clock=time"]
    outcome = recorded("compare", "soon.mcap", "test.csv", *arguments, "--offset", "-7", "-o", "out", "--json")
    assert (outcome.status, outcome.err) == (0, "")
    first, second, every = json.loads(outcome.out)["errors"]
    count = len(_rows("test.csv"))
    assert first["samples"] == second["samples"] == count
    assert (first["target"], second["target"], every["column"]) == ("coupler_003", "coupler_009", "all forces")
    assert first["mean_error"] == pytest.approx(50.0, abs=1e-4)
    assert first["standard_deviation"] == pytest.approx(0.0, abs=1e-4)
    assert first["share_within_64.6_kN"] == 1.0
    assert second["mean_error"] == pytest.approx(-100.0 * (count // 2) / count, abs=1e-4)
    assert second["share_within_64.6_kN"] == pytest.approx((count - count // 2) / count)
    assert second["share_within_129.2_kN"] == 1.0
    assert every["samples"] == 2 * count
    assert every["share_within_64.6_kN"] == pytest.approx((first["samples"] + count - count // 2) / (2 * count))
    assert Path("out/measured.png").stat().st_size > 0
    words = recorded("compare", "soon.mcap", "test.csv", *arguments, "--offset", "-7", "-o", "out").out
    assert "100.0% within 64.6 kN (published 68.0%)" in words


def test_series_of_an_analysis_are_a_line_test_without_mapping(recorded: Haul) -> None:
    recorded("analyze", "late.mcap", "-o", "series", "--couplers", "5")
    found = json.loads(recorded("compare", "soon.mcap", "late.mcap", "series/series.csv", "-o", "out", "--json").out)
    errors = {row["recording"]: row for row in found["errors"]}
    assert errors["late"]["rms_error"] == pytest.approx(0.0, abs=1e-5)
    assert errors["soon"]["rms_error"] > 1.0
    assert errors["late"]["correlation"] == pytest.approx(1.0)
    assert {Path(file).name for file in found["files"]} >= {"comparison.csv", "errors.csv", "measured.png"}


def test_two_trains_and_two_runs_of_one_bag_are_compared(haul: Haul) -> None:
    time = np.arange(0.0, 2.0, 0.1)
    still = np.zeros((20, 2))
    train = Train(time, np.full((20, 1), 100e3), np.zeros((20, 1)), np.zeros((20, 1)), still, still, still, still)
    again = replace(train, force=train.force * 3.0)
    other = replace(train, node="/b/haul", force=train.force * 2.0).messages()
    later = [message._replace(log_time=message.log_time + 10**10) for message in again.messages()]
    write_mcap(Path("bag.mcap"), [*sorted([*train.messages(), *other], key=lambda m: m.log_time), *later])

    def peaks(*arguments: str) -> dict[str, float]:
        outcome = haul("compare", "bag.mcap", "bag.mcap", "-o", "out", "--json", *arguments)
        assert (outcome.status, outcome.err) == (0, "")
        row = next(row for row in json.loads(outcome.out)["comparison"] if row["quantity"] == "peak_compression_kN")
        return {name: value for name, value in row.items() if name != "quantity"}

    expected = {"1_bag": 100.0, "2_bag": 300.0, "2_bag_difference": 200.0}
    assert peaks("--node", "/haul", "--run", "1", "--run", "2") == expected
    trains = peaks("--node", "/haul", "--node", "/b/haul", "--run", "1")
    assert trains == {"1_bag": 100.0, "2_bag": 200.0, "2_bag_difference": 100.0}
    refused = haul("compare", "bag.mcap", "bag.mcap", *(["--run", "1"] * 3))
    assert refused.status == 2
    assert refused.err == "haul: --run 3 times for 2 recordings, expected once for all or once for each\n"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["soon.mcap"], "a comparison needs a recording, and another one or a measured line test as .csv"),
        (["test.csv", "test.csv"], "a comparison needs a recording, and another one or a measured line test as .csv"),
        (["soon.mcap", "short.yaml"], "short.yaml: not an MCAP file, expected a recording of haul_ros, or a bag"),
        (["soon.mcap", "late.mcap", "--map", "a=coupler_001"], "--map without a measured line test, expected a .csv"),
        (["soon.mcap", "test.csv"], "test.csv: no column is called as coupler_050 or vehicle_001_speed_kmh, expected"),
        (
            ["soon.mcap", "test.csv", "--map", "f=coupler_022"],
            "test.csv: f is put to coupler_022, expected coupler_001",
        ),
        (["soon.mcap", "test.csv", "--map", "g=coupler_001"], "test.csv: has no column g, it has time_s, f"),
        (
            ["soon.mcap", "test.csv", "--map", "f=coupler_001", "--offset", "1000"],
            "test.csv: measured from 1000 to 1001 s of simulation, soon.mcap has 0 to",
        ),
    ],
)
def test_what_cannot_be_compared_is_told_in_one_line(recorded: Haul, arguments: list[str], told: str) -> None:
    Path("test.csv").write_text("time_s,f\n0,1\n1,2\n", "utf-8")
    outcome = recorded("compare", *arguments, "-o", "out")
    assert outcome.status == 2
    assert outcome.err.startswith(f"haul: {told}")
    assert outcome.err.count("\n") == 1
    assert not Path("out").exists()
