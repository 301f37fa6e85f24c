"""Quality of service that the user overrides, with the parameters that ROS has for it.

Only that of the samples, which are many: a subscriber behind a bad radio link does without some rather than wait.
Commands, events and latched state are reliable, or they are of no use.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from rosbags.interfaces import QosReliability

from haul_ros.messages.channels import Channel, ChannelTable
from haul_ros.ros.parameters import ParameterError, ParameterRow, Value

QOS_OVERRIDES = "qos_overrides."
"""Begins the names of these parameters, as rclpy has them: ``qos_overrides./haul/couplers.publisher.depth``."""
MOST_DEPTH = 1000

_RELIABILITY = {"reliable": QosReliability.RELIABLE, "best_effort": QosReliability.BEST_EFFORT}


def qos_rows(table: ChannelTable) -> dict[str, ParameterRow]:
    """The parameters of the topics whose quality of service may be overridden, by name."""
    return {row.name: row for channel in table.samples for row in _rows(channel)}


def _rows(channel: Channel) -> tuple[ParameterRow, ParameterRow]:
    name = f"{QOS_OVERRIDES}{channel.topic}.publisher"
    depth = f"samples that are kept for a subscriber of {channel.topic} that is behind"
    return (
        ParameterRow(f"{name}.depth", int, depth, channel.qos.depth, minimum=1, maximum=MOST_DEPTH),
        ParameterRow(
            f"{name}.reliability",
            str,
            f"whether what is lost on the way to a subscriber of {channel.topic} is sent again",
            channel.qos.reliability.name.lower(),
            choices=tuple(_RELIABILITY),
        ),
    )


def check_qos(given: Mapping[str, object], table: ChannelTable) -> dict[str, Value]:
    """Every one of these parameters with its value: what was given, else that of the table.

    Of topics of other nodes nothing is said: parameter files are shared.

    Raises
    ------
    ParameterError
        A policy of a topic of this node that cannot be overridden, or not to that value.
    """
    rows = qos_rows(table)
    for name in given.keys() - rows.keys():
        if channel := next((c for c in table if name.startswith(f"{QOS_OVERRIDES}{c.topic}.")), None):
            able = ", ".join(c.topic for c in table.samples)
            raise ParameterError(
                f"parameter {name}: cannot be overridden for {channel.topic}, only publisher.depth and "
                f"publisher.reliability of {able}"
            )
    defaults = {name: row.default for name, row in rows.items() if row.default is not None}
    return {name: rows[name].check(given.get(name, default)) for name, default in defaults.items()}


def with_qos(values: Mapping[str, Value], table: ChannelTable) -> ChannelTable:
    """The same channels with the quality of service of `check_qos`."""
    topics = {channel.topic for channel in table.samples}

    def overridden(channel: Channel) -> Channel:
        if channel.topic not in topics:
            return channel
        name = f"{QOS_OVERRIDES}{channel.topic}.publisher"
        reliability = _RELIABILITY[str(values[f"{name}.reliability"])]
        qos = channel.qos._replace(depth=int(values[f"{name}.depth"]), reliability=reliability)
        return replace(channel, qos=qos)

    return table.changed(overridden)
