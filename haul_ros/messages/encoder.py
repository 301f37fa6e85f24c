"""The log of a run as messages, ready for a publisher and a recording alike."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from haul_ros.messages.cdr import (
    JointStateCodec,
    encode_bool,
    encode_float64,
    new_header,
    new_message,
    serialize,
)
from haul_ros.messages.channels import DEFAULT_PREFIX, DIAGNOSTICS, LOG, Channel, ChannelTable, channel_table
from haul_ros.messages.quantities import (
    COUPLER_QUANTITIES,
    EXTREME_QUANTITIES,
    MEASURED_QUANTITIES,
    PRESSURE_QUANTITY,
    TIME_QUANTITY,
    VEHICLE_QUANTITIES,
    coupler_arrays,
    extreme_arrays,
    measured_arrays,
    measured_codec,
    pressure_arrays,
    pressure_codec,
    time_codec,
    vehicle_arrays,
)
from haul_ros.messages.requests import RequestCodec
from haul_ros.messages.rounding import rounded
from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.consist import Consist
from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import AppliedBrake, Effort, LogEntry, PeriodLog, RadioSeen
from haul_ros.model.recording_plan import Rounding
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import CouplerExtremes, FloatArray, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.model.sensor import CouplerMeasurement, CouplerSensors
from haul_ros.units import NS_PER_S

_INFO, _WARN = 20, 30
_LEVELS = {
    EventKind.EMERGENCY: _WARN,
    EventKind.WAVE: _INFO,
    EventKind.BOTTOMED: _WARN,
    EventKind.SLACK: _INFO,
    EventKind.STOPPED: _INFO,
    EventKind.RADIO: _WARN,
    EventKind.VALVE: _WARN,
    EventKind.APPLICATION: _WARN,
    EventKind.OVERSPEED: _WARN,
    EventKind.FAULT: _WARN,
    EventKind.SEPARATION: _WARN,
}


class Message(NamedTuple):
    """A serialised message of a channel at a simulation time."""

    channel: Channel
    time_ns: int
    data: bytes


@dataclass(frozen=True, slots=True)
class DiagnosticStatus:
    """One entry of ``/diagnostics``; ``level`` is 0 OK, 1 warning, 2 error, 3 stale."""

    level: int
    name: str
    message: str
    hardware_id: str
    values: Mapping[str, str]


def logger_name(node: str) -> str:
    """The logger of the node of this full name, as ROS names it: ``yard.haul`` of ``/yard/haul``."""
    return node.strip("/").replace("/", ".")


class TelemetryEncoder:
    """Messages of one train. Stamps are simulation time in nanoseconds, compression is positive.

    Samples are rounded here, and nothing else is: requests, events, efforts and extremes have all their bits.
    ``prefix`` is the full name of the node; ``adapt`` changes its topics, where they are remapped.
    """

    def __init__(
        self,
        consist: Consist,
        prefix: str = DEFAULT_PREFIX,
        *,
        pneumatic: bool = False,
        rounding: Rounding | None = None,
        sensors: CouplerSensors | None = None,
        adapt: Callable[[ChannelTable], ChannelTable] = lambda table: table,
    ) -> None:
        locomotives = [locomotive.name for locomotive in consist.locomotives]
        self.channels = adapt(channel_table(locomotives, prefix, pneumatic=pneumatic, sensors=sensors is not None))
        self._rounding = rounding or Rounding()
        self._requests = RequestCodec(self.channels)
        self._couplers = JointStateCodec(consist.coupler_names)
        self._vehicles = JointStateCodec(consist.vehicle_names)
        self._pressure = pressure_codec(len(consist.vehicles))
        self.measured_names = tuple(consist.coupler_names[coupler] for coupler in sensors.couplers) if sensors else ()
        """Of the couplers with sensors."""
        self._measured = measured_codec(self.measured_names, stroke=bool(sensors and sensors.stroke))
        self._time = time_codec(len(consist.coupler_names))
        self._zeros = np.zeros(len(consist.coupler_names))
        self._logger = logger_name(prefix)

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        prefix: str = DEFAULT_PREFIX,
        adapt: Callable[[ChannelTable], ChannelTable] = lambda table: table,
    ) -> TelemetryEncoder:
        """The encoder of a scenario's train, with the topics that its brake has."""
        pneumatic = isinstance(scenario.brakes, PneumaticBrake)
        plan, sensors = scenario.recording, scenario.sensors
        return cls(scenario.consist, prefix, pneumatic=pneumatic, rounding=plan.rounding, sensors=sensors, adapt=adapt)

    @classmethod
    def like(cls, channels: ChannelTable, scenario: Scenario) -> TelemetryEncoder:
        """The encoder of a scenario's train for the topics of a table, remapped as they are there."""
        remapped = channels.remapped
        return cls.of(scenario, channels.prefix, lambda table: table.resolved(lambda name: remapped.get(name, name)))

    def messages(self, log: PeriodLog) -> list[Message]:
        """All messages of a log, in its order: entries, sample, measurement, extremes.

        Raises
        ------
        ValueError
            An array of the sample has not the length of this train.
        """
        messages = self.entries(log.entries)
        if log.sample is not None:
            messages += self.sample(log.sample)
        if log.measurement is not None:
            messages.append(self.measurement(log.measurement))
        if log.extremes is not None:
            messages += self.extremes(log.time_ns, log.extremes)
        return messages

    def entries(self, entries: Iterable[LogEntry]) -> list[Message]:
        """Requests, at the simulation times at which they took effect, applied brakes and events."""
        return [message for entry in entries for message in self._entry(entry)]

    def _entry(self, entry: LogEntry) -> list[Message]:
        match entry:
            case TimedRequest(time_ns, request):
                return [Message(channel, time_ns, data) for channel, data in self._requests.encode(request)]
            case AppliedBrake(time_ns, locomotive, value):
                return [Message(self.channels.applied_brake[locomotive], time_ns, encode_float64(value))]
            case Effort(time_ns, locomotive, value):
                return [Message(self.channels.tractive_effort[locomotive], time_ns, encode_float64(value))]
            case RadioSeen(time_ns, slave, what, value):
                return [Message(self.channels.radio_seen[what][slave], time_ns, encode_bool(value))]
            case Event():
                return [self._event(entry)]

    def sample(self, sample: Sample) -> tuple[Message, ...]:
        """Couplers (stroke, stroke rate, force), vehicles (chainage, speed, brake force) and pressures, rounded.

        Raises
        ------
        ValueError
            An array of the sample has not the length of this train.
        """
        sample = rounded(sample, self._rounding)
        time_ns, channels = sample.time_ns, self.channels
        couplers = self._couplers.encode(time_ns, *coupler_arrays(sample))
        vehicles = self._vehicles.encode(time_ns, *vehicle_arrays(sample))
        return (
            Message(channels.couplers, time_ns, couplers),
            Message(channels.vehicles, time_ns, vehicles),
            *(
                Message(channel, time_ns, self._pressure.encode(pressure))
                for channel, pressure in zip(channels.pressures, pressure_arrays(sample), strict=True)
            ),
        )

    def measurement(self, measurement: CouplerMeasurement) -> Message:
        """What sensors show, beside the sample.

        Raises
        ------
        ValueError
            It is not of these sensors.
        """
        (channel,) = self.channels.measured
        time_ns = measurement.time_ns
        return Message(channel, time_ns, self._measured.encode(time_ns, *measured_arrays(measurement)))

    def decode_state(self, message: Message) -> dict[str, FloatArray]:
        """The arrays of a message of `sample`, `measurement` or `extremes` by quantity.

        Raises
        ------
        ValueError
            It is not of this train.
        """
        if message.channel in self.channels.pressures:
            return {PRESSURE_QUANTITY: self._pressure.decode(message.data)}
        if message.channel in self.channels.measured:
            return dict(zip(MEASURED_QUANTITIES, self._measured.decode(message.data), strict=True))
        if message.channel == self.channels.vehicles:
            return dict(zip(VEHICLE_QUANTITIES, self._vehicles.decode(message.data), strict=True))
        if message.channel in (self.channels.max_compression_time, self.channels.max_tension_time):
            return {TIME_QUANTITY: self._time.decode(message.data)}
        of_couplers = message.channel == self.channels.couplers
        quantities = COUPLER_QUANTITIES if of_couplers else EXTREME_QUANTITIES
        return dict(zip(quantities, self._couplers.decode(message.data), strict=True))

    def extremes(
        self, time_ns: int, extremes: CouplerExtremes, *, time_in_velocity: bool = False
    ) -> tuple[Message, ...]:
        """Largest compression and largest tension of each coupler so far; see `ExtremeArrays`.

        With ``time_in_velocity`` as older versions recorded them.
        """
        channels, both = self.channels, extreme_arrays(extremes)
        states = [
            self._couplers.encode(time_ns, found.stroke, found.time if time_in_velocity else self._zeros, found.force)
            for found in both
        ]
        times = [] if time_in_velocity else [self._time.encode(found.time) for found in both]
        return tuple(Message(c, time_ns, data) for c, data in zip(channels.extremes, [*states, *times], strict=False))

    def real_time_factor(self, time_ns: int, value: float) -> Message:
        """Simulated time per wall time."""
        return Message(self.channels.real_time_factor, time_ns, encode_float64(value))

    def _event(self, event: Event) -> Message:
        """An event as an entry of a log, its kind last in the name of the logger: ``haul.emergency``."""
        stamp = new_message("builtin_interfaces/msg/Time", *divmod(event.time_ns, NS_PER_S))
        name = f"{self._logger}.{event.kind.value}"
        entry = new_message(LOG, stamp, _LEVELS[event.kind], name, event.text, "", "", 0)
        return Message(self.channels.events, event.time_ns, serialize(entry, LOG))

    def diagnostics(self, time_ns: int, statuses: Iterable[DiagnosticStatus]) -> Message:
        """State of the program, for ``/diagnostics``."""
        entries = [
            new_message(
                "diagnostic_msgs/msg/DiagnosticStatus",
                status.level,
                status.name,
                status.message,
                status.hardware_id,
                [new_message("diagnostic_msgs/msg/KeyValue", key, value) for key, value in status.values.items()],
            )
            for status in statuses
        ]
        message = new_message(DIAGNOSTICS, new_header(*divmod(time_ns, NS_PER_S)), entries)
        return Message(self.channels.diagnostics, time_ns, serialize(message, DIAGNOSTICS))
