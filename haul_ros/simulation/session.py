"""One run of a train: commands in, samples out, in simulation time only."""

from __future__ import annotations

import heapq
import itertools
import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind, TimedCommand
from haul_ros.model.consist import MASTER, Consist
from haul_ros.model.event import Event, EventKind
from haul_ros.model.radio import RadioLink, TimedLink
from haul_ros.model.sample import CouplerExtremes, FloatArray, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.physics.energy import EnergyBalance, energy_balance
from haul_ros.physics.train_model import TrainModel, WaveKind
from haul_ros.simulation.radio import LinkStatus, Radio
from haul_ros.units import seconds_to_ns

_ROUNDING = 1e-6
"""Part of a time step by which a time may miss a step and still count as on it."""


@dataclass(frozen=True, slots=True)
class AppliedBrake:
    """A locomotive's brake changed: ``value`` 0..1 of full service, 1 in emergency."""

    time_ns: int
    locomotive: str
    value: float


@dataclass(frozen=True, slots=True)
class TakenCommand:
    """A command that was carried out, and when; ``order`` counts commands and links together as they came."""

    time_ns: int
    command: Command
    order: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class TakenLink:
    """The link to a slave as it is from a time on; ``order`` as for commands."""

    time_ns: int
    slave: str
    link: RadioLink
    order: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class SessionStatus:
    """How the steps went since the start, and the radio links by slave.

    ``fallback_steps`` did not converge whole and were divided; ``unconverged_steps`` is the number
    of smallest parts taken all the same, with at most ``worst_residual`` [N].
    """

    steps: int
    newton_iterations_mean: float
    newton_iterations_max: int
    fallback_steps: int
    unconverged_steps: int
    worst_residual: float
    radio: dict[str, LinkStatus]


@dataclass(order=True, slots=True)
class _Arrival:
    """A command on its way to the locomotive that it is to act on."""

    step: int
    time: float
    order: int
    command: Command = field(compare=False)


@dataclass(slots=True)
class _DriverBrake:
    """What a locomotive's brake valve is set to."""

    vehicle: int
    demand: float = 0.0
    emergency: bool = False


class Session:
    """A train under way.

    A command acts at the master at once and reaches every slave by radio; a command addressed to
    a slave goes to it alone, by radio too. Whatever the pace and the grouping of calls, the same
    commands at the same simulation times give the same samples, bit for bit.

    Parameters
    ----------
    scenario
        What to run.
    play_commands
        Give the scenario's own timed commands, each at the first time step not before its time.
    requests
        Commands and changes of radio links to carry out in the same way, such as recorded ones.
    """

    def __init__(
        self, scenario: Scenario, *, play_commands: bool = False, requests: Iterable[TimedCommand | TimedLink] = ()
    ) -> None:
        self.scenario = scenario
        self.steps_per_sample = round(1.0 / (scenario.sample_rate * scenario.time_step))
        self._model = TrainModel(
            scenario.consist,
            scenario.brakes,
            scenario.track,
            initial_speed=scenario.initial_speed,
            time_step=scenario.time_step,
        )
        self._radio = Radio(scenario.radio, scenario.radio_seed)
        self._brakes = {loco.name: _DriverBrake(loco.vehicle) for loco in self.consist.locomotives}
        self._order = itertools.count()
        self._arrivals: list[_Arrival] = []
        self._applied = [AppliedBrake(0, name, 0.0) for name in self._brakes]
        self._taken: list[TakenCommand] = []
        self._requested = itertools.count(1)
        self._links = [TakenLink(0, slave, link) for slave, link in scenario.radio.items()]
        self._events: list[Event] = []
        timed = [*(scenario.commands if play_commands else ()), *requests]
        self._timed = deque(sorted(timed, key=lambda entry: entry.time))

    # -- state ----------------------------------------------------------------------------------

    @property
    def consist(self) -> Consist:
        """The train."""
        return self.scenario.consist

    @property
    def step(self) -> int:
        """Time steps done."""
        return self._model.step

    @property
    def time(self) -> float:
        """Simulation time [s]."""
        return self._model.time

    @property
    def time_ns(self) -> int:
        """Simulation time in whole nanoseconds."""
        return seconds_to_ns(self.time)

    @property
    def at_standstill(self) -> bool:
        """Every vehicle stands."""
        return self._model.at_standstill

    @property
    def finished(self) -> bool:
        """The train stands held and nothing is to come, or the longest duration is over.

        A train that stands at the start is held only if it has not moved after the first period.
        """
        waiting = bool(self._timed or self._arrivals) or not self._model.brakes_settled or self.step == 0
        return (self.at_standstill and not waiting) or self.time >= self.scenario.max_duration

    @property
    def stop_time(self) -> float | None:
        """When the last vehicle came to rest [s]; None while the train moves."""
        return self._model.stop_time if self.at_standstill else None

    @property
    def travelled(self) -> float:
        """Way of the head of the train since the start [m]."""
        return float(self._model.displacement[0])

    def sample(self) -> Sample:
        """The present state."""
        return self._model.sample()

    def extremes(self) -> CouplerExtremes:
        """Largest coupler forces and strokes since the start."""
        return self._model.extremes()

    def energy(self) -> EnergyBalance:
        """Energy balance since the start."""
        return energy_balance(self._model)

    def brake_targets(self) -> FloatArray:
        """What the brake pipe last told each vehicle to reach (n_vehicles,), fractions of emergency pressure."""
        return self._model.brake_targets

    def bottomed_times(self) -> FloatArray:
        """When the draft gear of each coupler first closed fully (n_couplers,) [s]; NaN: never."""
        return self._model.bottomed_times

    def status(self) -> SessionStatus:
        """How the steps went, and the state of the radio links."""
        steps = self._model.statistics()
        return SessionStatus(
            steps=steps.steps,
            newton_iterations_mean=steps.newton_iterations / max(steps.steps, 1),
            newton_iterations_max=steps.newton_iterations_max,
            fallback_steps=steps.fallback_steps,
            unconverged_steps=steps.unconverged_steps,
            worst_residual=steps.worst_residual,
            radio=self._radio.status(),
        )

    def take_applied_brakes(self) -> list[AppliedBrake]:
        """Changes of what the locomotives apply since the last call; all zeros at the start."""
        applied, self._applied = self._applied, []
        return applied

    def take_commands(self) -> list[TakenCommand]:
        """Commands carried out since the last call, with the times at which they were given."""
        taken, self._taken = self._taken, []
        return taken

    def take_links(self) -> list[TakenLink]:
        """Radio links as changed since the last call; all of them at the start."""
        links, self._links = self._links, []
        return links

    def take_events(self) -> list[Event]:
        """Emergencies, lost telegrams and links that went down or up since the last call, exact in time."""
        events, self._events = self._events, []
        return events

    # -- radio ----------------------------------------------------------------------------------

    def radio_link(self, slave: str) -> RadioLink:
        """The radio link to a slave."""
        return self._radio.link(slave)

    def set_radio_link(self, slave: str, link: RadioLink) -> None:
        """Change a radio link; the next command goes over the new one."""
        if link.connected != self._radio.link(slave).connected:
            self._happened(self.time, EventKind.RADIO, f"{slave}: radio link {'up' if link.connected else 'down'}")
        self._radio.set_link(slave, link)
        self._links.append(TakenLink(self.time_ns, slave, link, next(self._requested)))

    # -- commands -------------------------------------------------------------------------------

    def command(self, command: Command) -> None:
        """Give a command now.

        Raises
        ------
        CommandError
            Unknown locomotive, a value out of range, more traction than the locomotive has, or the
            end of an emergency while the train moves. Nothing has changed then.
        """
        self._check(command)
        self._taken.append(TakenCommand(self.time_ns, command, next(self._requested)))
        if command.locomotive == MASTER:
            self._arrive(self.time, command)
            slaves = [name for name in self._brakes if name != MASTER]
        else:
            slaves = [command.locomotive]
        for slave in slaves:
            arrival = self._radio.send(slave, self.time)
            if arrival is None:
                told = f"telegram lost: {command.kind.value} {command.value:g}"
                self._happened(self.time, EventKind.RADIO, f"{slave}: {told}")
            else:
                self._schedule(arrival, Command(slave, command.kind, command.value))

    def _check(self, command: Command) -> None:
        brake = self._brakes.get(command.locomotive)
        if brake is None:
            known = ", ".join(self._brakes)
            raise CommandError(f"{command.locomotive}: no such locomotive, this train has {known}")
        command.check()
        if command.kind is CommandKind.TRACTION:
            most = self.consist.vehicles[brake.vehicle].max_tractive_effort
            if command.value > most:
                raise CommandError(f"{command.locomotive}: traction = {command.value} N, must be at most {most} N")
        if command.kind is CommandKind.EMERGENCY:
            if command.value not in (0.0, 1.0):
                raise CommandError(f"{command.locomotive}: emergency = {command.value}, must be 0 or 1")
            if command.value == 0.0 and brake.emergency and not self.at_standstill:
                raise CommandError(f"{command.locomotive}: an emergency application ends at standstill only")

    def _schedule(self, time: float, command: Command) -> None:
        steps = time / self.scenario.time_step
        # A wave starts within the step that holds its time; tractive effort changes between steps.
        late = command.kind is CommandKind.TRACTION
        step = math.ceil(steps - _ROUNDING) if late else math.floor(steps + _ROUNDING)
        heapq.heappush(self._arrivals, _Arrival(max(step, self.step), time, next(self._order), command))

    def _arrive(self, time: float, command: Command) -> None:
        """A command takes effect at the locomotive that it names."""
        brake = self._brakes[command.locomotive]
        if command.kind is CommandKind.TRACTION:
            free = brake.demand == 0.0 and not self._model.in_emergency(brake.vehicle) and not brake.emergency
            self._model.set_traction(brake.vehicle, command.value if free else 0.0)
        elif command.kind is CommandKind.BRAKE:
            self._set_demand(time, command.locomotive, brake, command.value)
        elif command.value == 1.0:
            self._start_emergency(time, command.locomotive, brake)
        else:
            self._end_emergency(time, command.locomotive, brake)

    def _set_demand(self, time: float, name: str, brake: _DriverBrake, demand: float) -> None:
        if brake.emergency:
            return
        level = demand * self.scenario.brakes.full_service
        # Given again, a demand acts on what the brake pipe has become at this locomotive meanwhile.
        before = brake.demand if demand != brake.demand else None
        held = self._model.brake_target(brake.vehicle)
        if (demand > before) if before is not None else (level > held):
            self._model.start_wave(time, brake.vehicle, WaveKind.SERVICE, level)
        elif before is not None or level < held:
            self._model.start_wave(time, brake.vehicle, WaveKind.RELEASE, level)
        if demand > 0.0:
            self._model.set_traction(brake.vehicle, 0.0)
        self._note(time, name, brake, demand)

    def _start_emergency(self, time: float, name: str, brake: _DriverBrake) -> None:
        if brake.emergency:
            return
        brake.emergency = True
        self._model.set_traction(brake.vehicle, 0.0)
        self._model.start_wave(time, brake.vehicle, WaveKind.EMERGENCY)
        self._note(time, name, brake, 1.0)
        self._happened(time, EventKind.EMERGENCY, f"{name}: emergency latched")

    def _end_emergency(self, time: float, name: str, brake: _DriverBrake) -> None:
        if not brake.emergency or not self.at_standstill:
            return
        brake.emergency = False
        self._note(time, name, brake, 0.0)
        self._happened(time, EventKind.EMERGENCY, f"{name}: emergency ended")
        # A brake pipe that is vented anywhere cannot be charged.
        if not any(other.emergency for other in self._brakes.values()):
            self._model.start_wave(time, brake.vehicle, WaveKind.EMERGENCY_RELEASE)

    def _note(self, time: float, name: str, brake: _DriverBrake, demand: float) -> None:
        if demand != brake.demand:
            brake.demand = demand
            self._applied.append(AppliedBrake(seconds_to_ns(time), name, demand))

    def _happened(self, time: float, kind: EventKind, text: str) -> None:
        self._events.append(Event(seconds_to_ns(time), kind, text))

    # -- running --------------------------------------------------------------------------------

    def advance(self, steps: int | None = None) -> Sample:
        """Advance by a number of time steps, one sample period by default, and return the state then.

        Releases the GIL while it computes.
        """
        end = self.step + (self.steps_per_sample if steps is None else steps)
        while self.step < end:
            self._take_due()
            self._model.advance(min(end, self._next_due_step()) - self.step)
        return self.sample()

    def _timed_step(self) -> int:
        return max(0, math.ceil(self._timed[0].time / self.scenario.time_step - _ROUNDING))

    def _take_due(self) -> None:
        while self._timed and self._timed_step() <= self.step:
            self._carry_out(self._timed.popleft())
        while self._arrivals and self._arrivals[0].step <= self.step:
            arrival = heapq.heappop(self._arrivals)
            self._arrive(max(arrival.time, self.time), arrival.command)

    def _carry_out(self, request: TimedCommand | TimedLink) -> None:
        if isinstance(request, TimedCommand):
            self.command(request.command)
        else:
            link = self.radio_link(request.slave)
            self.set_radio_link(request.slave, replace(link, delay=request.delay, connected=request.connected))

    def _next_due_step(self) -> int:
        due = [self._timed_step()] if self._timed else []
        due += [self._arrivals[0].step] if self._arrivals else []
        return min(due, default=self.step + 2**62)
