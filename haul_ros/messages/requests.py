"""Requests as messages and back: each message is a number, two, or a word on a topic of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from haul_ros.messages.cdr import (
    decode_bool,
    decode_float64,
    decode_float64s,
    decode_int32,
    decode_string,
    encode_bool,
    encode_float64,
    encode_float64s,
    encode_int32,
    encode_string,
)
from haul_ros.messages.channels import BOOL, FLOAT64, FLOAT64_ARRAY, INT32, STRING, Channel, ChannelTable
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.fault import LARGEST_NUMBER, Fault, FaultKind
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import Request

_ENCODE: Mapping[str, Callable[[Any], bytes]] = {
    BOOL: encode_bool,
    FLOAT64: encode_float64,
    FLOAT64_ARRAY: encode_float64s,
    INT32: encode_int32,
    STRING: encode_string,
}
_DECODE: Mapping[str, Callable[[bytes], Any]] = {
    BOOL: decode_bool,
    FLOAT64: decode_float64,
    FLOAT64_ARRAY: decode_float64s,
    INT32: decode_int32,
    STRING: decode_string,
}


def fault_of(kind: FaultKind, data: int | Sequence[float]) -> Fault:
    """The fault in the field ``data`` of a message: a number, of a leak the vehicle's number and the bore [m].

    Whatever else is in it becomes a fault that `Fault.check` refuses.
    """
    number, *bore = [data] if isinstance(data, int) else [*data, *([float("nan")] * (2 - len(data)))]
    whole = len(bore) == (kind is FaultKind.LEAK) and 1 <= number <= LARGEST_NUMBER and number == int(number)
    return Fault(kind, int(number) if whole else 0, *(float(value) for value in bore[:1]))


class RequestCodec:
    """Requests in the channels of one train.

    A command is one message. A change of a radio link is one for each field that it gives, and each of them is read
    back as a change of that field alone.
    """

    def __init__(self, channels: ChannelTable) -> None:
        self._channels = channels
        self._faults = {channel.topic: (channel, kind) for kind, channel in channels.faults.items()}
        kinds: list[tuple[CommandKind | str, Mapping[str, Channel]]] = [
            *channels.commands.items(),
            *channels.radio.items(),
        ]
        self._by_topic = {c.topic: (c, what, name) for what, by_name in kinds for name, c in by_name.items()}

    @property
    def topics(self) -> list[str]:
        """All topics that hold requests."""
        return [*self._by_topic, *self._faults]

    def is_state(self, topic: str) -> bool:
        """Whether a topic shows a state that requests change: its first message is then that at the start of a run."""
        return topic in self._by_topic and not self._by_topic[topic][0].received

    def encode(self, request: Request) -> list[tuple[Channel, bytes]]:
        """Each message of a request: its channel and its CDR bytes."""
        values: list[tuple[Channel, Any]]
        if isinstance(request, Fault):
            leak = request.kind is FaultKind.LEAK
            value = [float(request.number), request.bore] if leak else request.number
            values = [(self._channels.faults[request.kind], value)]
        elif isinstance(request, Command):
            values = [(self._channels.commands[request.kind][request.locomotive], request.value)]
        else:
            radio = self._channels.radio
            values = [(radio[field][request.slave], value) for field, value in request.values().items()]
        return [(channel, _ENCODE[channel.msgtype](value)) for channel, value in values]

    def decode(self, topic: str, data: bytes) -> Request:
        """The request in a message of one of the `topics`; ValueError if the bytes are not of its type."""
        if topic in self._faults:
            channel, kind = self._faults[topic]
            return fault_of(kind, _DECODE[channel.msgtype](data))
        channel, what, name = self._by_topic[topic]
        value = _DECODE[channel.msgtype](data)
        if isinstance(what, CommandKind):
            return Command(name, what, float(value))
        fields: dict[str, Any] = {what: value}
        return RadioLinkChange(name, **fields)
