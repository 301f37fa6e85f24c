"""What a small file with fitting checksums may ask for: refused within stated bounds, or read in little memory."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import pytest
from mcap.records import Message
from mcap.writer import CompressionType

from haul_ros.errors import RecordingError
from haul_ros.recording import ordered, reader
from haul_ros.recording.reader import Recording
from haul_ros.recording.recovery import recover
from tests.recorded import forge

BRAKE, EVENTS = "/haul/master/brake_command", "/haul/events"
Found = list[tuple[str, Message]]


def repeated(topic: str, count: int) -> Callable[[Found], Iterable[tuple[str, Message]]]:
    def messages(found: Found) -> Iterable[tuple[str, Message]]:
        yield from found
        sample = next(message for name, message in found if name == topic)
        for number in range(1, count):
            yield topic, replace(sample, sequence=number)

    return messages


def test_a_chunk_of_very_many_tiny_messages_is_refused(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bomb = tmp_path / "bomb.mcap"
    monkeypatch.setattr(ordered, "MOST_IN_CHUNK", 2000)
    forge(run, bomb, messages=repeated(BRAKE, 2000), compression=CompressionType.ZSTD, chunk_size=2**25)
    with Recording(bomb) as recording:
        with pytest.raises(RecordingError, match="more than 2000 records in a chunk"):
            recording.requests()
        with pytest.raises(RecordingError, match="more than 2000 records in a chunk"):
            list(recording.state_messages())
    assert "more than 2000 records in a chunk" in (recover(bomb, tmp_path / "new.mcap").damage or "")


@pytest.mark.parametrize("topic", [BRAKE, EVENTS])
def test_commands_and_events_are_bounded_in_all(
    run: Path, tmp_path: Path, topic: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reader, "MOST_ENTRIES", 50)
    for count, refused in ((50, False), (51, True)):
        forge(run, tmp_path / "bomb.mcap", messages=repeated(topic, count), chunk_size=1000)
        with Recording(tmp_path / "bomb.mcap") as recording:
            read = recording.requests if topic == BRAKE else recording.events
            if refused:
                with pytest.raises(RecordingError, match=r"more than 50 (commands|events)"):
                    read()
            else:
                assert len(read()) == count


@pytest.mark.parametrize(("name", "most"), [("MOST_WAITING", 20), ("MOST_BYTES_WAITING", 3_000)])
def test_chunks_that_overlap_in_time_fill_no_memory(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, most: int
) -> None:
    def overlapping(found: Found) -> Found:
        return [pair for n in range(10) for pair in found[n::10]]

    forge(run, tmp_path / "tangled.mcap", messages=overlapping, chunk_size=1000)
    with Recording(tmp_path / "tangled.mcap") as tangled, Recording(run) as recording:
        states = sorted((m.time_ns, m.data) for m in recording.state_messages())
        found = [(m.time_ns, m.data) for m in tangled.state_messages()]
        assert sorted(found) == states
        assert [time_ns for time_ns, _ in found] == [time_ns for time_ns, _ in states]
        monkeypatch.setattr(ordered, name, most)
        assert len(list(recording.extremes())) == 1
        with pytest.raises(RecordingError, match="too many messages of chunks that overlap in time"):
            list(tangled.state_messages())


@pytest.mark.parametrize(
    ("records", "problem"),
    [
        (b"\x05", "chunk ends within a record"),
        (struct.pack("<BQ", 5, 100) + bytes(50), "chunk ends within a record"),
        (struct.pack("<BQ", 5, 10) + bytes(10), "message without its head"),
    ],
)
def test_records_that_do_not_fit_their_chunk_are_refused(records: bytes, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        list(ordered.chunk_records(records))
