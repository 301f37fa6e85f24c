from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from haul_ros.analysis import tables
from haul_ros.analysis.bundle import AnalysisError, analyze, default_folder
from haul_ros.errors import HaulError

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun


def test_an_analysis_writes_its_tables_and_figures_into_a_new_folder(run: RecordedRun, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    folder = tmp_path / "results" / "short"
    result = analyze(run.path, folder)
    tables = ["peaks", "run_ins", "train", "rainflow", "brake_applications", "brake_timing", "radio_delays", "events"]
    written = [f"{table}.{suffix}" for table in tables for suffix in ("csv", "parquet")]
    assert [file.name for file in result.files] == [*written, "numbers.npz", "profile.png", "history.png"]
    assert set(folder.iterdir()) == set(result.files)
    assert all(file.stat().st_size > 0 for file in result.files)
    assert result.summary is not None
    assert result.summary.scenario == "short_train"


def test_without_pyarrow_everything_but_parquet_is_written(
    run: RecordedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tables, "parquet_available", lambda: False)
    result = analyze(run.path, tmp_path)
    assert {file.suffix for file in result.files} == {".csv", ".npz", ".png"}
    assert set(tmp_path.iterdir()) == set(result.files)


def test_an_analysis_done_again_replaces_its_files_and_leaves_others(run: RecordedRun, tmp_path: Path) -> None:
    (tmp_path / "peaks.csv").write_text("old", "utf-8")
    (tmp_path / "notes.txt").write_text("mine", "utf-8")
    analyze(run.path, tmp_path)
    assert (tmp_path / "peaks.csv").read_text("utf-8").startswith("coupler,")
    assert (tmp_path / "notes.txt").read_text("utf-8") == "mine"


def test_a_folder_that_is_a_file_is_refused(run: RecordedRun, tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    taken.write_text("", "utf-8")
    with pytest.raises(AnalysisError, match=r"taken: cannot be written: File exists"):
        analyze(run.path, taken)


def test_no_folder_is_made_for_a_recording_that_cannot_be_used(empty_recording: Path, tmp_path: Path) -> None:
    for path in (empty_recording, tmp_path / "missing.mcap"):
        with pytest.raises(HaulError, match=path.name):
            analyze(path, tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_the_default_folder_has_the_name_of_the_file_in_the_current_folder() -> None:
    assert default_folder(Path("runs/stop.mcap")) == Path("stop_analysis")


@pytest.mark.parametrize("name", ["peaks.csv", "peaks.parquet", "numbers.npz", "profile.png", "history.png"])
def test_a_link_in_the_place_of_a_result_is_not_followed(run: RecordedRun, tmp_path: Path, name: str) -> None:
    pytest.importorskip("pyarrow")
    (tmp_path / "out").mkdir()
    (tmp_path / "precious").write_text("precious")
    (tmp_path / "out" / name).symlink_to(tmp_path / "precious")
    with pytest.raises(AnalysisError, match=rf"{name}: cannot be written: is a link, expected a file or nothing"):
        analyze(run.path, tmp_path / "out")
    assert (tmp_path / "precious").read_text() == "precious"
