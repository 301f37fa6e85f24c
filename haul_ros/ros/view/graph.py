"""Which trains are on the graph, and what they are made of."""

from __future__ import annotations

import re
from dataclasses import dataclass

from rclpy.node import Node

from haul_ros.messages.channels import DEFAULT_PREFIX, channel_table
from haul_ros.model.consist import MASTER

_APPLIED = "/applied_brake"
_LOCOMOTIVE = re.compile(f"/(master|slave_[1-9][0-9]{{0,3}}){_APPLIED}")


@dataclass(frozen=True, slots=True)
class FoundTrain:
    """A node by its full name, its commanded locomotives, and whether it publishes pressures of the brake pipe."""

    name: str
    locomotives: tuple[str, ...]
    pneumatic: bool


def found_trains(node: Node) -> dict[str, FoundTrain]:
    """All nodes that publish as a train does, by name."""
    topics = [topic for topic, _ in node.get_topic_names_and_types()]
    masters = [topic for topic in topics if topic.endswith(f"/{MASTER}{_APPLIED}") and node.count_publishers(topic)]
    found = {}
    for name in sorted(filter(None, (topic.removesuffix(f"/{MASTER}{_APPLIED}") for topic in masters))):
        locomotives = [
            match[1]
            for topic in topics
            if (match := _LOCOMOTIVE.fullmatch(topic.removeprefix(name)))
            and topic.startswith(name)
            and node.count_publishers(topic)
        ]
        pipe = channel_table([MASTER], name, pneumatic=True).brake_pipe_pressure
        pneumatic = pipe is not None and node.count_publishers(pipe.topic) > 0
        found[name] = FoundTrain(name, tuple(sorted(locomotives, key=_place)), pneumatic)
    return found


def chosen_train(found: dict[str, FoundTrain], name: str | None) -> FoundTrain | None:
    """The train of that name, None: the one by default, or the first."""
    if name is not None:
        return found.get(name)
    return found.get(DEFAULT_PREFIX) or next(iter(found.values()), None)


def _place(locomotive: str) -> int:
    return 0 if locomotive == MASTER else int(locomotive.removeprefix("slave_"))
