"""Topics of a live node that are remapped as anywhere in ROS."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy")

from haul_ros.analysis.replay import replay_and_compare
from haul_ros.messages.channels import channel_table
from haul_ros.model.command import CommandKind
from haul_ros.recording.reader import Recording
from tests.ros.live_node import LOCOMOTIVES, brake

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

TOPICS = {
    "/train_a/haul/couplers": "/fleet/couplers",
    "/train_a/haul/master/brake_command": "/desk/brake",
    "/diagnostics": "/fleet/diagnostics",
}
RULES = ("__ns:=/train_a", "~/couplers:=/fleet/couplers", "~/master/brake_command:=/desk/brake")
REMAPPED = channel_table(LOCOMOTIVES, "/train_a/haul").resolved(lambda name: TOPICS.get(name, name))


def test_remapped_topics_are_published_taken_recorded_and_replayed_under_their_names(
    start_node: Callable[..., LiveNode], observer: Observer
) -> None:
    rules = [part for rule in (*RULES, "/diagnostics:=/fleet/diagnostics") for part in ("-r", rule)]
    node = start_node(record_path="run.mcap", ros_arguments=rules)
    couplers = observer.watch_on("/fleet/couplers", REMAPPED.couplers)
    reports = observer.watch_on("/fleet/diagnostics", REMAPPED.diagnostics)
    applied = observer.watch_typed(REMAPPED.applied_brake["master"])
    observer.wait_until(lambda: all((couplers, reports, applied)), "the remapped topics")
    command, latched = REMAPPED.commands[CommandKind.BRAKE]["master"], REMAPPED.applied_brake["master"]
    observer.publish_on("/desk/brake", command, 0.5, latched)
    observer.wait_until(lambda: applied[-1].data == 0.5, "the command")
    assert node.end() == 0
    with Recording(node.folder / "run.mcap") as recording:
        assert recording.channels == REMAPPED
        assert {"/fleet/couplers", "/desk/brake", "/fleet/diagnostics"} <= {t.topic for t in recording.info().topics}
        assert len(recording.couplers().time_ns) >= len(couplers)
        assert [command for _, command in recording.commands()] == [brake("master", 0.5)]
        assert replay_and_compare(recording).identical


def test_two_topics_on_one_are_refused_in_one_line(start_node: Callable[..., LiveNode]) -> None:
    node = start_node(record_path="run.mcap", ros_arguments=["-r", "~/couplers:=/x", "-r", "~/vehicles:=/x"])
    assert node.wait_for_end() == 2
    assert node.log.splitlines()[-1] == (
        "train_node: /haul/couplers and /haul/vehicles are remapped to /x, expected a topic for each: "
        "a recording could not tell them apart"
    )
    assert not list(node.folder.iterdir())
