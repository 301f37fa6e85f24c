"""The topics of a train: names, message types and quality of service, once for publishers and recordings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Any

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

from haul_ros.model.command import CommandKind
from haul_ros.model.consist import MASTER
from haul_ros.model.fault import FaultKind

BOOL = "std_msgs/msg/Bool"
FLOAT64 = "std_msgs/msg/Float64"
INT32 = "std_msgs/msg/Int32"
STRING = "std_msgs/msg/String"
FLOAT64_ARRAY = "std_msgs/msg/Float64MultiArray"
JOINT_STATE = "sensor_msgs/msg/JointState"
LOG = "rcl_interfaces/msg/Log"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"

DEFAULT_PREFIX = "/haul"

_INFINITE = QosTime(9_223_372_036, 854_775_807)


def _reliable(depth: int, durability: QosDurability) -> Qos:
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=depth,
        reliability=QosReliability.RELIABLE,
        durability=durability,
        deadline=_INFINITE,
        lifespan=_INFINITE,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_INFINITE,
        avoid_ros_namespace_conventions=False,
    )


STREAM = _reliable(50, QosDurability.VOLATILE)
"""Samples: a subscriber may fall a second behind at 50 Hz and still gets every one."""
EVENT = _reliable(10, QosDurability.VOLATILE)
"""Commands and what is published about once a second."""
LATCHED = _reliable(1, QosDurability.TRANSIENT_LOCAL)
"""State that changes seldom: who subscribes later gets the last value at once."""


@dataclass(frozen=True, slots=True)
class Channel:
    """One topic by its full name, its message type (``package/msg/Type``) and offered quality of service.

    The values of the policies in ``qos`` are those of rmw, so ``rclpy.qos.DurabilityPolicy(qos.durability.value)``
    is the same policy. What is ``received`` the node subscribes to, and records but does not publish. A topic that is
    remapped is ``remapped_from`` another name.
    """

    topic: str
    msgtype: str
    qos: Qos
    received: bool = False
    remapped_from: str = ""

    @property
    def name(self) -> str:
        """The topic's name as the node knows it, before it is remapped."""
        return self.remapped_from or self.topic


@dataclass(frozen=True)
class ChannelTable:
    """All topics of one train; iterating gives every channel. Mappings are by locomotive name, head first.

    ``commands`` has a channel for every kind of command, ``radio`` one for every field of a link that may change, for
    slaves only, ``faults`` one for every kind of fault that the train can have, ``radio_seen`` one for each thing that
    the ends of a link make of it (`RadioSeen.what`). Brake pipe and auxiliary reservoirs are there with a pneumatic
    brake only, measured couplers only with sensors.
    """

    prefix: str
    couplers: Channel
    vehicles: Channel
    brake_cylinder_pressure: Channel
    brake_pipe_pressure: Channel | None
    auxiliary_reservoir_pressure: Channel | None
    max_compression: Channel
    max_tension: Channel
    max_compression_time: Channel
    max_tension_time: Channel
    real_time_factor: Channel
    diagnostics: Channel
    events: Channel
    measured_couplers: Channel | None
    applied_brake: Mapping[str, Channel]
    tractive_effort: Mapping[str, Channel]
    commands: Mapping[CommandKind, Mapping[str, Channel]]
    radio: Mapping[str, Mapping[str, Channel]]
    faults: Mapping[FaultKind, Channel]
    radio_seen: Mapping[str, Mapping[str, Channel]]

    @property
    def pressures(self) -> tuple[Channel, ...]:
        """Pressures of every vehicle: of the cylinders, then of pipe and reservoirs if there are any."""
        every = (self.brake_cylinder_pressure, self.brake_pipe_pressure, self.auxiliary_reservoir_pressure)
        return tuple(channel for channel in every if channel is not None)

    @property
    def samples(self) -> tuple[Channel, ...]:
        """What each sample has a message of."""
        return (self.couplers, self.vehicles, *self.pressures)

    @property
    def measured(self) -> tuple[Channel, ...]:
        """What sensors show, if there are any."""
        return () if self.measured_couplers is None else (self.measured_couplers,)

    @property
    def state(self) -> tuple[Channel, ...]:
        """What tells of the train's motion alone, so that the same run gives the same bytes."""
        return (*self.samples, *self.measured, *self.extremes)

    @property
    def extremes(self) -> tuple[Channel, ...]:
        """What the largest forces so far have a message of."""
        return (self.max_compression, self.max_tension, self.max_compression_time, self.max_tension_time)

    @property
    def remapped(self) -> dict[str, str]:
        """Topics that are remapped, by their names before."""
        return {channel.name: channel.topic for channel in self if channel.remapped_from}

    def changed(self, change: Callable[[Channel], Channel]) -> ChannelTable:
        """The same table of changed channels."""
        changes: dict[str, Any] = {f.name: _changed(getattr(self, f.name), change) for f in fields(self)}
        return replace(self, **changes)

    def resolved(self, resolve: Callable[[str], str]) -> ChannelTable:
        """The same channels on the topics to which their names are resolved.

        Raises
        ------
        ValueError
            Two of them would be on one topic, where nobody could tell them apart.
        """

        def moved(channel: Channel) -> Channel:
            topic = resolve(channel.name)
            return replace(channel, topic=topic, remapped_from="" if topic == channel.name else channel.name)

        table = self.changed(moved)
        topic, count = Counter(channel.topic for channel in table).most_common(1)[0]
        if count > 1:
            names = " and ".join(channel.name for channel in table if channel.topic == topic)
            raise ValueError(f"{names} are remapped to {topic}, expected a topic for each")
        return table

    def __iter__(self) -> Iterator[Channel]:
        yield from self.samples
        yield from self.extremes
        yield from (self.real_time_factor, self.diagnostics)
        yield self.events
        yield from self.measured
        yield from self.applied_brake.values()
        yield from self.tractive_effort.values()
        for by_locomotive in self.commands.values():
            yield from by_locomotive.values()
        for by_slave in (*self.radio.values(), *self.radio_seen.values()):
            yield from by_slave.values()
        yield from self.faults.values()


def _changed(value: object, change: Callable[[Channel], Channel]) -> object:
    """A field of a table with its channels changed."""
    if isinstance(value, Channel):
        return change(value)
    if isinstance(value, Mapping):
        return MappingProxyType({key: _changed(item, change) for key, item in value.items()})
    return value


_COMMANDS = {
    CommandKind.BRAKE: ("brake_command", FLOAT64),
    CommandKind.EMERGENCY: ("emergency_brake", BOOL),
    CommandKind.TRACTION: ("traction_command", FLOAT64),
    CommandKind.ELECTRIC_BRAKE: ("electric_brake_command", FLOAT64),
}
_RADIO = {
    "connected": ("radio_connected", BOOL),
    "delay": ("radio_delay", FLOAT64),
    "jitter": ("radio_jitter", FLOAT64),
    "loss_probability": ("radio_loss_probability", FLOAT64),
    "jitter_law": ("radio_jitter_law", STRING),
    "retries": ("radio_retries", INT32),
    "retry_interval": ("radio_retry_interval", FLOAT64),
    "duplicate_probability": ("radio_duplicate_probability", FLOAT64),
    "in_order": ("radio_in_order", BOOL),
    "fails": ("radio_fails", STRING),
    "burst_length": ("radio_burst_length", FLOAT64),
    "burst_spacing": ("radio_burst_spacing", FLOAT64),
    "burst_loss_probability": ("radio_burst_loss_probability", FLOAT64),
}
"""By the fields of a radio link that may change."""
_RADIO_SEEN = ("heard", "acknowledged")


def channel_table(
    locomotives: Sequence[str], prefix: str = DEFAULT_PREFIX, *, pneumatic: bool = False, sensors: bool = False
) -> ChannelTable:
    """The topics of a train with these commanded locomotives, private topics under ``prefix``, the node's full name.

    ``/clock`` is not among them: a recording has its own time in every message.
    """

    def private(name: str, msgtype: str, qos: Qos, *, received: bool = False) -> Channel:
        return Channel(f"{prefix}/{name}", msgtype, qos, received)

    def each(
        names: Sequence[str], name: str, msgtype: str, qos: Qos, *, received: bool = False
    ) -> Mapping[str, Channel]:
        return MappingProxyType({loco: private(f"{loco}/{name}", msgtype, qos, received=received) for loco in names})

    slaves = [name for name in locomotives if name != MASTER]
    commands = {kind: each(locomotives, *topic, EVENT, received=True) for kind, topic in _COMMANDS.items()}
    radio = {field: each(slaves, *topic, LATCHED) for field, topic in _RADIO.items()}
    faults = {
        kind: private(kind.value, FLOAT64_ARRAY if kind is FaultKind.LEAK else INT32, EVENT, received=True)
        for kind in FaultKind
        if pneumatic or not kind.of_air
    }
    return ChannelTable(
        prefix=prefix,
        couplers=private("couplers", JOINT_STATE, STREAM),
        vehicles=private("vehicles", JOINT_STATE, STREAM),
        brake_cylinder_pressure=private("brake_cylinder_pressure", FLOAT64_ARRAY, STREAM),
        brake_pipe_pressure=private("brake_pipe_pressure", FLOAT64_ARRAY, STREAM) if pneumatic else None,
        auxiliary_reservoir_pressure=(
            private("auxiliary_reservoir_pressure", FLOAT64_ARRAY, STREAM) if pneumatic else None
        ),
        max_compression=private("max_compression", JOINT_STATE, EVENT),
        max_tension=private("max_tension", JOINT_STATE, EVENT),
        max_compression_time=private("max_compression_time", FLOAT64_ARRAY, EVENT),
        max_tension_time=private("max_tension_time", FLOAT64_ARRAY, EVENT),
        real_time_factor=private("real_time_factor", FLOAT64, EVENT),
        diagnostics=Channel("/diagnostics", DIAGNOSTICS, EVENT),
        events=private("events", LOG, STREAM),
        measured_couplers=private("measured_couplers", JOINT_STATE, STREAM) if sensors else None,
        applied_brake=each(locomotives, "applied_brake", FLOAT64, LATCHED),
        tractive_effort=each(locomotives, "tractive_effort", FLOAT64, LATCHED),
        commands=MappingProxyType(commands),
        radio=MappingProxyType(radio),
        faults=MappingProxyType(faults),
        radio_seen=MappingProxyType({what: each(slaves, f"radio_{what}", BOOL, LATCHED) for what in _RADIO_SEEN}),
    )
