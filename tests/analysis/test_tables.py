from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from haul_ros.analysis.tables import parquet_available, peak_table, write_csv, write_parquet
from haul_ros.model.scenario import Scenario

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun


def test_the_table_has_a_row_per_coupler_in_the_units_of_its_heads(scenario: Scenario, run: RecordedRun) -> None:
    extremes = run.session.extremes()
    table: Mapping[str, Any] = peak_table(scenario.consist, extremes)
    assert {len(column) for column in table.values()} == {21}
    assert table["coupler"][0] == "coupler_001"
    assert (table["vehicle_before"][0], table["vehicle_behind"][0]) == ("vehicle_001_SS4", "vehicle_002_C80")
    assert table["distance_from_head_m"][:2] == pytest.approx([32.83, 44.83])
    assert table["position"][10] == 0.5
    np.testing.assert_allclose(table["max_compression_kN"], extremes.compression / 1000)
    np.testing.assert_allclose(table["max_tension_kN"], extremes.tension / 1000)
    np.testing.assert_allclose(table["max_force_kN"], np.maximum(extremes.compression, extremes.tension) / 1000)
    np.testing.assert_allclose(table["max_compression_stroke_mm"], extremes.compression_stroke * 1000)
    np.testing.assert_allclose(table["max_tension_stroke_mm"], extremes.tension_stroke * 1000)
    np.testing.assert_array_equal(table["max_tension_time_s"], extremes.tension_time)
    assert not any(table["bottomed"])


def test_csv_gives_the_table_back_to_nine_digits(scenario: Scenario, run: RecordedRun, tmp_path: Path) -> None:
    table: Mapping[str, Any] = peak_table(scenario.consist, run.session.extremes())
    write_csv(table, tmp_path / "peaks.csv")
    with (tmp_path / "peaks.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == list(table)
    assert [row["coupler"] for row in rows] == table["coupler"]
    np.testing.assert_allclose([float(row["max_force_kN"]) for row in rows], table["max_force_kN"], rtol=1e-8)


@pytest.mark.skipif(not parquet_available(), reason="needs pyarrow")
def test_parquet_gives_the_table_back_exactly(scenario: Scenario, run: RecordedRun, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    table: Mapping[str, Any] = peak_table(scenario.consist, run.session.extremes())
    write_parquet(table, tmp_path / "peaks.parquet")
    assert parquet.read_table(tmp_path / "peaks.parquet").to_pydict() == table
