"""The driver of a scenario: commands over the same way as a person's, from what can be seen in the cab."""

from __future__ import annotations

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.consist import MASTER
from haul_ros.model.driver import CyclicBraking, DriverPlan

STEPS = 20
"""Efforts are set in so many parts of the largest: a driver does not move the handle for less."""


class Driver:
    """Decides at the time steps at which he looks; what he decides depends on nothing but what he was told there.

    ``demand``: where he finds the brake valve, 0 to 1.
    """

    def __init__(self, plan: DriverPlan, demand: float = 0.0) -> None:
        self._plan = plan
        self._effort = 0
        self._demand = demand
        self._released = -float("inf")

    def look(self, time: float, speed: float, front: float = 0.0) -> list[Command]:
        """Commands at a time [s], at a speed of the head [m/s] and its chainage [m]; none that changes nothing."""
        return [*self._set_effort(self._part(speed)), *self._set_demand(time, self._wanted_demand(time, speed))]

    def _part(self, speed: float) -> float:
        """Part of the largest traction, or negative electric brake, that he wants."""
        part = max(-1.0, min(1.0, (self._plan.speed - speed) / self._plan.band))
        return min(part, 0.0) if self._demand > 0.0 else part  # nobody pulls against his own brake

    def _wanted_demand(self, time: float, speed: float) -> float:
        """Brake demand that he wants, 0 to 1."""
        cyclic = self._plan.cyclic
        return 0.0 if cyclic is None else self._cyclic_demand(cyclic, time, speed)

    def _cyclic_demand(self, cyclic: CyclicBraking, time: float, speed: float) -> float:
        if speed > cyclic.full_service_speed:
            return 1.0
        if self._demand > 0.0:
            return 0.0 if speed < cyclic.release_speed else self._demand
        recharged = time >= self._released + cyclic.recharge_time
        return cyclic.demand if speed > cyclic.apply_speed and recharged else 0.0

    def _set_effort(self, part: float) -> list[Command]:
        most = self._plan.traction if part > 0.0 else self._plan.electric_brake
        effort = round(STEPS * part) if most > 0.0 else 0
        before, self._effort = self._effort, effort
        if effort == before:
            return []
        commands = []
        if before * effort <= 0 and before != 0:  # the other one ends
            commands.append(self._effort_command(before, 0.0))
        if effort != 0:
            commands.append(self._effort_command(effort, abs(effort) / STEPS * most))
        return commands

    @staticmethod
    def _effort_command(sense: int, force: float) -> Command:
        kind = CommandKind.TRACTION if sense > 0 else CommandKind.ELECTRIC_BRAKE
        return Command(MASTER, kind, force)

    def _set_demand(self, time: float, demand: float) -> list[Command]:
        if demand == self._demand:
            return []
        if demand == 0.0:
            self._released = time
        self._demand = demand
        return [Command(MASTER, CommandKind.BRAKE, demand)]
