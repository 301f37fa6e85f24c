"""Messages of any recorder collected and made arrays of: fast where they are laid out alike, one by one otherwise."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from haul_ros.messages.cdr import JOINT_ARRAYS, ArrayCodec, JointStateCodec, typestore
from haul_ros.messages.channels import FLOAT64_ARRAY, JOINT_STATE
from haul_ros.model.sample import FloatArray
from haul_ros.recording.raw_messages import RawMessage
from haul_ros.recording.series import TimeArray
from haul_ros.units import NS_PER_S

_STAMPS = {True: struct.Struct("<iI"), False: struct.Struct(">iI")}
_CDR_HEAD = 4
LARGEST_STATE = 1024 * 1024
"""Bytes of a message of couplers, vehicles or pressures; that of 2000 vehicles has some 150 000."""


def stamp_of(data: bytes) -> int:
    """Time [ns] in the header that a message begins with; ValueError: it is too short for one."""
    if len(data) < _CDR_HEAD + 8:
        raise ValueError(f"message of {len(data)} bytes has no header")
    seconds, nanoseconds = _STAMPS[bool(data[1] & 1)].unpack_from(data, _CDR_HEAD)
    return int(seconds * NS_PER_S + nanoseconds)


def joint_names(data: bytes) -> tuple[str, ...]:
    """The names in a ``sensor_msgs/JointState``."""
    message: Any = typestore().deserialize_cdr(data, JOINT_STATE)
    return tuple(message.name)


class _Batch:
    """Messages as collected."""

    def __init__(self) -> None:
        self._messages: list[RawMessage] = []
        self.size = 0
        """Bytes of the messages."""

    def __len__(self) -> int:
        return len(self._messages)

    def add(self, message: RawMessage) -> None:
        """One more; ValueError: it is too long."""
        self.size += _checked_length(message)
        self._messages.append(message)

    def _taken(self) -> list[RawMessage]:
        """Those collected, which are forgotten."""
        messages, self._messages, self.size = self._messages, [], 0
        return messages


class JointBatch(_Batch):
    """``sensor_msgs/JointState`` of these names, as collected; `take` gives and forgets them.

    An array that a message does without is NaN throughout.
    """

    def __init__(self, names: tuple[str, ...]) -> None:
        super().__init__()
        self._codec = JointStateCodec(names)

    def take(self) -> tuple[TimeArray, tuple[FloatArray, FloatArray, FloatArray]]:
        """Stamps (m,) [ns], and position, velocity and effort (m, k).

        Raises
        ------
        ValueError
            A message of other names or another shape.
        """
        messages = [message.data for message in self._taken()]
        times = np.array([stamp_of(data) for data in messages], dtype=np.int64)
        if (rows := _as_rows(messages, self._codec.size)) is not None:
            try:
                return times, self._codec.decode_many(rows)
            except ValueError:
                pass  # laid out otherwise: with a frame, or bytes between its fields
        arrays = np.array([self._one(data) for data in messages]).reshape(-1, 3, self._codec.count)
        return times, (arrays[:, 0], arrays[:, 1], arrays[:, 2])

    def _one(self, data: bytes) -> list[FloatArray]:
        message: Any = typestore().deserialize_cdr(data, JOINT_STATE)
        if tuple(message.name) != self._codec.names:
            raise ValueError(f"a message of other names ({len(message.name)}) than the first ({self._codec.count})")
        arrays = [np.asarray(getattr(message, name)) for name in JOINT_ARRAYS]
        lengths = {len(array) for array in arrays} - {0, self._codec.count}
        if lengths:
            raise ValueError(f"a message of {self._codec.count} names and {lengths.pop()} values")
        return [array if len(array) else np.full(self._codec.count, np.nan) for array in arrays]


class PressureBatch(_Batch):
    """``std_msgs/Float64MultiArray`` of ``count`` numbers, as collected; `take` gives and forgets them."""

    def __init__(self, count: int) -> None:
        super().__init__()
        self._codec = ArrayCodec("vehicle", count)

    def take(self) -> tuple[TimeArray, FloatArray]:
        """Times by the recorder's clock (m,) [ns] and values (m, count).

        Raises
        ------
        ValueError
            A message of another shape.
        """
        taken = self._taken()
        messages = [message.data for message in taken]
        times = np.array([message.log_time for message in taken], dtype=np.int64)
        if (rows := _as_rows(messages, self._codec.size)) is not None:
            try:
                return times, self._codec.decode_many(rows)[0]
            except ValueError:
                pass
        return times, np.array([self._one(data) for data in messages]).reshape(-1, self._codec.count)

    def _one(self, data: bytes) -> FloatArray:
        message: Any = typestore().deserialize_cdr(data, FLOAT64_ARRAY)
        if len(message.data) != self._codec.count:
            raise ValueError(f"a message of {len(message.data)} numbers, expected {self._codec.count}")
        return np.asarray(message.data, dtype=float)


def _checked_length(message: RawMessage) -> int:
    if len(message.data) > LARGEST_STATE:
        raise ValueError(f"{message.topic}: a message of {len(message.data)} bytes, expected at most {LARGEST_STATE}")
    return len(message.data)


def _as_rows(messages: list[bytes], size: int) -> np.ndarray[Any, np.dtype[np.uint8]] | None:
    """Messages (m, size), None: one is of another size."""
    if any(len(data) != size for data in messages):
        return None
    return np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), size)
