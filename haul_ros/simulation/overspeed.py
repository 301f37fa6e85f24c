"""When a train is faster than the line allows, told from one state of it to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haul_ros.model.consist import Consist
from haul_ros.model.sample import FloatArray
from haul_ros.model.track import Track
from haul_ros.units import kmh_to_mps

BEGINS = kmh_to_mps(0.1)
"""Speed over the limit [m/s] at which an overspeed begins: less is rounding, and the train's own swaying."""

ENDS = kmh_to_mps(-0.5)
"""Speed over the limit [m/s] below which it has ended, so that one who holds the limit exactly is told once."""


@dataclass(frozen=True, slots=True)
class Overspeed:
    """A vehicle over the speed limit at an instant: time [ns], index, chainage of its front [m], speeds [m/s]."""

    time_ns: int
    vehicle: int
    chainage: float
    speed: float
    limit: float

    @property
    def excess(self) -> float:
        """Speed over the limit [m/s]."""
        return self.speed - self.limit


@dataclass(frozen=True, slots=True)
class Overspeeds:
    """How often a train has begun to be over the limit, and when it was so by most (None: never)."""

    count: int = 0
    worst: Overspeed | None = None


class OverspeedWatch:
    """Compares speeds with the limits of a line, once per sample.

    A limit holds for every part of the train, from its head to its tail: for a vehicle, anywhere between its ends.
    """

    def __init__(self, consist: Consist, track: Track) -> None:
        self._half_length = np.array([vehicle.length / 2.0 for vehicle in consist.vehicles])
        self._start = np.array([start for start, _ in track.speed_limits])
        self._limit = np.array([np.inf, *(limit for _, limit in track.speed_limits)])
        self._lowest = float(self._limit.min())
        self._over = False
        self.found = Overspeeds()
        """All so far."""

    @property
    def has_limits(self) -> bool:
        """Whether there is anything to watch."""
        return bool(np.isfinite(self._lowest))

    def update(self, time_ns: int, chainage: FloatArray, speed: FloatArray) -> Overspeed | None:
        """The overspeed that has begun since the last sample, by the vehicle farthest over its limit, if one has.

        ``chainage`` of the centres [m] and ``speed`` [m/s] of the vehicles (v,).
        """
        # Nearly always this is all that there is to do.
        if not np.abs(speed).max() > self._lowest + ENDS:
            self._over = False
            return None
        front, rear = chainage + self._half_length, chainage - self._half_length
        limit = self._lowest_between(rear, front)
        excess = np.abs(speed) - limit
        i = int(np.argmax(excess))
        if excess[i] <= BEGINS:
            self._over = self._over and bool(excess[i] > ENDS)
            return None
        found = Overspeed(time_ns, i, float(front[i]), abs(float(speed[i])), float(limit[i]))
        begins, self._over = not self._over, True
        worst = self.found.worst
        if worst is None or found.excess > worst.excess:
            worst = found
        self.found = Overspeeds(self.found.count + begins, worst)
        return found if begins else None

    def _lowest_between(self, rear: FloatArray, front: FloatArray) -> FloatArray:
        """Lowest limit under each vehicle: that at its rear, and all that begin under it."""
        first, last = (np.searchsorted(self._start, chainage, side="right") for chainage in (rear, front))
        lowest = self._limit[first]
        for more in range(1, int((last - first).max()) + 1):
            lowest = np.minimum(lowest, self._limit[np.minimum(first + more, last)])
        return np.asarray(lowest)
