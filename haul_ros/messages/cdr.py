"""Messages of fixed shape as CDR bytes and back, at the speed of copying them.

Names and lengths of a train's messages never change, so a message is constant bytes with a few fields between:
rosbags serialises it once, afterwards only stamp and numbers are put in. The bytes are those that rclpy writes,
save for padding, which is 0 here and undefined there.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import accumulate, chain
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from haul_ros.messages.channels import BOOL, FLOAT64, FLOAT64_ARRAY, INT32, JOINT_STATE, STRING
from haul_ros.model.sample import FloatArray
from haul_ros.units import NS_PER_S

CLOCK = "rosgraph_msgs/msg/Clock"

JOINT_ARRAYS = ("position", "velocity", "effort")
"""Of a ``sensor_msgs/JointState``."""

_STAMP = struct.Struct("<iI")
_DOUBLE = struct.Struct("<d")
_MARK = b"\xfd"
"""Stands in a template where a field goes. No UTF-8 text has this byte, and the high bytes of the lengths before
a field are 0, so the first run of marks as long as the field is the field."""


@cache
def typestore() -> Typestore:
    """Definitions, type hashes and serialisation of the message types of ROS 2 Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)


def new_message(msgtype: str, *args: Any) -> Any:
    """An object of a Jazzy message type, fields in the order of its definition."""
    return typestore().types[msgtype](*args)


def serialize(message: Any, msgtype: str) -> bytes:
    """CDR bytes of any message, little endian. Slow; for messages of changing shape."""
    return bytes(typestore().serialize_cdr(message, msgtype, little_endian=True))


def new_header(seconds: int, nanoseconds: int, frame: str = "") -> Any:
    """A ``std_msgs/Header``, without frame unless one is given."""
    return new_message("std_msgs/msg/Header", new_message("builtin_interfaces/msg/Time", seconds, nanoseconds), frame)


@dataclass(frozen=True)
class _Layout:
    """A message as constant bytes with fields of fixed sizes between: constant, field, constant, ..., constant."""

    constants: tuple[bytes, ...]
    sizes: tuple[int, ...]

    @staticmethod
    def of(template: bytes, sizes: Sequence[int]) -> _Layout:
        """Cut a message whose fields consist of marks."""
        constants, end = [], 0
        for size in sizes:
            start = template.index(_MARK * size, end)
            constants.append(template[end:start])
            end = start + size
        return _Layout((*constants, template[end:]), tuple(sizes))

    @cached_property
    def _starts(self) -> tuple[int, ...]:
        lengths = [len(constant) for constant in self.constants]
        return tuple(accumulate(chain.from_iterable(zip(lengths, (*self.sizes, 0), strict=True)), initial=0))

    def starts(self, data: bytes) -> tuple[int, ...]:
        """Where each field starts in a message of this layout.

        Raises
        ------
        ValueError
            The message is of another layout: other names, or another size.
        """
        at = self._starts
        if len(data) != at[-1] or any(
            data[at[2 * i] : at[2 * i + 1]] != constant for i, constant in enumerate(self.constants)
        ):
            raise ValueError(f"message of {len(data)} bytes has not the expected layout of {at[-1]} bytes")
        return at[1:-2:2]

    @property
    def size(self) -> int:
        """Bytes of a message."""
        return self._starts[-1]

    def fields(self, messages: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
        """Every field of messages (n, size) as a view (n, size of the field).

        Raises
        ------
        ValueError
            A message is of another layout.
        """
        at = self._starts
        if messages.shape[1] != self.size or any(
            (messages[:, at[2 * i] : at[2 * i + 1]] != np.frombuffer(constant, np.uint8)).any()
            for i, constant in enumerate(self.constants)
        ):
            raise ValueError(f"message has not the expected layout of {self.size} bytes")
        return [messages[:, at[i] : at[i + 1]] for i in range(1, len(at) - 2, 2)]


def _marked_stamp() -> tuple[int, int]:
    return _STAMP.unpack(_MARK * _STAMP.size)


def _marked_doubles(count: int) -> FloatArray:
    return np.frombuffer(_MARK * (8 * count), "<f8")


def _stamp(time_ns: int) -> bytes:
    return _STAMP.pack(*divmod(time_ns, NS_PER_S))


def _doubles(values: ArrayLike, count: int) -> bytes:
    array: NDArray[Any] = np.asarray(values, "<f8")
    if array.shape != (count,):
        raise ValueError(f"array of shape {array.shape}, expected ({count},)")
    return array.tobytes()


class JointStateCodec:
    """``sensor_msgs/JointState`` with fixed names and an empty ``frame_id``; all arrays (n,) float64.

    Those of position and velocity are empty (0,) where a message does ``without`` them.
    """

    def __init__(self, names: Sequence[str], *, without: Collection[str] = ()) -> None:
        self.names = tuple(names)
        self.count = len(self.names)
        self.counts = tuple(0 if field in without else self.count for field in JOINT_ARRAYS)
        """Lengths of the arrays of a message."""
        marked = (_marked_doubles(count) for count in self.counts)
        message = new_message(JOINT_STATE, new_header(*_marked_stamp()), list(self.names), *marked)
        sizes = (_STAMP.size, *(8 * count for count in self.counts))
        self._layout = _Layout.of(serialize(message, JOINT_STATE), sizes)

    @classmethod
    def of(cls, data: bytes, *, may_lack: Collection[str] = ()) -> JointStateCodec:
        """The codec for messages like this one, which may lack some of its arrays."""
        message: Any = typestore().deserialize_cdr(data, JOINT_STATE)
        return cls(message.name, without=[field for field in may_lack if not len(getattr(message, field))])

    def encode(self, time_ns: int, position: ArrayLike, velocity: ArrayLike, effort: ArrayLike) -> bytes:
        """CDR bytes with the stamp ``time_ns``.

        Raises
        ------
        ValueError
            An array is not of shape (n,), or (0,) where there is none.
        """
        positions, velocities, efforts = self.counts
        head, names, before_velocity, before_effort, tail = self._layout.constants
        return b"".join(
            (
                head,
                _stamp(time_ns),
                names,
                _doubles(position, positions),
                before_velocity,
                _doubles(velocity, velocities),
                before_effort,
                _doubles(effort, efforts),
                tail,
            )
        )

    def decode(self, data: bytes) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, velocity and effort (n,) as read-only views of the message.

        Raises
        ------
        ValueError
            The message has other names or another shape.
        """
        _, *arrays = self._layout.starts(data)
        position, velocity, effort = (
            np.frombuffer(data, "<f8", count, start) if count else np.empty(0)
            for count, start in zip(self.counts, arrays, strict=True)
        )
        return position, velocity, effort

    @property
    def size(self) -> int:
        """Bytes of a message."""
        return self._layout.size

    def decode_many(self, messages: NDArray[np.uint8]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, velocity and effort (m, n) of messages (m, size) as views of them.

        Raises
        ------
        ValueError
            A message has other names or another shape.
        """
        _, position, velocity, effort = self._layout.fields(messages)
        return position.view("<f8"), velocity.view("<f8"), effort.view("<f8")


class ArrayCodec:
    """``std_msgs/Float64MultiArray`` of one labelled dimension of fixed size n."""

    def __init__(self, label: str, count: int) -> None:
        self.count = count
        self.counts = (count,)
        """Lengths of the arrays of a message."""
        dimension = new_message("std_msgs/msg/MultiArrayDimension", label, count, count)
        layout = new_message("std_msgs/msg/MultiArrayLayout", [dimension], 0)
        message = new_message(FLOAT64_ARRAY, layout, _marked_doubles(count))
        self._layout = _Layout.of(serialize(message, FLOAT64_ARRAY), (8 * count,))

    def encode(self, values: ArrayLike) -> bytes:
        """CDR bytes of values (n,).

        Raises
        ------
        ValueError
            The array is not of shape (n,).
        """
        head, tail = self._layout.constants
        return b"".join((head, _doubles(values, self.count), tail))

    def decode(self, data: bytes) -> FloatArray:
        """Values (n,) as a read-only view of the message.

        Raises
        ------
        ValueError
            The message has another label or size.
        """
        (start,) = self._layout.starts(data)
        return np.frombuffer(data, "<f8", self.count, start)

    @property
    def size(self) -> int:
        """Bytes of a message."""
        return self._layout.size

    def decode_many(self, messages: NDArray[np.uint8]) -> tuple[FloatArray]:
        """Values (m, n) of messages (m, size) as a view of them, the only item.

        Raises
        ------
        ValueError
            A message has another label or size.
        """
        (values,) = self._layout.fields(messages)
        return (values.view("<f8"),)


@cache
def _float64_layout() -> _Layout:
    return _Layout.of(serialize(new_message(FLOAT64, float(_marked_doubles(1)[0])), FLOAT64), (_DOUBLE.size,))


@cache
def _bool_message(value: bool) -> bytes:
    return serialize(new_message(BOOL, value), BOOL)


@cache
def _clock_layout() -> _Layout:
    message = new_message(CLOCK, new_message("builtin_interfaces/msg/Time", *_marked_stamp()))
    return _Layout.of(serialize(message, CLOCK), (_STAMP.size,))


class Float64Codec:
    """``std_msgs/Float64``, for many at once."""

    counts = (1,)
    """Lengths of the arrays of a message."""

    @property
    def size(self) -> int:
        """Bytes of a message."""
        return _float64_layout().size

    def decode_many(self, messages: NDArray[np.uint8]) -> tuple[FloatArray]:
        """Values (m, 1) of messages (m, size) as a view of them, the only item.

        Raises
        ------
        ValueError
            A message is no Float64.
        """
        (values,) = _float64_layout().fields(messages)
        return (values.view("<f8"),)


def encode_float64(value: float) -> bytes:
    """CDR bytes of a ``std_msgs/Float64``."""
    head, tail = _float64_layout().constants
    return head + _DOUBLE.pack(value) + tail


def decode_float64(data: bytes) -> float:
    """Value of a ``std_msgs/Float64``; ValueError if the bytes are not one."""
    (start,) = _float64_layout().starts(data)
    value: float = _DOUBLE.unpack_from(data, start)[0]
    return value


_LONGEST_LIST = 1024
"""Bytes of a list of a few numbers, its layout included."""


def encode_float64s(values: Sequence[float]) -> bytes:
    """CDR bytes of a ``std_msgs/Float64MultiArray`` without layout."""
    layout = new_message("std_msgs/msg/MultiArrayLayout", [], 0)
    return serialize(new_message(FLOAT64_ARRAY, layout, np.array(values, dtype=np.float64)), FLOAT64_ARRAY)


def decode_float64s(data: bytes) -> list[float]:
    """Values of a short ``std_msgs/Float64MultiArray``; ValueError if the bytes are not one."""
    if len(data) > _LONGEST_LIST:
        raise ValueError(f"{FLOAT64_ARRAY} of {len(data)} bytes, expected at most {_LONGEST_LIST}")
    message: Any = typestore().deserialize_cdr(data, FLOAT64_ARRAY)
    return [float(value) for value in message.data]


def encode_bool(value: bool) -> bytes:
    """CDR bytes of a ``std_msgs/Bool``."""
    return _bool_message(bool(value))


def decode_bool(data: bytes) -> bool:
    """Value of a ``std_msgs/Bool``; ValueError if the bytes are not one."""
    if data == _bool_message(True):
        return True
    if data == _bool_message(False):
        return False
    raise ValueError(f"message of {len(data)} bytes is no {BOOL}")


_INT32_HEAD, _INT32 = b"\x00\x01\x00\x00", struct.Struct("<i")


def encode_int32(value: int) -> bytes:
    """CDR bytes of a ``std_msgs/Int32``."""
    return _INT32_HEAD + _INT32.pack(value)


def decode_int32(data: bytes) -> int:
    """Value of a ``std_msgs/Int32``; ValueError if the bytes are not one."""
    if len(data) != len(_INT32_HEAD) + _INT32.size or not data.startswith(_INT32_HEAD):
        raise ValueError(f"message of {len(data)} bytes is no {INT32}")
    value: int = _INT32.unpack_from(data, len(_INT32_HEAD))[0]
    return value


def encode_string(value: str) -> bytes:
    """CDR bytes of a ``std_msgs/String``."""
    return serialize(new_message(STRING, value), STRING)


def decode_string(data: bytes) -> str:
    """Value of a ``std_msgs/String``; ValueError if the bytes are not those of `encode_string`."""
    text = bytes(data[8:-1]).decode(errors="replace")
    if encode_string(text) != data:
        raise ValueError(f"message of {len(data)} bytes is no {STRING}")
    return text


def encode_clock(time_ns: int) -> bytes:
    """CDR bytes of a ``rosgraph_msgs/Clock``."""
    head, tail = _clock_layout().constants
    return head + _stamp(time_ns) + tail
