from __future__ import annotations

from ruamel.yaml import YAML

from haul_ros.messages.channels import LATCHED, channel_table
from haul_ros.recording.rosbag2_metadata import NO_START_NS, bag_metadata, offered_qos_profiles


def test_quality_of_service_is_a_list_in_words_as_rosbag2_writes_it() -> None:
    assert offered_qos_profiles(LATCHED) == (
        "- history: keep_last\n"
        "  depth: 1\n"
        "  reliability: reliable\n"
        "  durability: transient_local\n"
        "  deadline:\n"
        "    sec: 9223372036\n"
        "    nsec: 854775807\n"
        "  lifespan:\n"
        "    sec: 9223372036\n"
        "    nsec: 854775807\n"
        "  liveliness: automatic\n"
        "  liveliness_lease_duration:\n"
        "    sec: 9223372036\n"
        "    nsec: 854775807\n"
        "  avoid_ros_namespace_conventions: false"
    )


def test_an_opened_bag_has_no_messages_and_no_start() -> None:
    bag = YAML(typ="safe").load(bag_metadata("run.mcap", (), {}, 0, 0))
    assert list(bag) == [
        "version",
        "storage_identifier",
        "duration",
        "starting_time",
        "message_count",
        "topics_with_message_count",
        "compression_format",
        "compression_mode",
        "relative_file_paths",
        "files",
        "custom_data",
        "ros_distro",
    ]
    assert (bag["version"], bag["storage_identifier"], bag["ros_distro"]) == (9, "mcap", "jazzy")
    assert bag["starting_time"] == {"nanoseconds_since_epoch": NO_START_NS}
    assert bag["duration"] == {"nanoseconds": 0}
    assert (bag["message_count"], bag["topics_with_message_count"]) == (0, [])


def test_a_closed_bag_counts_messages_per_topic_and_spans_them() -> None:
    table = channel_table(["master"])
    text = bag_metadata("run.mcap", table, {"/haul/couplers": 3, "/haul/vehicles": 2}, 500, 2500)
    assert "&" not in text  # every mapping is written out: no YAML anchors
    bag = YAML(typ="safe").load(text)
    counts = {t["topic_metadata"]["name"]: t["message_count"] for t in bag["topics_with_message_count"]}
    assert counts == {channel.topic: 0 for channel in table} | {"/haul/couplers": 3, "/haul/vehicles": 2}
    span = {"starting_time": {"nanoseconds_since_epoch": 500}, "duration": {"nanoseconds": 2000}, "message_count": 5}
    assert bag["files"] == [{"path": "run.mcap", **span}]
    assert {key: bag[key] for key in span} == span
    couplers = bag["topics_with_message_count"][0]["topic_metadata"]
    assert couplers["type"] == "sensor_msgs/msg/JointState"
    assert couplers["type_description_hash"] == (
        "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
    )
    assert couplers["offered_qos_profiles"][0]["depth"] == 50
