from __future__ import annotations

import importlib
from itertools import cycle
from typing import Any

import numpy as np
import pytest

from haul_ros.messages.cdr import (
    CLOCK,
    ArrayCodec,
    JointStateCodec,
    decode_bool,
    decode_float64,
    encode_bool,
    encode_clock,
    encode_float64,
    typestore,
)
from haul_ros.messages.channels import BOOL, FLOAT64, FLOAT64_ARRAY, JOINT_STATE

NAMES = {
    "none": [],
    "seven of differing lengths": ["", "a", "ab", "abc", "abcd", "größe", "vehicle_007_C80"],
    "couplers of a long train": [f"coupler_{j:03d}" for j in range(1, 208)],
    "as many as the byte that marks fields": [f"vehicle_{j:03d}_SS4"[: j % 9 + 9] for j in range(253)],
    "names as long as the byte that marks fields": ["x" * 253, "y" * 253],
}
SPECIAL = np.array([np.nan, np.inf, -np.inf, -0.0, 5e-324, 1.7976931348623157e308])
TIMES_NS = [0, 1, 999_999_999, 1_000_000_000, 86_400_123_456_789]


def numbers(count: int, seed: int) -> np.ndarray:
    """Random numbers, some of them replaced by the ones that are hard to carry."""
    values = np.random.default_rng(seed).normal(scale=1e6, size=count)
    values[: len(SPECIAL)] = SPECIAL[:count]
    return values


def with_rosbags(msgtype: str, *fields: Any) -> bytes:
    store = typestore()
    return bytes(store.serialize_cdr(store.types[msgtype](*fields), msgtype, little_endian=True))


def rosbags_stamp(time_ns: int) -> Any:
    return typestore().types["builtin_interfaces/msg/Time"](*divmod(time_ns, 10**9))


def rclpy_message(msgtype: str, **fields: Any) -> Any:
    package, _, name = msgtype.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)(**fields)


def assert_same_as_rclpy(data: bytes, message: Any, msgtype: str) -> None:
    """Equal bytes but for padding: rclpy leaves rubbish between fields and a few bytes more at the end."""
    theirs = bytes(importlib.import_module("rclpy.serialization").serialize_message(message))
    assert len(data) <= len(theirs) <= len(data) + 8
    store = typestore()
    cleaned = store.serialize_cdr(store.deserialize_cdr(theirs[: len(data)], msgtype), msgtype)
    assert data == bytes(cleaned)
    assert repr(importlib.import_module("rclpy.serialization").deserialize_message(data, type(message))) == repr(
        message
    )


@pytest.fixture
def rclpy() -> None:
    """Skip where there is no ROS."""
    for name in ("rclpy.serialization", "sensor_msgs.msg", "rosgraph_msgs.msg"):
        pytest.importorskip(name)


@pytest.mark.parametrize("names", NAMES.values(), ids=NAMES.keys())
def test_a_joint_state_has_the_bytes_that_rosbags_writes_and_decodes_to_what_was_encoded(names: list[str]) -> None:
    arrays = [numbers(len(names), seed) for seed in range(3)]
    header = typestore().types["std_msgs/msg/Header"](rosbags_stamp(TIMES_NS[-1]), "")
    data = JointStateCodec(names).encode(TIMES_NS[-1], *arrays)
    assert data == with_rosbags(JOINT_STATE, header, names, *arrays)
    codec = JointStateCodec.of(data)
    assert codec.names == tuple(names)
    for decoded, array in zip(codec.decode(data), arrays, strict=True):
        assert decoded.tobytes() == array.tobytes()


def joint_state_of_rclpy(time_ns: int, names: list[str], arrays: list[np.ndarray]) -> Any:
    position, velocity, effort = (array.tolist() for array in arrays)
    message = rclpy_message(JOINT_STATE, name=names, position=position, velocity=velocity, effort=effort)
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(time_ns, 10**9)
    return message


@pytest.mark.usefixtures("rclpy")
@pytest.mark.parametrize("names", NAMES.values(), ids=NAMES.keys())
def test_a_joint_state_has_the_bytes_that_rclpy_writes(names: list[str]) -> None:
    arrays = [numbers(len(names), seed) for seed in range(3)]
    data = JointStateCodec(names).encode(12_345_678_901, *arrays)
    assert_same_as_rclpy(data, joint_state_of_rclpy(12_345_678_901, names, arrays), JOINT_STATE)


@pytest.mark.usefixtures("rclpy")
def test_whatever_the_padding_behind_its_names_a_joint_state_has_the_bytes_that_rclpy_writes() -> None:
    arrays = [numbers(1, seed) for seed in range(3)]
    for length, time_ns in zip(range(8), cycle(TIMES_NS)):
        names = ["x" * length]
        data = JointStateCodec(names).encode(time_ns, *arrays)
        assert_same_as_rclpy(data, joint_state_of_rclpy(time_ns, names, arrays), JOINT_STATE)


@pytest.mark.usefixtures("rclpy")
@pytest.mark.parametrize("without", [("velocity",), ("position", "velocity")])
@pytest.mark.parametrize("names", [["a"], ["coupler_001", "coupler_052", "xy"]])
def test_a_joint_state_without_some_arrays_has_the_bytes_that_rclpy_writes(
    names: list[str], without: tuple[str, ...]
) -> None:
    lengths = [0 if field in without else len(names) for field in ("position", "velocity", "effort")]
    arrays = [numbers(length, seed) for seed, length in enumerate(lengths)]
    codec = JointStateCodec(names, without=without)
    data = codec.encode(12_345_678_901, *arrays)
    assert_same_as_rclpy(data, joint_state_of_rclpy(12_345_678_901, names, arrays), JOINT_STATE)
    again = JointStateCodec.of(data, may_lack=("position", "velocity"))
    assert again.counts == codec.counts == tuple(lengths)
    many = again.decode_many(np.frombuffer(data * 2, np.uint8).reshape(2, -1))
    for array, one, both in zip(arrays, again.decode(data), many, strict=True):
        assert one.tobytes() == array.tobytes()
        assert both.tobytes() == array.tobytes() * 2
    with pytest.raises(ValueError, match="not the expected layout"):
        JointStateCodec.of(data).decode(data)


@pytest.mark.usefixtures("rclpy")
@pytest.mark.parametrize("count", [0, 7, 253])
def test_array_has_the_bytes_that_rclpy_writes(count: int) -> None:
    values = numbers(count, 1)
    message = rclpy_message(FLOAT64_ARRAY, data=values.tolist())
    dimension = rclpy_message("std_msgs/msg/MultiArrayDimension", label="vehicle", size=count, stride=count)
    message.layout.dim = [dimension]
    assert_same_as_rclpy(ArrayCodec("vehicle", count).encode(values), message, FLOAT64_ARRAY)


@pytest.mark.usefixtures("rclpy")
def test_single_values_have_the_bytes_that_rclpy_writes() -> None:
    for value in (0.0, 0.8, *SPECIAL.tolist()):
        assert_same_as_rclpy(encode_float64(value), rclpy_message(FLOAT64, data=value), FLOAT64)
    for flag in (True, False):
        assert_same_as_rclpy(encode_bool(flag), rclpy_message(BOOL, data=flag), BOOL)
    for time_ns in TIMES_NS:
        clock = rclpy_message(CLOCK)
        clock.clock.sec, clock.clock.nanosec = divmod(time_ns, 10**9)
        assert_same_as_rclpy(encode_clock(time_ns), clock, CLOCK)


def test_single_values_have_the_bytes_that_rosbags_writes() -> None:
    for value in (0.0, 0.8, *SPECIAL.tolist()):
        assert encode_float64(value) == with_rosbags(FLOAT64, value)
    for flag in (True, False):
        assert encode_bool(flag) == with_rosbags(BOOL, flag)
    for time_ns in TIMES_NS:
        assert encode_clock(time_ns) == with_rosbags(CLOCK, rosbags_stamp(time_ns))


def test_an_array_and_single_values_decode_to_what_was_encoded() -> None:
    values = numbers(9, 1)
    codec = ArrayCodec("vehicle", 9)
    assert codec.decode(codec.encode(values)).tobytes() == values.tobytes()
    assert decode_float64(encode_float64(0.25)) == 0.25
    assert [decode_bool(encode_bool(flag)) for flag in (True, False)] == [True, False]


def test_an_encoded_message_does_not_change_with_the_next_one() -> None:
    codec = JointStateCodec(["a"])
    first = codec.encode(1, [1.0], [2.0], [3.0])
    kept = bytes(bytearray(first))
    codec.encode(2, [4.0], [5.0], [6.0])
    assert first == kept


def test_an_array_of_another_shape_is_refused() -> None:
    right = np.zeros(2)
    for wrong in (np.zeros(1), np.zeros(3), np.zeros((2, 1)), 0.0):
        with pytest.raises(ValueError, match=r"expected \(2,\)"):
            JointStateCodec(["a", "b"]).encode(0, right, wrong, right)
        with pytest.raises(ValueError, match=r"expected \(2,\)"):
            ArrayCodec("vehicle", 2).encode(wrong)


def test_a_message_of_another_layout_is_refused() -> None:
    codec = JointStateCodec(["a", "b"])
    for names in (["a", "c"], ["a"], ["a", "b", "c"]):
        zeros = np.zeros(len(names))
        with pytest.raises(ValueError, match="expected layout"):
            codec.decode(JointStateCodec(names).encode(0, zeros, zeros, zeros))
    with pytest.raises(ValueError, match="expected layout"):
        ArrayCodec("vehicle", 2).decode(ArrayCodec("coupler", 2).encode([0.0, 0.0]))
    with pytest.raises(ValueError, match="expected layout"):
        decode_float64(encode_bool(True))
    with pytest.raises(ValueError, match="is no std_msgs/msg/Bool"):
        decode_bool(encode_float64(1.0))
