from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from haul_ros.errors import RecordingError
from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.sample import Sample
from haul_ros.model.scenario import Scenario
from haul_ros.recording.reader import Recording
from haul_ros.recording.run_file import RunFile, description_of
from haul_ros.recording.writer import McapRecorder
from tests.waiting import wait_until


def open_file(path: Path, scenario: Scenario, encoder: TelemetryEncoder, compression: str = "zstd") -> RunFile:
    description = description_of(scenario, encoder.channels, compression)
    return RunFile(path, description, scenario.document, encoder.channels)


def test_a_finished_file_has_its_name_and_no_other_file_is_left(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    file = open_file(tmp_path / "run.mcap", scenario, encoder)
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap.active"]
    size = file.finish(dropped=0)
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap"]
    assert (tmp_path / "run.mcap").stat().st_size == size


@pytest.mark.parametrize("taken", ["run.mcap", "run.mcap.active"])
def test_an_existing_file_is_refused_and_kept(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, taken: str
) -> None:
    (tmp_path / taken).write_text("precious")
    with pytest.raises(RecordingError, match=rf"{taken}: .*exists already.*expected a new name"):
        open_file(tmp_path / "run.mcap", scenario, encoder)
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {taken: "precious"}


def test_a_dangling_link_is_refused_and_kept(tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder) -> None:
    (tmp_path / "run.mcap").symlink_to(tmp_path / "nowhere")
    with pytest.raises(RecordingError, match="exists already"):
        open_file(tmp_path / "run.mcap", scenario, encoder)


def test_a_missing_folder_is_refused(tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder) -> None:
    with pytest.raises(RecordingError, match=r"run\.mcap: folder .*missing does not exist"):
        open_file(tmp_path / "missing" / "run.mcap", scenario, encoder)


def test_a_file_in_place_of_the_folder_is_refused(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(RecordingError, match=r"run\.mcap: cannot be created: Not a directory"):
        open_file(tmp_path / "file" / "run.mcap", scenario, encoder)


def test_an_unwritable_folder_is_refused(tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder) -> None:
    tmp_path.chmod(0o500)
    if os.access(tmp_path, os.W_OK):
        pytest.skip("this user may write anywhere")
    try:
        with pytest.raises(RecordingError, match=r"run\.mcap: cannot be created: Permission denied"):
            open_file(tmp_path / "run.mcap", scenario, encoder)
    finally:
        tmp_path.chmod(0o700)


def test_an_unknown_compression_is_refused_and_nothing_is_created(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    with pytest.raises(RecordingError, match="compression 'gzip': expected zstd, lz4, none"):
        open_file(tmp_path / "run.mcap", scenario, encoder, "gzip")
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("limited_file_size")
def test_a_file_that_cannot_be_begun_leaves_nothing(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    with pytest.raises(RecordingError, match=r"run\.mcap: cannot be written: File too large"):
        open_file(tmp_path / "run.mcap", replace(scenario, document="#" * 200_000), encoder)
    assert not list(tmp_path.iterdir())


def test_a_name_taken_meanwhile_is_not_overwritten(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    file = open_file(tmp_path / "run.mcap", scenario, encoder)
    (tmp_path / "run.mcap").write_text("precious")
    with pytest.raises(RecordingError, match=r"exists by now, not overwritten; recorded as .*run\.mcap\.active"):
        file.finish(dropped=0)
    assert (tmp_path / "run.mcap").read_text() == "precious"
    with Recording(tmp_path / "run.mcap.active") as recording:
        assert recording.info().complete


@pytest.fixture
def no_hard_links(monkeypatch: pytest.MonkeyPatch) -> None:
    """A file system such as exFAT."""

    def refuse(source: Path, target: Path) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "link", refuse)


@pytest.mark.usefixtures("no_hard_links")
def test_without_hard_links_a_file_gets_its_name_too(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    open_file(tmp_path / "run.mcap", scenario, encoder).finish(dropped=0)
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap"]
    with Recording(tmp_path / "run.mcap") as recording:
        assert recording.info().messages == 0


@pytest.mark.usefixtures("no_hard_links")
def test_without_hard_links_a_name_taken_meanwhile_is_not_overwritten_either(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    file = open_file(tmp_path / "run.mcap", scenario, encoder)
    (tmp_path / "run.mcap").write_text("precious")
    with pytest.raises(RecordingError, match="not overwritten"):
        file.finish(dropped=0)
    assert (tmp_path / "run.mcap").read_text() == "precious"


def remove(path: Path) -> None:
    path.unlink()


def rename(path: Path) -> None:
    path.rename(path.with_name("elsewhere"))


def replace_by_a_link(path: Path) -> None:
    path.unlink()
    target = path.with_name("target")
    target.write_text("precious")
    path.symlink_to(target)


def replace_by_a_file(path: Path) -> None:
    path.unlink()
    path.write_text("precious")


@pytest.mark.usefixtures("frequent_flushes")
@pytest.mark.parametrize("interfere", [remove, rename, replace_by_a_link, replace_by_a_file])
def test_a_file_that_loses_its_name_while_recording_is_no_success(
    tmp_path: Path,
    scenario: Scenario,
    encoder: TelemetryEncoder,
    make_sample: Callable[[int], Sample],
    interfere: Callable[[Path], None],
) -> None:
    recorder = McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels)
    recorder.put(encoder.sample(make_sample(0)), 0)
    interfere(tmp_path / "run.mcap.active")
    wait_until(lambda: recorder.status.failure is not None, "the failure, without anything more put")
    recorder.put(encoder.sample(make_sample(1)), 0)
    with pytest.raises(RecordingError, match=r"run\.mcap\.active was removed, renamed or replaced; its content is"):
        recorder.close()
    assert recorder.status.dropped == 6
    assert not (tmp_path / "run.mcap").exists()
    assert all(path.read_text() == "precious" for path in tmp_path.iterdir() if path.name != "elsewhere")


def cut_short(path: Path) -> None:
    os.truncate(path, 100)


def empty(path: Path) -> None:
    os.truncate(path, 0)


@pytest.mark.usefixtures("small_chunks", "frequent_flushes")
@pytest.mark.parametrize("interfere", [cut_short, empty])
@pytest.mark.parametrize("more", [0, 1, 500])
def test_a_file_that_is_cut_short_while_recording_is_no_success(
    tmp_path: Path,
    scenario: Scenario,
    encoder: TelemetryEncoder,
    make_sample: Callable[[int], Sample],
    interfere: Callable[[Path], None],
    more: int,
) -> None:
    """Whatever is written behind the cut: the file would be as long as ever, with a hole."""
    recorder = McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels, when_full="block")
    recorder.put(encoder.sample(make_sample(0)), 0)
    written = recorder.status.bytes
    wait_until(lambda: recorder.status.bytes > written, "the flush")
    interfere(tmp_path / "run.mcap.active")
    for step in range(more):
        recorder.put(encoder.sample(make_sample(step)), 0)
    with pytest.raises(RecordingError, match=r"run\.mcap\.active was cut short or written to by somebody else"):
        recorder.close()
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap.active"]


def test_a_file_that_somebody_else_appends_to_is_no_success(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    file = open_file(tmp_path / "run.mcap", scenario, encoder)
    file.flush()
    with (tmp_path / "run.mcap.active").open("ab") as stream:
        stream.write(bytes(100_000))
    with pytest.raises(RecordingError, match="was cut short or written to by somebody else"):
        file.finish(dropped=0)
    assert not (tmp_path / "run.mcap").exists()


def test_a_file_that_is_cut_short_is_noticed_while_nothing_is_recorded(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    file = open_file(tmp_path / "run.mcap", scenario, encoder)
    file.flush()
    cut_short(tmp_path / "run.mcap.active")
    with pytest.raises(RecordingError, match="was cut short"):
        file.flush()


@pytest.mark.usefixtures("frequent_flushes")
@pytest.mark.parametrize("interfere", [remove, rename, replace_by_a_link, replace_by_a_file])
def test_a_file_that_loses_its_name_at_last_is_no_success(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, interfere: Callable[[Path], None]
) -> None:
    file = open_file(tmp_path / "run.mcap", scenario, encoder)
    interfere(tmp_path / "run.mcap.active")
    with pytest.raises(RecordingError, match="was removed, renamed or replaced"):
        file.finish(dropped=0)
    assert not (tmp_path / "run.mcap").exists()
