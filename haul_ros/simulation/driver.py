"""The driver of a scenario: commands over the same way as a person's, from what can be seen in the cab."""

from __future__ import annotations

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.consist import MASTER
from haul_ros.model.driver import DriverPlan

STEPS = 20
"""Efforts are set in so many parts of the largest: a driver does not move the handle for less."""


class Driver:
    """Decides at the time steps at which he looks; what he decides depends on nothing but what he was told there."""

    def __init__(self, plan: DriverPlan) -> None:
        self._plan = plan
        self._effort = 0
        self._demand = 0.0
        self._released = -float("inf")

    def look(self, time: float, speed: float) -> list[Command]:
        """Commands at a time [s], at a speed of the head [m/s]; none that changes nothing."""
        return [*self._efforts(speed), *self._air_brake(time, speed)]

    def _efforts(self, speed: float) -> list[Command]:
        plan = self._plan
        part = max(-1.0, min(1.0, (plan.speed - speed) / plan.band))
        if self._demand > 0.0:
            part = min(part, 0.0)  # nobody pulls against his own brake
        most = plan.traction if part > 0.0 else plan.electric_brake
        effort = round(STEPS * part) if most > 0.0 else 0
        before, self._effort = self._effort, effort
        if effort == before:
            return []
        commands = []
        if before * effort <= 0 and before != 0:  # the other one ends
            commands.append(self._set(before, 0.0))
        if effort != 0:
            commands.append(self._set(effort, abs(effort) / STEPS * most))
        return commands

    @staticmethod
    def _set(sense: int, force: float) -> Command:
        kind = CommandKind.TRACTION if sense > 0 else CommandKind.ELECTRIC_BRAKE
        return Command(MASTER, kind, force)

    def _air_brake(self, time: float, speed: float) -> list[Command]:
        cyclic = self._plan.cyclic
        if cyclic is None:
            return []
        demand = self._demand
        if speed > cyclic.full_service_speed:
            demand = 1.0
        elif demand > 0.0 and speed < cyclic.release_speed:
            demand, self._released = 0.0, time
        elif demand == 0.0 and speed > cyclic.apply_speed and time >= self._released + cyclic.recharge_time:
            demand = cyclic.demand
        if demand == self._demand:
            return []
        self._demand = demand
        return [Command(MASTER, CommandKind.BRAKE, demand)]
