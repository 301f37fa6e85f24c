"""What a driver knows of his line and his train: how it runs when left alone, and how fast it may be where."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import OrderedDict
from collections.abc import Iterator
from itertools import pairwise

from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.scenario import Scenario
from haul_ros.model.track import Steps
from haul_ros.units import GRAVITY

COMFORTABLE = 0.05
"""Deceleration [m/s^2] that a lower limit is approached with at least, where the brakes give it."""

PLANNED = 0.25
"""Part of the full service brake that is counted on for that: about what the least application of a 120 valve gives."""

PIPE_SPEED = 250.0
"""At which an application goes along the train [m/s]: that of the wave in a brake pipe."""

FILLING = 10.0
"""Time [s] that the cylinders then take to fill, the larger part of the least application."""

CURVE_RESISTANCE = 0.6
"""Per weight, times the radius [m]: 600 N/kN over R (TB/T 1407-1998)."""

_CELL = 50.0
"""Length [m] of the pieces in which the approach to limits is worked out."""

_CHUNK = 50
"""Pieces that are worked out at once."""

_CHUNKS = 8
"""How many of those are kept."""

_FARTHEST = 20_000.0
"""How far ahead a driver looks at most [m]."""

_STRETCH = 1.01
"""Length of the train with its couplers drawn out, over that with free ones."""


class _Sum:
    """Integral along the line of what holds in steps by chainage, 0 before the first."""

    def __init__(self, steps: Steps) -> None:
        self._steps = steps
        self._sums = [0.0]
        for (start, value), (end, _) in pairwise(steps):
            self._sums.append(self._sums[-1] + value * (end - start))

    def at(self, chainage: float) -> float:
        """Integral from the first step to a chainage [m]."""
        index = bisect_right(self._steps, chainage, key=lambda step: step[0]) - 1
        if index < 0:
            return 0.0
        start, value = self._steps[index]
        return self._sums[index] + value * (chainage - start)


class Route:
    """A line, as the driver of a train knows it, in SI units; ``front`` is the chainage of the head of the train [m].

    He takes his train as of one mass per length, knows the brake force that it has from its vehicles, and knows the
    grades without their vertical curves.
    """

    def __init__(self, scenario: Scenario) -> None:
        train, track, brakes = scenario.consist, scenario.track, scenario.brakes
        self._track = track
        self._mass, self._length = train.mass, train.length * _STRETCH
        self._height, self._turned = _Sum(track.grades), _Sum(track.curves)
        weights = [(vehicle.mass / train.mass, vehicle.resistance) for vehicle in train.vehicles]
        self._constant = sum(share * resistance.constant for share, resistance in weights)
        self._linear = sum(share * resistance.linear for share, resistance in weights)
        self._quadratic = sum(share * resistance.quadratic for share, resistance in weights)
        self._starting = sum(share * resistance.starting for share, resistance in weights)
        self._slowest = max(resistance.minimum_speed for _, resistance in weights)
        self._locomotives = [train.vehicles[locomotive.vehicle] for locomotive in train.locomotives]
        top = max([scenario.initial_speed, *(limit for _, limit in track.speed_limits if limit < math.inf)])
        self._horizon = min(_FARTHEST, top**2 / (2.0 * COMFORTABLE))
        pneumatic = isinstance(brakes, PneumaticBrake)
        fraction = 1.0 if isinstance(brakes, PneumaticBrake) else brakes.full_service
        force = sum(
            vehicle.shoes * vehicle.shoe_force * vehicle.friction.coefficient(vehicle.shoe_force, top, top)
            for vehicle in train.vehicles
        )
        self._full_service = fraction * force / train.mass
        self._least = brakes.least_reduction / brakes.full_reduction if isinstance(brakes, PneumaticBrake) else 0.0
        self.first_demand = max(0.01 if pneumatic else PLANNED, self._demand(PLANNED))
        """Brake demand of a first, light application, 0 to 1."""
        self.brake_delay = train.length / PIPE_SPEED + FILLING
        """Time from an application to its brake force [s]."""
        self._chunks: OrderedDict[int, list[float]] = OrderedDict()

    def coasting(self, front: float, speed: float) -> float:
        """Acceleration of the train left alone [m/s^2]: grades and curves under it, running resistance."""
        rear = front - self._length
        grade = (self._height.at(front) - self._height.at(rear)) / self._length
        curve = CURVE_RESISTANCE * (self._turned.at(front) - self._turned.at(rear)) / self._length
        v = max(speed, self._slowest)
        running = self._starting if speed == 0.0 else self._constant + v * (self._linear + v * self._quadratic)
        return -GRAVITY * (grade + running + curve)

    def electric_deceleration(self, force: float, speed: float) -> float:
        """What an electric brake of so much at each locomotive [N] gives at a speed [m/s^2]."""
        total = 0.0
        for vehicle in self._locomotives:
            brake = vehicle.electric_brake
            there = min(force, brake.max_force, brake.max_power / max(speed, 1e-9))
            total += there * (min(1.0, speed / brake.fade_speed) if brake.fade_speed > 0.0 else 1.0)
        return total / self._mass

    def limit(self, front: float) -> float:
        """Lowest speed limit under any part of the train [m/s]."""
        return self._track.lowest_speed_limit(front - self._length, front)

    def ceiling(self, front: float) -> float:
        """Speed [m/s] from which every limit under the train and ahead of it is kept with the planned braking."""
        index = math.floor(front / _CELL)
        here, there = self._squared(index), self._squared(index + 1)
        part = front / _CELL - index
        ahead = here + part * (there - here) if here < math.inf and there < math.inf else min(here, there)
        return min(math.sqrt(ahead), self.limit(front))

    def demand_for(self, front: float, speed: float) -> float:
        """Brake demand 0 to 1 that brings the train to all limits ahead in time, as far as full service can."""
        needed = 0.0
        for chainage, limit in self._limits_ahead(front):
            if limit < speed:
                way = max(_CELL, chainage - front - speed * self.brake_delay)
                needed = max(needed, (speed**2 - limit**2) / (2.0 * way))
        if needed == 0.0 or self._full_service <= 0.0:
            return 0.0
        return self._demand((needed + self.coasting(front, speed)) / self._full_service)

    def _demand(self, share: float) -> float:
        """Demand that gives a share of the full service brake."""
        return min(1.0, max(0.0, (share - self._least) / (1.0 - self._least)))

    def _limits_ahead(self, front: float) -> Iterator[tuple[float, float]]:
        limits = self._track.speed_limits
        for step in limits[bisect_right(limits, front, key=lambda step: step[0]) :]:
            if step[0] > front + self._horizon:
                return
            yield step

    def _squared(self, cell: int) -> float:
        """Square of the ceiling by limits ahead at the start of a cell [m^2/s^2]."""
        number, place = divmod(cell, _CHUNK)
        if number not in self._chunks:
            self._chunks[number] = self._worked_out(number * _CHUNK)
            while len(self._chunks) > _CHUNKS:
                self._chunks.popitem(last=False)
        return self._chunks[number][place]

    def _worked_out(self, first: int) -> list[float]:
        """Squares of the ceiling from a cell on: backward, as fast as the limit there and braking after it allow."""
        found, squared = [], math.inf
        for cell in range(first + _CHUNK + math.ceil(self._horizon / _CELL), first - 1, -1):
            rear = cell * _CELL
            if squared < math.inf:
                squared += 2.0 * _CELL * self._planned(rear + _CELL, math.sqrt(squared))
            squared = min(squared, self._track.lowest_speed_limit(rear, math.nextafter(rear + _CELL, rear)) ** 2)
            if cell < first + _CHUNK:
                found.append(squared)
        return found[::-1]

    def _planned(self, front: float, speed: float) -> float:
        """Deceleration that is planned with [m/s^2]."""
        return max(COMFORTABLE, PLANNED * self._full_service - self.coasting(front, speed))
