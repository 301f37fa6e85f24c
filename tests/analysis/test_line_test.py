"""Measured signals put to couplers and vehicles, and their errors by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from haul_ros.analysis import line_test
from haul_ros.analysis.line_test import (
    BANDS,
    LineTestError,
    Signal,
    error_statistics,
    read_csv,
    read_mapping,
    signals,
)

COUPLERS = ("coupler_001", "coupler_002")
VEHICLES = ("vehicle_001_SS4", "vehicle_002_C80", "vehicle_003_C80")


def test_the_bands_are_the_published_ones() -> None:
    assert BANDS == ((64.6, 0.68), (129.2, 0.95), (193.8, 0.997))


def test_errors_by_hand() -> None:
    found = error_statistics(
        np.array([100.0, 164.6, 0.0, -100.0, np.nan, 7.0]), np.array([100.0, 100.0, 130.0, 100.0, 5.0, np.nan])
    )
    # Errors 0, +64.6, -130, -200; the last two are not compared
    assert found.samples == 4
    assert found.mean == pytest.approx((64.6 - 130.0 - 200.0) / 4)
    assert found.rms == pytest.approx(((64.6**2 + 130.0**2 + 200.0**2) / 4) ** 0.5)
    assert found.standard_deviation == pytest.approx((found.rms**2 - found.mean**2) ** 0.5)
    assert found.largest == 200.0
    assert found.within == (0.5, 0.5, 0.75)


def test_a_correlation_is_that_of_straight_lines_and_none_of_a_constant() -> None:
    time = np.arange(10.0)
    assert error_statistics(2.0 * time + 1.0, time).correlation == pytest.approx(1.0)
    assert error_statistics(-time, time).correlation == pytest.approx(-1.0)
    assert np.isnan(error_statistics(time, np.ones(10)).correlation)
    assert error_statistics(np.array([np.nan]), np.array([1.0])).samples == 0


def test_signals_are_read_and_put_to_couplers_and_vehicles(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text("GPS time,force A,v,note\n0.0,-100,72,x\n\n0.5,,71,y\n1.5,-50,70,z\n", "utf-8")
    (tmp_path / "map.txt").write_text(
        "# line test of the paper\nforce A = -coupler_002\nv=vehicle_001 # head\n", "utf-8"
    )
    targets = read_mapping([str(tmp_path / "map.txt"), "GPS time=time"])
    assert targets == {"force A": "-coupler_002", "v": "vehicle_001", "GPS time": "time"}

    measured = read_csv(path, ["force A", "v"], "GPS time")
    assert measured.time.tolist() == [0.0, 0.5, 1.5]
    np.testing.assert_array_equal(measured.columns["force A"], [-100.0, np.nan, -50.0])
    assert signals(measured, targets, COUPLERS, VEHICLES) == (
        Signal("force A", "coupler_002", True, 1, -1.0),
        Signal("v", "vehicle_001_SS4", False, 0),
    )


def test_columns_that_are_called_as_couplers_need_no_mapping(tmp_path: Path) -> None:
    path = tmp_path / "series.csv"
    path.write_text("time_s,coupler_002_force_kN,coupler_002_stroke_mm,vehicle_003_C80_speed_kmh\n0,1,2,3\n", "utf-8")
    measured = read_csv(path, None)
    assert signals(measured, {}, COUPLERS, VEHICLES) == (
        Signal("coupler_002_force_kN", "coupler_002", True, 1),
        Signal("vehicle_003_C80_speed_kmh", "vehicle_003_C80", False, 2),
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "0 columns, expected a header with 2 to 1000"),
        ("time_s,force\n0,1\n", "no column is called as coupler_050 or vehicle_001_speed_kmh, expected --map"),
        ("seconds,coupler_001\n0,1\n", "has no column time_s, it has seconds, coupler_001"),
        ("time_s,coupler_001,coupler_001\n0,1,2\n", "has more than one column coupler_001"),
        ("time_s,coupler_001\n0,1\n1,n/a\n", ":3: coupler_001 is 'n/a', expected a number"),
        ("time_s,coupler_001\n1,1\n1,2\n", "time_s does not rise from row to row, expected times in s"),
        ("time_s,coupler_001\n", "time_s does not rise"),
    ],
)
def test_a_csv_that_cannot_be_used_is_told_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "test.csv"
    path.write_text(text, "utf-8")
    with pytest.raises(LineTestError) as caught:
        read_csv(path, None)
    assert message in str(caught.value)
    assert "test.csv" in str(caught.value)


def test_rows_are_read_in_pieces_up_to_a_bound(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(line_test, "_PIECE", 3)
    monkeypatch.setattr(line_test, "MOST_ROWS", 10)
    path = tmp_path / "test.csv"
    path.write_text("time_s,coupler_001\n" + "".join(f"{i},{-i}\n" for i in range(10)), "utf-8")
    measured = read_csv(path, None)
    assert measured.time.tolist() == list(range(10))
    assert measured.columns["coupler_001"].tolist() == [-i for i in range(10)]
    path.write_text(path.read_text("utf-8") + "10,1\n", "utf-8")
    with pytest.raises(LineTestError, match="more than 10 rows, expected at most that"):
        read_csv(path, None)


def test_bytes_that_are_no_text_are_refused(tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(LineTestError, match=r"x\.csv: not UTF-8 text, expected a CSV file"):
        read_csv(tmp_path / "x.csv", None)
    with pytest.raises(LineTestError, match=r"missing\.csv: cannot be read: No such file"):
        read_csv(tmp_path / "missing.csv", None)


def test_targets_that_the_train_does_not_have_are_told(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text("time_s,f\n0,1\n", "utf-8")
    measured = read_csv(path, ["f"])
    for target in ("coupler_003", "vehicle_004", "coupler", "-"):
        with pytest.raises(LineTestError, match=r"f is put to .*, expected coupler_001 to coupler_002 or vehicle_001"):
            signals(measured, {"f": target}, COUPLERS, VEHICLES)
    with pytest.raises(LineTestError, match=r"no such file|cannot be read"):
        read_mapping([str(tmp_path / "missing")])
    with pytest.raises(LineTestError, match=r"--map: 'f=', expected COLUMN="):
        read_mapping(["f="])
