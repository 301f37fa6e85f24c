"""Subscriptions that are read when there is time, ten times a second, and not each time that something comes.

An executor of rclpy does some work of its own for every message and every subscription; at 50 samples a second of
every topic that is more than all the rest of the page.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rclpy.node import Node

from haul_ros.messages.channels import Channel
from haul_ros.ros.publishers import endpoint

_MOST_AT_ONCE = 200
"""Messages of one topic that are taken at one time."""


class Inlet:
    """What comes on one channel; ``raw``: as bytes."""

    def __init__(self, node: Node, channel: Channel, *, raw: bool = False) -> None:
        message_type, topic, qos = endpoint(channel)
        self._node = node
        self._type, self._raw = message_type, raw
        self._subscription = node.create_subscription(message_type, topic, _nothing, qos, raw=raw)

    def take(self) -> Iterator[Any]:
        """What has come since the last time, as far as the queue has kept it."""
        handle = self._subscription.handle
        for _ in range(_MOST_AT_ONCE):
            with handle:
                taken = handle.take_message(self._type, self._raw)
            if taken is None:
                return
            yield taken[0]

    def close(self) -> None:
        """Subscribe no more."""
        self._node.destroy_subscription(self._subscription)


def _nothing(_message: Any) -> None:
    """No executor has this subscription."""
