"""Two trains on one network, in namespaces: what they say on topics that they share is told apart."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy")

from haul_ros.messages.channels import channel_table
from haul_ros.model.command import CommandKind
from haul_ros.recording.reader import Recording
from tests.ros.live_node import LOCOMOTIVES, TABLE

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

SCENARIOS = {"/train_a/haul": "daqin_1_2_1", "/yard/train_b": "daqin_4x5000"}
PARTS = ("pacing", "solver", "radio", "commands", "recorder")


def test_statuses_and_events_of_two_trains_carry_their_names(
    start_node: Callable[..., LiveNode], observer: Observer
) -> None:
    first = start_node(record_path="a.mcap", scenario="daqin_1_2_1", ros_arguments=["-r", "__ns:=/train_a"])
    start_node(
        record_path="none", scenario="daqin_4x5000", ros_arguments=["-r", "__ns:=/yard", "-r", "__node:=train_b"]
    )
    reports = observer.watch_typed(TABLE.diagnostics)
    tables = {name: channel_table(LOCOMOTIVES, name) for name in SCENARIOS}
    events = {name: observer.watch_typed(table.events) for name, table in tables.items()}
    expected = {f"{name[1:]}: {part}": scenario for name, scenario in SCENARIOS.items() for part in PARTS}

    def told() -> dict[str, str]:
        return {status.name: status.hardware_id for report in reports for status in report.status}

    observer.wait_until(lambda: len(told()) >= len(expected), "a report of both trains")
    assert told() == expected
    for table in tables.values():
        observer.send("master", CommandKind.EMERGENCY, True, table)
    observer.wait_until(lambda: all(events.values()), "the emergency of both trains")
    # A wave of the emergency may have told something by now too
    assert events["/train_a/haul"][0].name == "train_a.haul.emergency"
    assert {entry.name.rpartition(".")[0] for entry in events["/train_a/haul"]} == {"train_a.haul"}
    assert events["/yard/train_b"][0].name == "yard.train_b.emergency"
    assert first.end() == 0
    with Recording(first.folder / "a.mcap") as recording:
        assert "emergency" in {event.kind.value for event in recording.events()}
