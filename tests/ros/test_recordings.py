"""Names of recordings."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from haul_ros.ros.recordings import recording_path

NOW = datetime(2026, 3, 4, 5, 6, 7, tzinfo=UTC)


def test_without_a_path_the_file_is_named_after_scenario_and_time() -> None:
    for again in (False, True):
        assert recording_path("", "daqin_1_2_1", NOW, again=again) == Path("daqin_1_2_1_20260304T050607Z.mcap")


def test_two_that_begin_in_one_second_have_names_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("daqin_1_2_1_20260304T050607Z.mcap.active").touch()
    for again in (False, True):
        assert recording_path("", "daqin_1_2_1", NOW, again=again) == Path("daqin_1_2_1_20260304T050607Z_2.mcap")


def test_a_given_path_is_used_as_it_is_and_none_means_no_recording() -> None:
    assert recording_path("runs/a.mcap", "daqin_1_2_1", NOW) == Path("runs/a.mcap")
    assert recording_path("none", "daqin_1_2_1", NOW) is None
    assert recording_path("none", "daqin_1_2_1", NOW, again=True) is None


def test_the_recording_after_a_reset_is_numbered_and_passes_over_files_that_exist(tmp_path: Path) -> None:
    asked = str(tmp_path / "run.mcap")
    assert recording_path(asked, "daqin_1_2_1", NOW, again=True) == tmp_path / "run_2.mcap"
    (tmp_path / "run_2.mcap").touch()
    (tmp_path / "run_3.mcap.active").touch()
    assert recording_path(asked, "daqin_1_2_1", NOW, again=True) == tmp_path / "run_4.mcap"
