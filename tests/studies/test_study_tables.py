from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from haul_ros.analysis.tables import write_pieces, write_table
from haul_ros.scenario import load_scenario
from haul_ros.studies.case import Case, Finished, simulate
from haul_ros.studies.sweep import PaperValues
from haul_ros.studies.tables import case_row, columns, profile_table, quantile_table


def test_a_row_holds_the_peaks_of_the_case_in_field_units_and_the_paper_s_numbers(short: str) -> None:
    case = Case("a", short, {}, {"initial_speed_kmh": 30})
    result = simulate(load_scenario(short))
    row = case_row(Finished(case, result), PaperValues(force=700e3))
    assert row["scenario"] == "short"
    assert row["initial_speed_kmh"] == 30
    assert row["max_force_kN"] == max(result.extremes.compression.max(), result.extremes.tension.max()) / 1e3
    assert row["max_force_position"] == (int(result.force.argmax()) + 1) / 12
    assert row["paper_force_kN"] == 700
    assert row["paper_stroke_mm"] is None


def test_columns_fill_gaps_and_turn_unlike_values_into_text() -> None:
    table = columns([{"a": 1, "b": "x"}, {"a": 2.5, "c": True}, {"a": 3, "b": 4}])
    assert table == {"a": [1, 2.5, 3], "b": ["x", None, "4"], "c": [None, True, None]}


def test_profiles_are_the_same_in_csv_and_parquet(tmp_path: Path, short: str) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    result = simulate(load_scenario(short))
    tables = [profile_table(Finished(Case(f"case {n}", short, {}, {}), result)) for n in range(120)]
    files = write_pieces(iter(tables), tmp_path / "profiles")
    assert [file.name for file in files] == ["profiles.csv", "profiles.parquet"]
    rows = list(csv.DictReader(files[0].open(encoding="utf-8")))
    parquet = pq.read_table(files[1])
    assert len(rows) == parquet.num_rows == 120 * 11
    assert [row["case"] for row in rows] == parquet["case"].to_pylist()
    np.testing.assert_allclose([float(row["max_force_kN"]) for row in rows], parquet["max_force_kN"], rtol=1e-8)
    np.testing.assert_array_equal(parquet["max_force_kN"].to_numpy()[:11], result.force / 1e3)


def test_quantiles_are_taken_over_the_cases_at_each_coupler() -> None:
    forces = np.arange(101.0)[:, None] * np.array([1e3, 2e3])
    table = quantile_table(forces, np.array([0.3, 0.6]))
    assert table["force_quantile_0.05_kN"] == pytest.approx([5, 10])
    assert table["force_quantile_0.5_kN"] == pytest.approx([50, 100])
    assert table["force_quantile_1_kN"] == pytest.approx([100, 200])


def test_missing_values_are_written_as_nothing(tmp_path: Path) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    files = write_table(columns([{"a": 1.5}, {"a": None}]), tmp_path / "table")
    assert files[0].read_text("utf-8").splitlines() in (["a", "1.5", ""], ["a", "1.5", '""'])
    assert pq.read_table(files[1])["a"].to_pylist() == [1.5, None]
