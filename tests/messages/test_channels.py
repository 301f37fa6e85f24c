from __future__ import annotations

import pytest
from rosbags.interfaces import QosDurability

from haul_ros.messages.cdr import typestore
from haul_ros.messages.channels import channel_table
from haul_ros.model.command import CommandKind
from haul_ros.model.fault import FaultKind
from haul_ros.model.radio import CHANGEABLE

TABLE = channel_table(["master", "slave_1", "slave_2"])
RADIO = tuple(f"radio_{name}" for name in CHANGEABLE)


def test_every_topic_of_the_contract_is_there_once() -> None:
    topics = [channel.topic for channel in TABLE]
    assert len(set(topics)) == len(topics)
    private = ["couplers", "vehicles", "brake_cylinder_pressure", "events"]
    private += ["max_compression", "max_tension", "max_compression_time", "max_tension_time", "real_time_factor"]
    for locomotive in ("master", "slave_1", "slave_2"):
        names = ("applied_brake", "tractive_effort")
        commands = ("brake_command", "emergency_brake", "traction_command", "electric_brake_command")
        private += [f"{locomotive}/{name}" for name in (*names, *commands)]
    for slave in ("slave_1", "slave_2"):
        private += [f"{slave}/{name}" for name in (*RADIO, "radio_heard", "radio_acknowledged")]
    assert set(topics) == {"/diagnostics", *(f"/haul/{name}" for name in [*private, "uncouple"])}


def test_faults_of_the_air_have_topics_with_a_pneumatic_brake_only() -> None:
    assert set(TABLE.faults) == {FaultKind.UNCOUPLE}
    assert set(channel_table(["master"], pneumatic=True).faults) == set(FaultKind)


def test_pipe_and_reservoirs_have_topics_with_a_pneumatic_brake_only() -> None:
    pneumatic = channel_table(["master"], pneumatic=True)
    names = [channel.topic.rsplit("/", 1)[1] for channel in pneumatic.pressures]
    assert names == ["brake_cylinder_pressure", "brake_pipe_pressure", "auxiliary_reservoir_pressure"]
    assert set(pneumatic.pressures) <= set(pneumatic)
    assert set(pneumatic.pressures) <= set(pneumatic.samples)
    faults = len(pneumatic.faults) - 1  # uncoupling needs no air
    assert len(list(pneumatic)) == len(list(channel_table(["master"]))) + 2 + faults


def test_private_topics_follow_the_name_of_the_node() -> None:
    table = channel_table(["master"], "/yard/train_7")
    assert table.couplers.topic == "/yard/train_7/couplers"
    assert table.applied_brake["master"].topic == "/yard/train_7/master/applied_brake"
    assert table.diagnostics.topic == "/diagnostics"


def test_remapped_topics_keep_their_part_and_their_names() -> None:
    topics = {
        "/haul/couplers": "/fleet/couplers",
        "/diagnostics": "/fleet/diagnostics",
        "/haul/slave_1/brake_command": "/desk/brake",
        # changed places
        "/haul/max_compression": "/haul/max_tension",
        "/haul/max_tension": "/haul/max_compression",
    }
    table = TABLE.resolved(lambda name: topics.get(name, name))
    assert table.couplers.topic == "/fleet/couplers"
    assert table.commands[CommandKind.BRAKE]["slave_1"].topic == "/desk/brake"
    assert table.commands[CommandKind.BRAKE]["slave_2"] == TABLE.commands[CommandKind.BRAKE]["slave_2"]
    assert table.max_tension.topic == "/haul/max_compression"
    assert table.remapped == topics
    assert [channel.name for channel in table] == [channel.topic for channel in TABLE]
    assert TABLE.remapped == {}


def test_two_on_one_topic_are_refused() -> None:
    topics = {"/haul/master/brake_command": "/brake", "/haul/slave_1/brake_command": "/brake"}
    expected = "/haul/master/brake_command and /haul/slave_1/brake_command are remapped to /brake, expected a topic"
    with pytest.raises(ValueError, match=expected):
        TABLE.resolved(lambda name: topics.get(name, name))


def test_only_state_that_changes_seldom_is_latched() -> None:
    latched = {c.topic.rsplit("/", 1)[1] for c in TABLE if c.qos.durability is QosDurability.TRANSIENT_LOCAL}
    assert latched == {"applied_brake", "tractive_effort", "radio_heard", "radio_acknowledged", *RADIO}
    assert TABLE.couplers.qos.depth == 50


def test_commands_are_received_and_nothing_else() -> None:
    received = {c.topic.rsplit("/", 1)[1] for c in TABLE if c.received}
    assert received == {"brake_command", "emergency_brake", "traction_command", "electric_brake_command", "uncouple"}
    assert {c.topic.rsplit("/", 1)[1] for c in TABLE if not c.received}.isdisjoint(received)


def test_every_field_of_a_radio_link_that_may_change_has_a_topic() -> None:
    assert set(TABLE.radio) == set(CHANGEABLE)
    assert RADIO[:4] == ("radio_delay", "radio_jitter", "radio_loss_probability", "radio_connected")


def test_every_message_type_is_one_of_jazzy() -> None:
    assert {channel.msgtype for channel in TABLE} <= set(typestore().types)


def test_policies_are_those_of_rclpy_by_value() -> None:
    rclpy_qos = pytest.importorskip("rclpy.qos")
    for channel in TABLE:
        qos = channel.qos
        assert rclpy_qos.DurabilityPolicy(qos.durability.value).name == qos.durability.name
        assert rclpy_qos.ReliabilityPolicy(qos.reliability.value).name == qos.reliability.name
        assert rclpy_qos.HistoryPolicy(qos.history.value).name == qos.history.name
