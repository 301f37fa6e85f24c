from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from haul_ros.messages.cdr import typestore
from haul_ros.messages.encoder import DiagnosticStatus, Message, TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.consist import Consist
from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import AppliedBrake, PeriodLog
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import CouplerExtremes, Sample


def decoded(message: Message) -> Any:
    return typestore().deserialize_cdr(message.data, message.channel.msgtype)


def test_a_sample_becomes_couplers_vehicles_and_pressure(
    encoder: TelemetryEncoder, consist: Consist, make_sample: Callable[[int], Sample]
) -> None:
    sample = make_sample(151)
    messages = encoder.sample(sample)
    assert [m.channel.topic for m in messages] == ["/haul/couplers", "/haul/vehicles", "/haul/brake_cylinder_pressure"]
    assert {m.time_ns for m in messages} == {3_020_000_000}
    couplers, vehicles, pressure = map(decoded, messages)
    for joints in (couplers, vehicles):
        assert (joints.header.stamp.sec, joints.header.stamp.nanosec, joints.header.frame_id) == (3, 20_000_000, "")
    assert tuple(couplers.name) == consist.coupler_names
    assert tuple(vehicles.name) == consist.vehicle_names
    np.testing.assert_array_equal(couplers.position, sample.stroke)
    np.testing.assert_array_equal(couplers.velocity, sample.stroke_rate)
    np.testing.assert_array_equal(couplers.effort, sample.coupler_force)
    np.testing.assert_array_equal(vehicles.position, sample.chainage)
    np.testing.assert_array_equal(vehicles.velocity, sample.speed)
    np.testing.assert_array_equal(vehicles.effort, sample.brake_force)
    np.testing.assert_array_equal(pressure.data, sample.cylinder_pressure)
    (dimension,) = pressure.layout.dim
    assert (dimension.label, dimension.size, dimension.stride, pressure.layout.data_offset) == ("vehicle", 5, 5, 0)


def test_a_sample_of_another_train_is_refused(encoder: TelemetryEncoder, make_sample: Callable[[int], Sample]) -> None:
    with pytest.raises(ValueError, match=r"shape \(7,\), expected \(4,\)"):
        encoder.sample(replace(make_sample(0), stroke=np.zeros(7)))


def test_extremes_keep_compression_positive_and_tension_negative(
    encoder: TelemetryEncoder, extremes: CouplerExtremes
) -> None:
    compression, tension, *times = map(decoded, encoder.extremes(5_000_000_000, extremes))
    np.testing.assert_array_equal(compression.effort, extremes.compression)
    np.testing.assert_array_equal(compression.position, extremes.compression_stroke)
    np.testing.assert_array_equal(tension.effort, [-3e4, -2e4, -1e4, 0.0])
    np.testing.assert_array_equal(tension.position, [-0.003, -0.002, -0.001, 0.0])
    for state in (compression, tension):  # no time where viewers show m/s
        np.testing.assert_array_equal(state.velocity, np.zeros(4))
    for message, expected in zip(times, (extremes.compression_time, extremes.tension_time), strict=True):
        np.testing.assert_array_equal(message.data, expected)
        (dimension,) = message.layout.dim
        assert (dimension.label, dimension.size) == ("coupler", 4)
    assert not np.signbit([tension.effort[-1], tension.position[-1]]).any()


@pytest.mark.parametrize(
    ("command", "topic", "data"),
    [
        (Command("master", CommandKind.BRAKE, 0.8), "/haul/master/brake_command", 0.8),
        (Command("slave_1", CommandKind.EMERGENCY, 1.0), "/haul/slave_1/emergency_brake", True),
        (Command("slave_1", CommandKind.EMERGENCY, 0.0), "/haul/slave_1/emergency_brake", False),
        (Command("master", CommandKind.TRACTION, 450e3), "/haul/master/traction_command", 450e3),
    ],
)
def test_a_command_goes_to_the_topic_on_which_it_is_given(
    encoder: TelemetryEncoder, command: Command, topic: str, data: float
) -> None:
    (message,) = encoder.entries([TimedRequest(7, command)])
    assert (message.channel.topic, message.time_ns, decoded(message).data) == (topic, 7, data)


def contents(messages: list[Message]) -> list[tuple[str, int, Any]]:
    return [(m.channel.topic, m.time_ns, decoded(m).data) for m in messages]


def test_the_applied_brake_and_the_pace_have_their_topics(encoder: TelemetryEncoder) -> None:
    messages = [*encoder.entries([AppliedBrake(1, "slave_1", 0.5)]), encoder.real_time_factor(3, 1.01)]
    assert contents(messages) == [("/haul/slave_1/applied_brake", 1, 0.5), ("/haul/real_time_factor", 3, 1.01)]


def test_a_change_of_a_link_has_a_message_for_each_field_that_it_gives(encoder: TelemetryEncoder) -> None:
    start = RadioLinkChange("slave_1", 2.5, 0.25, 0.125, False)
    assert contents(encoder.entries([TimedRequest(2, start)])) == [
        ("/haul/slave_1/radio_delay", 2, 2.5),
        ("/haul/slave_1/radio_jitter", 2, 0.25),
        ("/haul/slave_1/radio_loss_probability", 2, 0.125),
        ("/haul/slave_1/radio_connected", 2, False),
    ]
    later = [
        RadioLinkChange("slave_1", loss_probability=0.0),
        RadioLinkChange("slave_1", connected=True),
        RadioLinkChange("slave_1"),
    ]
    assert contents(encoder.entries(TimedRequest(3, change) for change in later)) == [
        ("/haul/slave_1/radio_loss_probability", 3, 0.0),
        ("/haul/slave_1/radio_connected", 3, True),
    ]


def test_a_log_becomes_its_entries_in_order_then_the_sample_then_the_extremes(
    encoder: TelemetryEncoder, make_sample: Callable[[int], Sample], extremes: CouplerExtremes
) -> None:
    entries = (
        TimedRequest(5, Command("master", CommandKind.BRAKE, 0.5)),
        AppliedBrake(5, "master", 0.5),
        EVENT,
        TimedRequest(2_000_000_000, RadioLinkChange("slave_1", jitter=1.0)),
    )
    log = PeriodLog(3_020_000_000, entries, make_sample(151), extremes)
    messages = encoder.messages(log)
    assert [(m.channel.topic.removeprefix("/haul/"), m.time_ns) for m in messages] == [
        ("master/brake_command", 5),
        ("master/applied_brake", 5),
        ("events", EVENT.time_ns),
        ("slave_1/radio_jitter", 2_000_000_000),
        ("couplers", 3_020_000_000),
        ("vehicles", 3_020_000_000),
        ("brake_cylinder_pressure", 3_020_000_000),
        ("max_compression", 3_020_000_000),
        ("max_tension", 3_020_000_000),
        ("max_compression_time", 3_020_000_000),
        ("max_tension_time", 3_020_000_000),
    ]
    assert messages == [
        *encoder.entries(entries),
        *encoder.sample(make_sample(151)),
        *encoder.extremes(3_020_000_000, extremes),
    ]
    assert encoder.messages(PeriodLog(7, (), None, extremes)) == list(encoder.extremes(7, extremes))
    assert encoder.messages(PeriodLog(7, entries)) == encoder.entries(entries)


EVENT = Event(1_500_000_001, EventKind.RADIO, "slave_1: telegram lost: brake 0.5")


def test_an_event_is_an_entry_of_a_log(encoder: TelemetryEncoder) -> None:
    (message,) = encoder.entries([EVENT])
    entry = decoded(message)
    assert (message.channel.topic, message.time_ns) == ("/haul/events", EVENT.time_ns)
    assert (entry.stamp.sec, entry.stamp.nanosec) == (1, 500_000_001)
    assert (entry.level, entry.name, entry.msg) == (entry.WARN, "haul.radio", EVENT.text)
    (stopped,) = encoder.entries([replace(EVENT, kind=EventKind.STOPPED)])
    assert decoded(stopped).level == entry.INFO


def test_the_logger_of_an_event_is_that_of_the_node(consist: Consist) -> None:
    # As rclpy names the logger of a node in a namespace
    (message,) = TelemetryEncoder(consist, "/yard/train_a/haul").entries([EVENT])
    assert decoded(message).name == "yard.train_a.haul.radio"


def test_an_event_is_read_by_rclpy(encoder: TelemetryEncoder) -> None:
    serialization = pytest.importorskip("rclpy.serialization")
    log = pytest.importorskip("rcl_interfaces.msg").Log(level=30, name="haul.radio", msg=EVENT.text)
    log.stamp.sec, log.stamp.nanosec = 1, 500_000_001
    (message,) = encoder.entries([EVENT])
    assert serialization.deserialize_message(message.data, type(log)) == log


def test_the_master_has_no_radio_link_to_itself(encoder: TelemetryEncoder) -> None:
    with pytest.raises(KeyError, match="master"):
        encoder.entries([TimedRequest(0, RadioLinkChange("master", delay=0.0))])


STATUSES = (
    DiagnosticStatus(0, "haul: loop", "on time", "daqin_1_2_1", {"step time mean": "5.2e-06 s", "overruns": "0"}),
    DiagnosticStatus(2, "haul: recorder", "Gerät voll", "", {}),
)


def test_diagnostics_carry_every_status(encoder: TelemetryEncoder) -> None:
    message = encoder.diagnostics(1_500_000_000, STATUSES)
    array = decoded(message)
    assert (message.channel.topic, array.header.stamp.sec, array.header.stamp.nanosec) == (
        "/diagnostics",
        1,
        500_000_000,
    )
    read = [
        DiagnosticStatus(s.level, s.name, s.message, s.hardware_id, {v.key: v.value for v in s.values})
        for s in array.status
    ]
    assert tuple(read) == STATUSES


def test_diagnostics_are_read_by_rclpy(encoder: TelemetryEncoder) -> None:
    serialization = pytest.importorskip("rclpy.serialization")
    msg = pytest.importorskip("diagnostic_msgs.msg")
    array = msg.DiagnosticArray()
    array.header.stamp.sec, array.header.stamp.nanosec = 1, 500_000_000
    for status in STATUSES:
        values = [msg.KeyValue(key=key, value=value) for key, value in status.values.items()]
        level = bytes([status.level])
        array.status.append(
            msg.DiagnosticStatus(
                level=level, name=status.name, message=status.message, hardware_id=status.hardware_id, values=values
            )
        )
    data = encoder.diagnostics(1_500_000_000, STATUSES).data
    assert serialization.deserialize_message(data, msg.DiagnosticArray) == array
