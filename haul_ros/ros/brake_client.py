"""One command to a running node: find it, publish, and make sure that it has arrived."""

from __future__ import annotations

import time
from collections.abc import Callable

import rclpy
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from haul_ros.errors import CommandError
from haul_ros.messages.channels import DEFAULT_PREFIX, channel_table
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.consist import MASTER
from haul_ros.ros.context import ros_client_context
from haul_ros.ros.publishers import endpoint

TIMEOUT = 10.0
"""Longest wait [s] for the node, and again for its acknowledgement."""

_SETTLING = 1.0
"""Wait [s] for more of a node's topics after the last of them has been seen."""
_POLL = 0.02
"""Longest wait [s] before what has been found is checked again."""


def publish_command(command: Command, prefix: str = DEFAULT_PREFIX, timeout: float = TIMEOUT) -> None:
    """Send a command to the node with the full name ``prefix`` and wait until the node has it.

    Raises
    ------
    CommandError
        The value is out of range, there is no such node or locomotive, or nothing was acknowledged
        within ``timeout`` [s].
    RosError
        ROS cannot be started.
    """
    command.check()
    with ros_client_context(["haul_brake"]):
        node = rclpy.create_node("haul_brake", enable_rosout=False, start_parameter_services=False)
        try:
            _publish(node, command, prefix, timeout)
        finally:
            node.destroy_node()


def _publish(node: Node, command: Command, prefix: str, timeout: float) -> None:
    channels = channel_table([command.locomotive], prefix)
    message_type, topic, qos = endpoint(channels.commands[command.kind][command.locomotive])
    message = message_type()
    message.data = command.value != 0.0 if command.kind is CommandKind.EMERGENCY else command.value
    publisher = node.create_publisher(message_type, topic, qos)
    # What is published before the node knows this publisher is lost, although acknowledged. The node
    # learns of the subscription after the publisher, so a latched message from there shows that it does.
    heard: list[object] = []
    latched_type, latched_topic, latched_qos = endpoint(channels.applied_brake[command.locomotive])
    node.create_subscription(latched_type, latched_topic, heard.append, latched_qos)
    _wait(node, lambda: bool(heard) and publisher.get_subscription_count() > 0, timeout, command.locomotive, prefix)
    publisher.publish(message)
    if not publisher.wait_for_all_acked(Duration(seconds=timeout)):
        raise CommandError(f"{topic}: command not acknowledged by the node within {timeout:g} s")


def _wait(node: Node, condition: Callable[[], bool], timeout: float, locomotive: str, prefix: str) -> None:
    """Spin until the condition holds; CommandError when time is up, or the node shows not to have the locomotive."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    began = hopeful = time.monotonic()
    before: list[str] = []
    while not condition():
        known = _locomotives(node, prefix)
        now = time.monotonic()
        if not known or locomotive in known or known != before:
            hopeful, before = now, known
        if now > began + timeout or now > hopeful + _SETTLING:
            raise CommandError(_why_in_vain(known, _trains(node), locomotive, prefix, timeout))
        executor.spin_once(timeout_sec=_POLL)


def _locomotives(node: Node, prefix: str) -> list[str]:
    """Names of the locomotives whose commands the node takes."""
    head, tail = f"{prefix}/", "/brake_command"
    return sorted(
        topic.removeprefix(head).removesuffix(tail)
        for topic, _ in node.get_topic_names_and_types()
        if topic.startswith(head) and topic.endswith(tail) and node.get_subscriptions_info_by_topic(topic)
    )


def _trains(node: Node) -> list[str]:
    """Full names of the nodes that take commands."""
    tail = f"/{MASTER}/brake_command"
    return sorted(
        topic.removesuffix(tail)
        for topic, _ in node.get_topic_names_and_types()
        if topic.endswith(tail) and node.get_subscriptions_info_by_topic(topic)
    )


def _why_in_vain(known: list[str], trains: list[str], locomotive: str, prefix: str, timeout: float) -> str:
    if not known and trains:
        return f"no node {prefix} found; there is {', '.join(trains)}: --node says which is meant"
    if not known:
        return f"no node {prefix} found; is it running, with the same ROS_DOMAIN_ID?"
    if locomotive in known:
        return f"node {prefix} is there but has not started within {timeout:g} s"
    return f"no locomotive {locomotive} at node {prefix}, which has {', '.join(known)}"
