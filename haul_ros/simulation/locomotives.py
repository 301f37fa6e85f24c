"""The locomotives of a train: what each makes of a command that has reached it."""

from __future__ import annotations

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import AppliedBrake, Effort, LogEntry
from haul_ros.physics.train_model import TrainModel
from haul_ros.simulation.brake_valves import BrakeValves, DriverBrake
from haul_ros.units import seconds_to_ns


class Locomotives:
    """Brake valves and tractive efforts; applied brakes and emergencies are handed to ``log`` as they change."""

    def __init__(self, model: TrainModel, valves: BrakeValves, log: list[LogEntry]) -> None:
        self._model = model
        self._valves = valves
        self._log = log
        self._brakes = {
            loco.name: DriverBrake(loco.vehicle, model.initial_demand) for loco in model.consist.locomotives
        }
        self._efforts = dict.fromkeys(self._brakes, 0.0)
        for name, brake in self._brakes.items():
            log.append(AppliedBrake(0, name, brake.demand))
            log.append(Effort(0, name, 0.0))

    @property
    def names(self) -> tuple[str, ...]:
        """Their names, the master first."""
        return tuple(self._brakes)

    def changed_efforts(self, time_ns: int) -> list[LogEntry]:
        """Tractive efforts and electric brakes that act and are not those of the last call, at a time [ns]."""
        efforts, changed = self._model.efforts, list[LogEntry]()
        for name, brake in self._brakes.items():
            if (effort := float(efforts[brake.vehicle])) != self._efforts[name]:
                self._efforts[name] = effort
                changed.append(Effort(time_ns, name, effort))
        return changed

    def check(self, command: Command) -> None:
        """Refuse what no locomotive can carry out now.

        Raises
        ------
        CommandError
            Unknown locomotive, a value out of range, more traction than the locomotive has, or the
            end of an emergency while the train moves.
        """
        brake = self._brakes.get(command.locomotive)
        if brake is None:
            known = ", ".join(self._brakes)
            raise CommandError(f"{command.locomotive}: no such locomotive, this train has {known}")
        command.check()
        if command.kind.is_effort:
            vehicle, kind = self._model.consist.vehicles[brake.vehicle], command.kind
            most = vehicle.max_tractive_effort if kind is CommandKind.TRACTION else vehicle.electric_brake.max_force
            if command.value > most:
                problem = f"{kind.value} = {command.value} N, must be at most {most} N"
                raise CommandError(f"{command.locomotive}: {problem}")
        if command.kind is CommandKind.EMERGENCY:
            if command.value not in (0.0, 1.0):
                raise CommandError(f"{command.locomotive}: emergency = {command.value}, must be 0 or 1")
            if command.value == 0.0 and brake.emergency and not self._model.at_standstill:
                raise CommandError(f"{command.locomotive}: an emergency application ends at standstill only")

    def set_radio_link(self, name: str, connected: bool) -> None:
        """The link to a slave is up or down; while it is down, its brake pipe alone tells it to stop pulling."""
        self._model.set_radio_link(self._brakes[name].vehicle, connected)

    def carry_out(self, time: float, command: Command) -> None:
        """A command takes effect at the locomotive that it names, at ``time`` [s]."""
        brake = self._brakes[command.locomotive]
        if command.kind is CommandKind.TRACTION:
            held = brake.demand > 0.0 or brake.emergency or self._model.in_emergency(brake.vehicle)
            # A telegram that was under way when the link went down may arrive after the pipe has told of a brake
            free = not held and not self._model.stopped_by_pipe(brake.vehicle)
            self._model.set_traction(brake.vehicle, command.value if free else 0.0)
        elif command.kind is CommandKind.ELECTRIC_BRAKE:
            stays = self._model.consist.vehicles[brake.vehicle].electric_brake.stays_in_emergency
            ended = (brake.emergency or self._model.in_emergency(brake.vehicle)) and not stays
            self._model.set_electric_brake(brake.vehicle, 0.0 if ended else command.value)
        elif command.kind is CommandKind.BRAKE:
            self._set_demand(time, command.locomotive, brake, command.value)
        elif command.value == 1.0:
            self._start_emergency(time, command.locomotive, brake)
        else:
            self._end_emergency(time, command.locomotive, brake)

    def _set_demand(self, time: float, name: str, brake: DriverBrake, demand: float) -> None:
        if brake.emergency:
            return
        self._valves.set_demand(time, brake, demand)
        if demand > 0.0:
            self._model.stop_pulling(brake.vehicle)
        self._apply(time, name, brake, demand)

    def _start_emergency(self, time: float, name: str, brake: DriverBrake) -> None:
        if brake.emergency:
            return
        brake.emergency = True
        self._model.drop_efforts(brake.vehicle)
        self._valves.start_emergency(time, brake)
        self._apply(time, name, brake, 1.0)
        self._log.append(Event(seconds_to_ns(time), EventKind.EMERGENCY, f"{name}: emergency latched"))

    def _end_emergency(self, time: float, name: str, brake: DriverBrake) -> None:
        if not brake.emergency or not self._model.at_standstill:
            return
        brake.emergency = False
        self._apply(time, name, brake, 0.0)
        self._log.append(Event(seconds_to_ns(time), EventKind.EMERGENCY, f"{name}: emergency ended"))
        self._valves.end_emergency(time, brake, any(other.emergency for other in self._brakes.values()))

    def _apply(self, time: float, name: str, brake: DriverBrake, demand: float) -> None:
        if demand != brake.demand:
            brake.demand = demand
            self._log.append(AppliedBrake(seconds_to_ns(time), name, demand))
