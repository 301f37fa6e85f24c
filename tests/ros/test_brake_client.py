"""One command from another program."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy")

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind
from haul_ros.recording.reader import Recording
from haul_ros.ros.brake_client import publish_command
from tests.ros.live_node import TABLE, brake
from tests.waiting import WAIT

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer


def test_commands_arrive_at_the_node_in_their_order(start_node: Callable[..., LiveNode], observer: Observer) -> None:
    commands = (
        Command("slave_1", CommandKind.BRAKE, 0.4),
        Command("master", CommandKind.TRACTION, 1000.0),
        Command("master", CommandKind.EMERGENCY, 1.0),
    )
    node = start_node(record_path="run.mcap")
    for command in commands:
        publish_command(command, timeout=WAIT)
    applied = observer.watch_typed(TABLE.applied_brake["master"])
    observer.wait_until(lambda: bool(applied) and applied[-1].data == 1.0, "the emergency")
    assert node.end() == 0
    with Recording(node.folder / "run.mcap") as recording:
        assert tuple(command for _, command in recording.commands()) == commands


@pytest.mark.measured
def test_an_unknown_locomotive_is_refused_with_those_that_exist(start_node: Callable[..., LiveNode]) -> None:
    start_node(record_path="none")
    expected = "no locomotive slave_7 at node /haul, which has master, slave_1, slave_2, slave_3"
    with pytest.raises(CommandError, match=expected):
        publish_command(Command("slave_7", CommandKind.BRAKE, 0.4), timeout=WAIT)


def test_without_a_node_the_command_is_refused_after_the_time_out() -> None:
    with pytest.raises(CommandError, match="no node /haul_elsewhere found"):
        publish_command(Command("master", CommandKind.BRAKE, 0.4), prefix="/haul_elsewhere", timeout=0.2)


def test_a_node_in_a_namespace_is_reached_by_its_full_name_and_named_where_it_was_not_meant(
    start_node: Callable[..., LiveNode], observer: Observer
) -> None:
    node = start_node(record_path="run.mcap", ros_arguments=["-r", "__ns:=/train_a"])
    publish_command(brake("master", 0.5), "/train_a/haul", timeout=WAIT)
    expected = "no node /haul found; there is /train_a/haul: --node says which is meant"
    assert _refusal_once_discovered(brake("master", 0.7)) == expected
    assert node.end() == 0
    with Recording(node.folder / "run.mcap") as recording:
        assert [command for _, command in recording.commands()] == [brake("master", 0.5)]


def _refusal_once_discovered(command: Command) -> str:
    """What is said of a node that is not there, once discovery has had the time to find the other one."""
    said = ""
    for timeout in (1.0, 5.0, 20.0, WAIT):
        with pytest.raises(CommandError) as refused:
            publish_command(command, timeout=timeout)
        said = str(refused.value)
        if "found; is it running" not in said:
            break
    return said


def test_a_value_that_cannot_be_is_refused_at_once() -> None:
    with pytest.raises(CommandError, match="nan"):
        publish_command(Command("master", CommandKind.BRAKE, math.nan), timeout=math.inf)
