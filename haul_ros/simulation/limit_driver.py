"""A driver who knows his line and keeps its speed limits, in the manner of his plan."""

from __future__ import annotations

import math
from collections import deque

from haul_ros.model.command import Command
from haul_ros.model.driver import CyclicBraking, DriverPlan
from haul_ros.model.scenario import Scenario
from haul_ros.simulation.driver import STEPS, Driver
from haul_ros.simulation.route import Route
from haul_ros.units import kmh_to_mps

MARGIN = kmh_to_mps(2.0)
"""Kept from a limit [m/s]: the head's speed is not that of every vehicle, and a speedometer not the speed."""

RECHARGE = 100.0
"""Time [s] that the reservoirs get after a release where the plan names none."""

_MEMORY = 5.0
"""Over which he sees whether his train becomes faster [s]."""

_DEEPER = 0.15
"""Part of the full reduction by which he deepens an application that is not enough."""

_HASTY = 0.3
"""The same for reservoirs that had no time at all: a deep second application holds where a light one releases."""

_TAKEN_UP, _KEPT = 3.0, 4.0
"""How far ahead of the highest speed he takes up all of the electric brake, and keeps it, in times of his air brake."""

_NOTCH = 0.75
"""By how much of a step the effort that he wants differs from the one that he has before he moves the handle."""

_LOOKING_AHEAD = 2.0
"""Step of time of what he expects [s]."""


class LimitDriver(Driver):
    """Follows his plan below the speed from which he can meet every limit under his train and ahead of it.

    He keeps to that by electric brake first, then by a light application of the air brake before its force is needed,
    deepened where it is not enough; over the limit he takes full service. Whatever the plan, he releases when the
    train will not reach that speed again before the reservoirs have recharged. He does not pull where it gains speed
    by itself.
    """

    def __init__(self, plan: DriverPlan, route: Route, demand: float = 0.0) -> None:
        super().__init__(plan, demand)
        self._route = route
        self._cyclic = plan.cyclic or CyclicBraking(math.inf, 0.0, route.first_demand, RECHARGE, math.inf)
        self._seen = deque[tuple[float, float]]()
        self._front = 0.0
        self._time = 0.0
        self._changed = -math.inf
        self._guarded = False
        self._delay = route.brake_delay + plan.reaction_time

    def look(self, time: float, speed: float, front: float = 0.0) -> list[Command]:
        """See `Driver.look`."""
        self._time, self._front = time, front
        self._seen.append((time, speed))
        while len(self._seen) > 2 and self._seen[1][0] <= time - _MEMORY:
            self._seen.popleft()
        return super().look(time, speed, front)

    # -- what he sees and expects ------------------------------------------------------------------

    def _highest(self, front: float) -> float:
        """Speed that he does not want to pass with the head at a chainage [m/s]."""
        ceiling = self._route.ceiling(front)
        return ceiling - min(MARGIN, 0.1 * ceiling) if ceiling < math.inf else ceiling

    def _target(self) -> float:
        """Speed that he holds [m/s]: a band below the highest, so that all of the electric brake acts there."""
        highest = self._highest(self._front)
        if highest == math.inf:
            return self._plan.speed
        return min(self._plan.speed, max(highest - self._plan.band, highest / 2.0))

    def _soon_too_fast(self, speed: float) -> bool:
        """Whether an application now would not be too early."""
        there = self._front + speed * self._delay
        if self._demand == 0.0:
            electric = max(0, -self._effort) / STEPS * self._plan.electric_brake
            gain = self._route.coasting(there, speed) - self._route.electric_deceleration(electric, speed)
        else:  # what the air brake gives he sees only from what it does
            (before, slower), (now, _) = self._seen[0], self._seen[-1]
            gain = (speed - slower) / (now - before) if now > before else 0.0
        gain = max(gain, -speed / self._delay)
        return speed + gain * self._delay > self._highest(there)

    def _stays_below(self, speed: float, duration: float, electric_brake: float) -> bool:
        """Whether the train, left to its electric brake [N], stays below the highest speed for a duration [s]."""
        front = self._front
        for _ in range(math.ceil(duration / _LOOKING_AHEAD)):
            electric = self._route.electric_deceleration(electric_brake, speed)
            speed += _LOOKING_AHEAD * (self._route.coasting(front, speed) - electric)
            if speed <= 0.0:
                return True
            front += _LOOKING_AHEAD * speed
            if speed > self._highest(front):
                return False
        return True

    # -- what he does ------------------------------------------------------------------------------

    def _part(self, speed: float) -> float:
        plan, target = self._plan, self._target()
        band = min(plan.band, max(self._highest(self._front) - target, 1e-3)) if speed > target else plan.band
        part = max(-1.0, min(1.0, (target - speed) / band))
        if self._demand == 0.0 and plan.electric_brake > 0.0:
            recharging = max(0.0, self._released + self._cyclic.recharge_time - self._time)
            # Before the air brake, and where he has taken it up he keeps it up: a handle is not moved to and fro
            ahead = recharging + self._delay * (_KEPT if self._guarded else _TAKEN_UP)
            self._guarded = not self._stays_below(speed, ahead, 0.0)
        if self._guarded:
            return -1.0
        dragging = self._demand > 0.0 or self._time < self._released + self._delay
        if part > 0.0 and (dragging or self._route.coasting(self._front, speed) > 0.0):
            return 0.0
        return part if abs(STEPS * part - self._effort) > _NOTCH else self._effort / STEPS

    def _wanted_demand(self, time: float, speed: float) -> float:
        demand = self._demand_by_speed(time, speed)
        if demand != self._demand:
            self._changed = time
        return demand

    def _demand_by_speed(self, time: float, speed: float) -> float:
        cyclic = self._cyclic
        if speed > min(cyclic.full_service_speed, self._route.limit(self._front) + MARGIN):
            return 1.0
        if self._demand == 0.0:
            if not self._soon_too_fast(speed):
                return self._cyclic_demand(cyclic, time, speed)
            charged = min(1.0, (time - self._released) / cyclic.recharge_time) if cyclic.recharge_time > 0.0 else 1.0
            needed = max(cyclic.demand, self._route.demand_for(self._front, speed))
            return min(1.0, needed + _HASTY * (1.0 - charged))
        if time < self._changed + self._delay:  # it has not shown yet what it does
            return self._demand
        if self._demand < 1.0 and self._soon_too_fast(speed):
            return min(1.0, max(self._demand + _DEEPER, self._route.demand_for(self._front, speed)))
        return 0.0 if self._may_release(speed) else self._demand

    def _may_release(self, speed: float) -> bool:
        below = self._target() if self._plan.cyclic is None else self._cyclic.release_speed
        if self._route.coasting(self._front, speed) <= 0.0:
            below = max(below, self._target())
        recharge = self._cyclic.recharge_time + self._delay
        return speed < below and self._stays_below(speed, recharge, self._plan.electric_brake)


def driver_of(scenario: Scenario, demand: float = 0.0) -> Driver | None:
    """Who drives a scenario whose brake valves stand at a demand; None: nobody. On a line with limits he keeps them."""
    if scenario.driver is None:
        return None
    if not scenario.track.speed_limits:
        return Driver(scenario.driver, demand)
    return LimitDriver(scenario.driver, Route(scenario), demand)
