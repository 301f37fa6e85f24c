"""Results whose seal fits, but that this package did not write: computed again, whatever is in them."""

from __future__ import annotations

import io
import sqlite3
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from haul_ros.scenario import load_scenario
from haul_ros.studies.case import MOST_BYTES, CaseResult, simulate
from haul_ros.studies.errors import StudyError
from haul_ros.studies.store import ResultStore, _digest

Arrays = dict[str, np.ndarray]


@pytest.fixture
def result(short: str) -> CaseResult:
    return simulate(load_scenario(short, {"max_duration_s": 0.5}))


def put(path: Path, key: str, data: bytes) -> None:
    with sqlite3.connect(path) as database:
        sealed = _digest(key, data) + data
        database.execute("INSERT OR REPLACE INTO results VALUES (?, ?, ?)", (key, "a name", sealed))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("extremes.tension", np.array(["a"] * 11)), ("extremes.tension", np.zeros(3)),
        ("extremes.tension", np.array(1.0)),
        ("geared", np.zeros(3, np.bool_)), ("geared", np.array(True)), ("geared", np.zeros(11)),
        ("locomotives", np.array([999])), ("locomotives", np.array([-1])), ("locomotives", np.array([0.5])),
        ("extremes.stroke", np.zeros(3)), ("distance", np.zeros(5)), ("extremes.bottomed_time", np.zeros(11, np.int64)),
    ],
)  # fmt: skip
def test_arrays_that_are_none_of_a_result_are_refused(
    tmp_path: Path, result: CaseResult, name: str, value: np.ndarray
) -> None:
    with np.load(io.BytesIO(result.to_bytes())) as found:
        arrays = dict(found)
    buffer = io.BytesIO()
    np.savez(buffer, **(arrays | {name: value}))
    with ResultStore(tmp_path / "results.sqlite") as store:
        put(tmp_path / "results.sqlite", "key", buffer.getvalue())
        assert "key" not in store
        assert store.refused["key"].startswith("a name: not a result")


def bomb(result: CaseResult) -> bytes:
    buffer = io.BytesIO(result.to_bytes())
    with zipfile.ZipFile(buffer, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("extremes.bomb.npy", bytes(MOST_BYTES))
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("make", "problem"),
    [(bomb, "expected at most"), (lambda _: bytes(MOST_BYTES), "damaged"), (lambda _: b"PK junk", "not a result")],
)
def test_what_is_too_large_to_be_a_result_or_none_is_refused(
    tmp_path: Path, result: CaseResult, make: Callable[[CaseResult], bytes], problem: str
) -> None:
    with ResultStore(tmp_path / "results.sqlite") as store:
        put(tmp_path / "results.sqlite", "key", make(result))
        assert "key" not in store
        assert problem in store.refused["key"]


@pytest.mark.parametrize(
    "trigger",
    [
        "BEFORE INSERT ON results BEGIN SELECT raise(ignore); END",
        "AFTER INSERT ON results BEGIN UPDATE results SET result = x'00'; END",
    ],
)
def test_a_file_that_does_not_keep_results_is_no_success(tmp_path: Path, result: CaseResult, trigger: str) -> None:
    with ResultStore(tmp_path / "results.sqlite") as store:
        with sqlite3.connect(tmp_path / "results.sqlite") as database:
            database.execute(f"CREATE TRIGGER t {trigger}")
        with pytest.raises(StudyError, match="it does not keep what is put into it"):
            store.add("key", "name", result)
