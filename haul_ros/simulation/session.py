"""One run of a train: requests in, samples and a log out, in simulation time only."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.consist import MASTER, Consist
from haul_ros.model.fault import Fault
from haul_ros.model.log import LogEntry, PeriodLog
from haul_ros.model.radio import RadioLink, RadioLinkChange
from haul_ros.model.request import Request, TimedRequest
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.model.sensor import CouplerMeasurement
from haul_ros.physics.energy import EnergyBalance, energy_balance
from haul_ros.physics.train_model import StepStatistics, TrainModel
from haul_ros.simulation.brake_valves import brake_valves
from haul_ros.simulation.events import EventDetector, TrainState
from haul_ros.simulation.exchange import Exchange
from haul_ros.simulation.faults import Faults
from haul_ros.simulation.limit_driver import driver_of
from haul_ros.simulation.locomotives import Locomotives
from haul_ros.simulation.lookout import steps_to_look
from haul_ros.simulation.overspeed import Overspeeds
from haul_ros.simulation.radio import LinkStatus
from haul_ros.simulation.sensors import SensorBench
from haul_ros.simulation.slices import Slices
from haul_ros.simulation.telegrams import ROUNDING
from haul_ros.units import NS_PER_S, seconds_to_ns

EXTREMES_PERIOD_NS = NS_PER_S
"""Simulation time between two logs with the running extremes."""

MOST_UNDER_WAY = 4096
"""Brake waves and telegrams under way at which nothing but an emergency is taken, and sent only to slaves that do not
have one coming: they take memory, and waves time in every step."""


@dataclass(frozen=True, slots=True)
class SessionStatus:
    """How the steps went since the start, and the radio links by slave."""

    solver: StepStatistics
    radio: dict[str, LinkStatus]


def _is_emergency(command: Command) -> bool:
    return command.kind is CommandKind.EMERGENCY and command.value != 0.0


class Session:
    """A train under way.

    A command acts at the master at once and reaches every slave by radio; a command addressed to
    a slave goes to it alone, by radio too. Whatever the pace and the grouping of calls, the same
    requests at the same simulation times give the same samples, bit for bit.

    Parameters
    ----------
    scenario
        What to run.
    play_commands
        Give the scenario's own timed commands, each at the first time step not before its time, and let its driver
        drive.
    requests
        Commands, changes of radio links and faults to carry out in the same way, such as recorded ones.
    play_faults
        Let the scenario's own faults happen; false where they are among the ``requests``, as recorded.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        play_commands: bool = False,
        requests: Iterable[TimedRequest] = (),
        play_faults: bool = True,
    ) -> None:
        self.scenario = scenario
        self.steps_per_sample = scenario.steps_per_sample
        self._model = TrainModel(
            scenario.consist,
            scenario.brakes,
            scenario.track,
            initial_speed=scenario.initial_speed,
            initial_stroke=scenario.initial_state.strokes(scenario.consist),
            initial_air=scenario.initial_state.air,
            time_step=scenario.time_step,
            hose_reach=scenario.faults.hose_reach,
        )
        self._entries: list[LogEntry] = [
            TimedRequest(0, RadioLinkChange.to(slave, link)) for slave, link in scenario.radio.items()
        ]
        self._locomotives = Locomotives(self._model, brake_valves(self._model, scenario), self._entries)
        self._vehicles = {locomotive.name: locomotive.vehicle for locomotive in scenario.consist.locomotives}
        self._exchange = Exchange(
            scenario,
            self._locomotives,
            self._place,
            air_between_steps=self._model.pneumatic is not None,
            log=self._entries,
        )
        planned = scenario.faults.planned if play_faults else ()
        self._faults = Faults(self._model, replace(scenario.faults, planned=planned), self._entries)
        self._events = EventDetector(scenario.consist, self._state(self.sample()), scenario.track, scenario.brakes)
        self._sensors = SensorBench(scenario)
        self._logged_step = -1
        self._extremes_due_ns = 0
        self._extremes_logged_ns = -1
        self._slices = Slices()
        own = [TimedRequest(fault.time_ns, fault.fault) for fault in planned if fault.time_ns is not None]
        own += scenario.commands if play_commands else ()
        timed = sorted([*own, *requests], key=lambda entry: entry.time_ns)
        self._driver = driver_of(scenario, self._model.initial_demand) if play_commands else None
        self._next_look = self._next_fault_look = 0
        self._timed = deque((self._first_step_at(entry.time_ns), entry.request) for entry in timed)

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
        driven = self._driver is not None and self.steps_left > 0  # may set a standing train in motion again
        coming = driven or bool(self._timed) or self._exchange.pending
        waiting = coming or not self._model.brakes_settled or self.step == 0
        return (self.at_standstill and not waiting) or self.steps_left == 0

    @property
    def steps_left(self) -> int:
        """Time steps to the end of the longest duration; 0 if it is over."""
        return max(0, math.ceil(self.scenario.max_duration / self.scenario.time_step - ROUNDING) - self.step)

    @property
    def stop_time(self) -> float | None:
        """When the last vehicle came to rest [s]; None while the train moves."""
        return self._model.stop_time if self.at_standstill else None

    @property
    def travelled(self) -> float:
        """Distance that the head of the train has travelled since the start [m]."""
        return float(self._model.displacement[0])

    def sample(self) -> Sample:
        """The present state."""
        return self._model.sample()

    def measurement(self, sample: Sample) -> CouplerMeasurement | None:
        """What the sensors of the train make of a sample; None: it has none, or they do not measure at that time."""
        return self._sensors.measure(sample)

    def extremes(self) -> CouplerExtremes:
        """Largest coupler forces and strokes since the start."""
        return self._model.extremes()

    def energy(self) -> EnergyBalance:
        """Energy balance since the start."""
        return energy_balance(self._model)

    def overspeeds(self) -> Overspeeds:
        """Speed over the limits of the line since the start, by the samples whose logs were taken."""
        return self._events.overspeed.found

    @property
    def unintended_releases(self) -> int:
        """Vehicles that have released a pneumatic brake unasked so far, by the samples whose logs were taken."""
        return int(np.count_nonzero(self._events.released))

    @property
    def unbraked(self) -> int:
        """Vehicles whose pneumatic brake is released though no locomotive charges the pipe."""
        valves = self._model.valves()
        return 0 if valves is None or valves.release_commanded else int(np.count_nonzero(~valves.applied))

    def radio_link(self, slave: str) -> RadioLink:
        """The radio link to a slave."""
        return self._exchange.link(slave)

    def _place(self, locomotive: str) -> tuple[float, float]:
        vehicle = self._vehicles[locomotive]
        return self._model.chainage(vehicle), float(self._model.speed[vehicle])

    def status(self) -> SessionStatus:
        """How the steps went, and the state of the radio links."""
        return SessionStatus(self._model.statistics(), self._exchange.status(self.time))

    # -- log ------------------------------------------------------------------------------------

    def take_log(self, *, last: bool = False) -> PeriodLog:
        """All that is new since the last call; the first has the state of all links and brakes at the start.

        With the sample if the simulation has advanced since; with the extremes at the first call in each
        `EXTREMES_PERIOD_NS`, and in the ``last`` log of a run unless this instant's are logged already.
        """
        time_ns, sample = self.time_ns, None
        if self.step != self._logged_step:
            self._logged_step = self.step
            sample = self.sample()
            self._entries += self._events.update(self._state(sample))
            self._entries += self._locomotives.changed_efforts(time_ns)
        self._entries += self._events.rest(time_ns) if last else []
        entries = tuple(sorted(self._entries, key=lambda entry: entry.time_ns))
        self._entries.clear()
        measurement = None if sample is None else self.measurement(sample)
        return PeriodLog(time_ns, entries, sample, self._due_extremes(time_ns, last), measurement)

    def _due_extremes(self, time_ns: int, last: bool) -> CouplerExtremes | None:
        if time_ns < self._extremes_due_ns and not (last and self._extremes_logged_ns != time_ns):
            return None
        self._extremes_logged_ns = time_ns
        self._extremes_due_ns = (time_ns // EXTREMES_PERIOD_NS + 1) * EXTREMES_PERIOD_NS
        return self.extremes()

    def _state(self, sample: Sample) -> TrainState:
        return TrainState(
            sample,
            self._model.brake_targets,
            self._model.bottomed_times,
            self.stop_time,
            self._model.valves(),
            self._model.parted,
        )

    # -- requests -------------------------------------------------------------------------------

    def request(self, request: Request) -> None:
        """Give a command, change a radio link (the next command goes over the new one) or let a fault happen, now.

        Raises
        ------
        CommandError
            Unknown locomotive, a value out of range, more traction than the locomotive has, the end of an emergency
            while the train moves, a fault that the train cannot have, or too much is under way already for anything
            but an emergency. Nothing has changed then.
        """
        if isinstance(request, RadioLinkChange):
            self._exchange.change(request, self.time)
        elif isinstance(request, Fault):
            self._faults.carry_out(request)
        else:
            self._command(request)

    def _command(self, command: Command) -> None:
        self._locomotives.check(command)
        full = self._under_way >= MOST_UNDER_WAY
        if full and not _is_emergency(command):
            problem = f"{self._under_way} brake waves and telegrams are under way, expected fewer commands"
            raise CommandError(f"{command.locomotive}: {command.kind.value} = {command.value}: {problem}")
        self._entries.append(TimedRequest(self.time_ns, command))
        if command.locomotive == MASTER:
            self._locomotives.carry_out(self.time, command)
            slaves = [name for name in self._locomotives.names if name != MASTER]
        else:
            slaves = [command.locomotive]
        if full:
            slaves = [slave for slave in slaves if not self._exchange.has_emergency_coming(slave)]
        for slave in slaves:
            self._exchange.send(Command(slave, command.kind, command.value), self.step, self.time)

    @property
    def _under_way(self) -> int:
        return self._model.waves_under_way + self._exchange.under_way

    # -- running --------------------------------------------------------------------------------

    def advance(self, steps: int | None = None, *, stop: Callable[[], bool] = lambda: False) -> Sample:
        """Advance by a number of time steps, one sample period by default, and return the state then.

        Releases the GIL while it computes, and looks several times a second whether to ``stop`` before the end.

        Raises
        ------
        CommandError
            A timed command cannot be carried out at its time; the session stands there.
        """
        end = self.step + (self.steps_per_sample if steps is None else steps)
        while self.step < end:
            self._carry_out_due()
            part = min(end - self.step, self._next_due_step() - self.step, self._slices.steps)
            began = time.perf_counter()
            self._model.advance(part)
            self._slices.took(part, time.perf_counter() - began)
            self._faults.tell_partings()
            if stop():
                break
        return self.sample()

    def _first_step_at(self, time_ns: int) -> int:
        """The first time step whose stamp is not before a time: a request recorded at a step is due there again."""
        time_step = self.scenario.time_step
        step = max(0, math.floor(time_ns / NS_PER_S / time_step) - 2)
        while seconds_to_ns(step * time_step) < time_ns:
            step += 1
        return step

    def _carry_out_due(self) -> None:
        while self._timed and self._timed[0][0] <= self.step:
            self.request(self._timed.popleft()[1])
        if self._faults.waiting and self._next_fault_look <= self.step:
            head, speed = self.scenario.track.start_chainage + self.travelled, float(self._model.speed[0])
            for fault in self._faults.look(head):
                self.request(fault)
            way = self._faults.next_chainage - head
            self._next_fault_look = self.step + steps_to_look(way, speed, self.scenario.time_step)
        if self._driver is not None and self._next_look <= self.step:
            self._next_look = self.step + self._steps_between_looks
            for command in self._driver.look(self.time, float(self._model.speed[0]), self._front):
                self.request(command)
        self._exchange.carry_out_due(self.step, self.time)

    @property
    def _front(self) -> float:
        """Chainage of the head of the train [m]."""
        return self._model.chainage(0) + self.consist.vehicles[0].length / 2.0

    @property
    def _steps_between_looks(self) -> int:
        assert self.scenario.driver is not None
        return max(1, round(self.scenario.driver.reaction_time / self.scenario.time_step))

    def _next_due_step(self) -> int:
        due = [self._exchange.next_step(self.step)]
        due += [self._timed[0][0]] if self._timed else []
        due += [self._next_look] if self._driver is not None else []
        due += [self._next_fault_look] if self._faults.waiting else []
        return min(due)
