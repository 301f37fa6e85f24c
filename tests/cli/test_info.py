from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from haul_ros.cli import info
from haul_ros.recording.reader import Recording
from tests.bags import rebagged

if TYPE_CHECKING:
    from tests.cli.conftest import Haul


@pytest.fixture
def recorded(haul: Haul) -> Haul:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--set", "max_duration_s=2", "--quiet").status == 0
    return haul


def test_info_prints_the_run_its_times_and_topics(recorded: Haul) -> None:
    outcome = recorded("info", "run.mcap")
    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.startswith("run.mcap: ")
    for text in (
        "compression zstd",
        "short: short train, emergency from 20 km/h",
        "22 vehicles, 21 couplers, master, slave_1",
        "0.000 to 2.000 s of simulation, time step 1 ms",
        "none dropped",
    ):
        assert text in outcome.out
    counts = {line.split()[0]: line.split()[1:] for line in outcome.out.splitlines() if line.startswith("  /")}
    assert counts["/haul/couplers"] == ["101", "sensor_msgs/msg/JointState"]
    assert counts["/haul/master/emergency_brake"] == ["1", "std_msgs/msg/Bool"]


def test_json_says_the_same(recorded: Haul) -> None:
    found = json.loads(recorded("info", "run.mcap", "--json").out)
    with Recording("run.mcap") as recording:
        facts = recording.info()
    assert (found["messages"], found["messages_dropped"], found["complete"]) == (facts.messages, 0, True)
    assert (found["start_ns"], found["end_ns"], found["duration_s"]) == (0, 2_000_000_000, 2.0)
    assert found["size_bytes"] == facts.size
    assert found["locomotives"] == ["master", "slave_1"]
    assert {"topic": "/haul/couplers", "type": "sensor_msgs/msg/JointState", "messages": 101} in found["topics"]


def test_a_damaged_chunk_is_told_of_with_what_lies_before_it(haul: Haul) -> None:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--quiet", "--compression", "none").status == 0
    assert "checksums          all fit" in haul("info", "run.mcap").out
    data = bytearray(Path("run.mcap").read_bytes())
    data[len(data) // 2] ^= 4
    Path("damaged.mcap").write_bytes(data)
    outcome = haul("info", "damaged.mcap")
    assert outcome.status == 2
    assert "damaged or unfinished; before its damage" in outcome.out
    assert outcome.err.count("\n") == 1


def test_what_was_not_checked_is_said(haul: Haul, monkeypatch: pytest.MonkeyPatch) -> None:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--quiet").status == 0
    monkeypatch.setattr(info, "_LONGEST_CHECK", -1.0)
    assert "those of the first 0 of " in haul("info", "run.mcap").out
    assert json.loads(haul("info", "run.mcap", "--json").out)["chunks_checked"] == 0


def test_a_bag_of_the_topics_by_another_recorder_is_told_of(recorded: Haul) -> None:
    rebagged("run.mcap", "bag.mcap", library="libmcap 1.1.0")
    outcome = recorded("info", "bag.mcap")
    assert (outcome.status, outcome.err) == (0, "")
    assert "topics of a train, recorded by libmcap 1.1.0" in outcome.out
    assert "  time               2.000 s by the clock of its recorder" in outcome.out
    counts = {line.split()[0]: line.split()[1:] for line in outcome.out.splitlines() if line.startswith("  /")}
    assert counts["/haul/couplers"] == ["101", "sensor_msgs/msg/JointState"]
    found = json.loads(recorded("info", "bag.mcap", "--json").out)
    assert (found["scenario"], found["duration_s"]) == (None, 2.0)
    assert {"topic": "/haul/couplers", "type": "sensor_msgs/msg/JointState", "messages": 101} in found["topics"]


def test_a_file_without_a_train_and_one_of_our_own_without_its_description_are_refused(recorded: Haul) -> None:
    rebagged("run.mcap", "other.mcap", library="libmcap 1.1.0", topics="/haul/master")
    rebagged("run.mcap", "own.mcap", library="haul_ros 0.1.0")
    for name in ("other.mcap", "own.mcap"):
        outcome = recorded("info", name)
        assert outcome.status == 2
        assert outcome.err == f"haul: {name}: an MCAP file, but no recording of haul_ros\n"
