"""What the desk of the live page refuses; what it does is tested with a node and a browser."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from rclpy.node import Node

from haul_ros.errors import CommandError
from haul_ros.ros.context import ros_client_context
from haul_ros.ros.view.desk import Desk
from haul_ros.ros.view.graph import FoundTrain, found_trains


@pytest.fixture(scope="module")
def node() -> Iterator[Node]:
    with ros_client_context(["test_desk"]):
        made = rclpy.create_node("test_desk")
        yield made
        made.destroy_node()


@pytest.fixture(scope="module")
def desk(node: Node) -> Desk:
    desk = Desk(node)
    desk.face(FoundTrain("/nobody", ("master", "slave_1"), pneumatic=False))
    return desk


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        ({}, "nothing that can be asked: None"),
        ({"do": "shut down"}, "nothing that can be asked: 'shut down'"),
        ({"do": "pause", "value": "yes"}, "nothing that can be asked: 'pause'"),
        ({"do": "command", "locomotive": "slave_9", "kind": "brake", "value": 0}, "no such command or locomotive"),
        ({"do": "command", "locomotive": ["master"], "kind": "brake", "value": 0}, "no such command or locomotive"),
        ({"do": "command", "locomotive": "master", "kind": "part_hose", "value": 3}, "no such command or locomotive"),
        ({"do": "command", "locomotive": "master", "kind": "brake", "value": "1"}, "expected a number"),
        ({"do": "command", "locomotive": "master", "kind": "brake", "value": True}, "expected a number"),
        ({"do": "command", "locomotive": "master", "kind": "brake", "value": 1.5}, r"must be 0 \(release\) to 1"),
        ({"do": "command", "locomotive": "master", "kind": "brake", "value": float("nan")}, "must be a finite number"),
        ({"do": "command", "locomotive": "master", "kind": "traction", "value": -1}, "must be 0 or more"),
        ({"do": "command", "locomotive": "master", "kind": "traction", "value": 10**400}, "beyond all bounds"),
        ({"do": "link", "slave": "master", "delay": 1}, "no such slave"),
        ({"do": "link", "slave": "slave_1/../x", "delay": 1}, "no such slave"),
        ({"do": "link", "slave": "slave_1", "delay": -1}, "delay -1 s, must be 0 to 3600 s"),
        ({"do": "link", "slave": "slave_1", "delay": float("nan")}, "delay nan s, must be 0 to 3600 s"),
        ({"do": "link", "slave": "slave_1", "delay": 1}, "the node is not there"),
        ({"do": "reset"}, "the node is not there"),
        ({"do": "command", "locomotive": "master", "kind": "emergency", "value": 1}, "the node is not there"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_words(desk: Desk, asked: dict[str, Any], why: str) -> None:
    with pytest.raises(CommandError, match=why):
        asyncio.run(desk.carry_out(asked))


def test_topics_of_others_make_no_train_and_no_locomotives(node: Node) -> None:
    from std_msgs.msg import Float64

    topics = [
        "/master/applied_brake",
        "/yard/master/applied_brake",
        "/yard/slave_x/applied_brake",
        "/yard/applied_brake",
    ]
    publishers = [node.create_publisher(Float64, topic, 1) for topic in topics]
    assert found_trains(node) == {"/yard": FoundTrain("/yard", ("master",), pneumatic=False)}
    for publisher in publishers:
        node.destroy_publisher(publisher)
