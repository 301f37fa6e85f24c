"""Publishers and subscriptions of the channel table: serialised messages out, quality of service translated."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib import import_module
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import Qos

from haul_ros.messages.channels import Channel
from haul_ros.messages.encoder import Message


def message_class(msgtype: str) -> Any:
    """The Python class of a message type such as ``std_msgs/msg/Float64``."""
    package, _, name = msgtype.split("/")
    return getattr(import_module(f"{package}.msg"), name)


def qos_profile(qos: Qos) -> QoSProfile:
    """The same quality of service for rclpy."""
    return QoSProfile(
        history=HistoryPolicy(qos.history.value),
        depth=qos.depth,
        reliability=ReliabilityPolicy(qos.reliability.value),
        durability=DurabilityPolicy(qos.durability.value),
    )


def endpoint(channel: Channel) -> tuple[Any, str, QoSProfile]:
    """Message class, topic before it is remapped and quality of service, as ``create_publisher`` takes them."""
    return message_class(channel.msgtype), channel.name, qos_profile(channel.qos)


class Publishers:
    """One publisher per channel; ``publish`` may be called from one thread besides the executor's."""

    def __init__(self, node: Node, channels: Iterable[Channel]) -> None:
        self._context = node.context
        self._publishers = {c.topic: node.create_publisher(*endpoint(c)) for c in channels}

    def publish(self, messages: Sequence[Message]) -> None:
        """Publish the bytes as they are. After the shutdown of ROS nothing is published, and that is no error."""
        try:
            for message in messages:
                self._publishers[message.channel.topic].publish(message.data)
        except RuntimeError:  # RCLError, which rclpy does not export
            if self._context.ok():
                raise
