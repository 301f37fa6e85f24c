from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from numpy.typing import NDArray

from haul_ros.analysis import tables
from haul_ros.analysis.number_tables import coupler_table
from haul_ros.analysis.numbers import numbers_of
from haul_ros.analysis.tables import Table, parquet_available, write_pieces, write_table
from haul_ros.analysis.train_layout import TrainLayout
from haul_ros.model.scenario import Scenario
from haul_ros.recording.trains import open_train

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun


def numbers(column: Sequence[object]) -> NDArray[np.float64]:
    return np.array(column, dtype=np.float64)


@pytest.fixture
def peaks(scenario: Scenario, run: RecordedRun) -> Table:
    with open_train(run.path) as source:
        numbers = numbers_of(source, scenario)
    return coupler_table(numbers.couplers, TrainLayout.of(scenario.consist))


def test_the_table_has_a_row_per_coupler_in_the_units_of_its_heads(peaks: Table, run: RecordedRun) -> None:
    extremes = run.session.extremes()
    table: dict[str, Any] = dict(peaks)
    assert {len(column) for column in table.values()} == {21}
    assert table["coupler"][0] == "coupler_001"
    assert (table["vehicle_before"][0], table["vehicle_behind"][0]) == ("vehicle_001_SS4", "vehicle_002_C80")
    assert table["distance_from_head_m"][:2] == pytest.approx([32.83, 44.83])
    assert table["position"][10] == 0.5
    np.testing.assert_allclose(numbers(table["max_compression_kN"]), extremes.compression / 1000)
    np.testing.assert_allclose(numbers(table["max_tension_kN"]), extremes.tension / 1000)
    np.testing.assert_allclose(
        numbers(table["max_force_kN"]), np.maximum(extremes.compression, extremes.tension) / 1000
    )
    np.testing.assert_allclose(numbers(table["max_compression_stroke_mm"]), extremes.compression_stroke * 1000)
    np.testing.assert_allclose(numbers(table["max_tension_stroke_mm"]), extremes.tension_stroke * 1000)
    np.testing.assert_array_equal(table["max_tension_time_s"], extremes.tension_time)
    assert not any(table["bottomed"])


def test_a_gear_that_came_to_its_end_is_told(scenario: Scenario, run: RecordedRun) -> None:
    layout = TrainLayout.of(scenario.consist)
    assert layout.full_strokes is not None
    strokes = np.maximum(run.session.extremes().compression_stroke, run.session.extremes().tension_stroke)
    layout.full_strokes[3] = strokes[3]
    with open_train(run.path) as source:
        table = coupler_table(numbers_of(source, scenario).couplers, layout)
    assert [j for j, closed in enumerate(table["bottomed"]) if closed] == [3]


def test_csv_gives_the_table_back_to_nine_digits(peaks: Table, tmp_path: Path) -> None:
    table = peaks
    write_table(table, tmp_path / "peaks")
    with (tmp_path / "peaks.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == list(table)
    assert [row["coupler"] for row in rows] == table["coupler"]
    np.testing.assert_allclose(
        numbers([float(row["max_force_kN"]) for row in rows]), numbers(table["max_force_kN"]), rtol=1e-8
    )


@pytest.mark.skipif(not parquet_available(), reason="needs pyarrow")
def test_parquet_gives_the_table_back_exactly(peaks: Table, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    table = peaks
    write_table(table, tmp_path / "peaks")
    np.testing.assert_equal(parquet.read_table(tmp_path / "peaks.parquet").to_pydict(), dict(table))  # NaN as well


def test_pieces_stand_below_one_another_under_one_head(tmp_path: Path) -> None:
    pieces: Iterator[Table] = ({"piece": [n, n], "value": [n / 3, None]} for n in range(120))
    files = write_pieces(pieces, tmp_path / "all")
    lines = files[0].read_text("utf-8").splitlines()
    assert lines[:3] == ["piece,value", "0,0", "0,"]
    assert lines[-2:] == ["119,39.6666667", "119,"]
    assert len(lines) == 241


def test_without_pyarrow_there_is_csv_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "parquet_available", lambda: False)
    assert write_table({"a": [1]}, tmp_path / "few") == [tmp_path / "few.csv"]
    assert [file.name for file in tmp_path.iterdir()] == ["few.csv"]
