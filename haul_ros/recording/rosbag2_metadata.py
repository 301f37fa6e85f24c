"""What Jazzy's rosbag2 stores beside the messages, in the form of its version 9.

``rosbag2_storage/yaml.hpp`` gives the keys and their order; ``rosbag2_storage_mcap`` puts the text of
`bag_metadata` under ``serialized_metadata`` into a metadata record and `offered_qos_profiles` into each channel.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from io import StringIO

from rosbags.interfaces import Qos
from rosbags.rosbag2.metadata import dump_qos_v9
from ruamel.yaml import YAML

from haul_ros.messages.cdr import typestore
from haul_ros.messages.channels import Channel

RECORD_NAME = "rosbag2"
ROS_DISTRO = "jazzy"
NO_START_NS = 2**63 - 1
"""Starting time of a bag without messages."""


def _yaml(value: object) -> str:
    stream = StringIO()
    YAML().dump(value, stream)  # the round-trip dumper keeps the order of keys
    return stream.getvalue().strip()


def offered_qos_profiles(qos: Qos) -> str:
    """YAML list of one profile, policies in words."""
    return _yaml(dump_qos_v9([qos]))


def bag_metadata(
    file_name: str, channels: Iterable[Channel], counts: Mapping[str, int], start_ns: int, end_ns: int
) -> str:
    """YAML of the metadata of a bag that is one MCAP file, with messages per topic in ``counts``."""
    message_count = sum(counts.values())
    starting_time = {"nanoseconds_since_epoch": start_ns if message_count else NO_START_NS}
    duration = {"nanoseconds": end_ns - start_ns if message_count else 0}
    topics = [
        {
            "topic_metadata": {
                "name": channel.topic,
                "type": channel.msgtype,
                "serialization_format": "cdr",
                "offered_qos_profiles": dump_qos_v9([channel.qos]),
                "type_description_hash": typestore().hash_rihs01(channel.msgtype),
            },
            "message_count": counts.get(channel.topic, 0),
        }
        for channel in channels
    ]
    return _yaml(
        {
            "version": 9,
            "storage_identifier": "mcap",
            "duration": dict(duration),
            "starting_time": dict(starting_time),
            "message_count": message_count,
            "topics_with_message_count": topics,
            "compression_format": "",  # of whole files or messages; chunks are the storage's own affair
            "compression_mode": "",
            "relative_file_paths": [file_name],
            "files": [
                {
                    "path": file_name,
                    "starting_time": dict(starting_time),
                    "duration": dict(duration),
                    "message_count": message_count,
                }
            ],
            "custom_data": None,
            "ros_distro": ROS_DISTRO,
        }
    )
