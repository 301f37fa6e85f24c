"""Requests survive as messages: what was asked is read back, field by field."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haul_ros.errors import CommandError
from haul_ros.messages.channels import channel_table
from haul_ros.messages.requests import RequestCodec, fault_of
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.fault import Fault, FaultKind
from haul_ros.model.radio import RadioLink, RadioLinkChange
from haul_ros.model.request import Request

TABLE = channel_table(["master", "slave_1", "slave_2"], pneumatic=True)
CODEC = RequestCodec(TABLE)
LOCOMOTIVES = st.sampled_from(["master", "slave_1", "slave_2"])


def decoded(request: Request) -> list[Request]:
    return [CODEC.decode(channel.topic, data) for channel, data in CODEC.encode(request)]


@given(LOCOMOTIVES, st.sampled_from([CommandKind.BRAKE, CommandKind.TRACTION]), st.floats(allow_nan=False))
def test_a_command_is_one_message(locomotive: str, kind: CommandKind, value: float) -> None:
    assert decoded(Command(locomotive, kind, value)) == [Command(locomotive, kind, value)]


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_an_emergency_is_true_or_false(value: float) -> None:
    (again,) = decoded(Command("slave_2", CommandKind.EMERGENCY, value))
    assert again == Command("slave_2", CommandKind.EMERGENCY, value)
    assert isinstance(again, Command)
    assert isinstance(again.value, float)


@given(
    *(st.none() | st.floats(0.0, limit) for limit in (3600.0, 3600.0, 1.0)),
    st.none() | st.booleans(),
)
def test_the_changes_read_back_lead_to_the_same_link(
    delay: float | None, jitter: float | None, loss: float | None, connected: bool | None
) -> None:
    change = RadioLinkChange("slave_1", delay, jitter, loss, connected)
    link = RadioLink(0.5, 0.25, 0.125)
    expected = change.applied_to(link)
    for part in decoded(change):
        assert isinstance(part, RadioLinkChange)
        assert len(part.values()) == 1
        link = part.applied_to(link)
    assert link == expected
    assert isinstance(link.connected, bool)


def test_words_and_whole_numbers_of_a_link_are_read_back_as_they_are() -> None:
    values: dict[str, Any] = {
        "jitter_law": "gamma",
        "retries": 3,
        "retry_interval": 0.25,
        "duplicate_probability": 0.125,
        "in_order": False,
        "fails": "from_slave",
        "burst_length": 2.0,
        "burst_spacing": 30.0,
        "burst_loss_probability": 0.75,
    }
    parts = decoded(RadioLinkChange("slave_2", **values))
    assert parts == [RadioLinkChange("slave_2", **{name: value}) for name, value in values.items()]
    for data in (b"", b"\x00\x01\x00\x00", b"\x00\x01\x00\x00\xff\xff\xff\xffgamma\x00"):
        for field in ("jitter_law", "retries"):
            with pytest.raises(ValueError, match="is no std_msgs/msg/"):
                CODEC.decode(TABLE.radio[field]["slave_1"].topic, data)


@given(st.sampled_from(list(FaultKind)), st.integers(1, 2000), st.floats(0.0, 0.05))
def test_a_fault_is_one_message(kind: FaultKind, number: int, bore: float) -> None:
    fault = Fault(kind, number, bore if kind is FaultKind.LEAK else 0.0)
    assert decoded(fault) == [fault]


@pytest.mark.parametrize(
    ("kind", "data"),
    [
        (FaultKind.LEAK, []),
        (FaultKind.LEAK, [3.0]),
        (FaultKind.LEAK, [3.5, 0.01]),
        (FaultKind.LEAK, [math.nan, 0.01]),
        (FaultKind.LEAK, [math.inf, 0.01]),
        (FaultKind.LEAK, [3.0, math.nan]),
        (FaultKind.LEAK, [3.0, 0.01, 1.0]),
        (FaultKind.PART_HOSE, -1),
    ],
)
def test_a_message_that_is_no_fault_becomes_one_that_is_refused(kind: FaultKind, data: Any) -> None:
    with pytest.raises(CommandError):
        fault_of(kind, data).check()


def test_links_are_state_and_commands_are_not() -> None:
    state = {topic for topic in CODEC.topics if CODEC.is_state(topic)}
    assert state == {channel.topic for by_slave in TABLE.radio.values() for channel in by_slave.values()}
    assert set(CODEC.topics) - state == {channel.topic for channel in TABLE if channel.received}


def test_bytes_of_another_type_are_refused() -> None:
    ((channel, data),) = CODEC.encode(Command("master", CommandKind.BRAKE, math.pi))
    with pytest.raises(ValueError, match="is no std_msgs/msg/Bool"):
        CODEC.decode(TABLE.commands[CommandKind.EMERGENCY]["master"].topic, data)
    assert CODEC.decode(channel.topic, data) == Command("master", CommandKind.BRAKE, math.pi)
