"""Motion of the train: speed, distance, deceleration, and the stops that its brake applications come to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.sample import FloatArray

DECELERATION_WINDOW = 1.0
"""Time [s] over which the largest deceleration is a mean."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """The train at ``time`` (n,) [s]: speeds of head, tail and the mean of all vehicles [m/s], chainage of the centre
    of the first vehicle [m], and whether every vehicle ``stands``."""

    time: FloatArray
    head_speed: FloatArray
    tail_speed: FloatArray
    mean_speed: FloatArray
    head_chainage: FloatArray
    stands: NDArray[np.bool_]

    @property
    def standing_since(self) -> float | None:
        """Time [s] of the first sample from which on every vehicle stands, None if one moves in the last."""
        if not len(self.time) or not self.stands[-1]:
            return None
        moving = np.flatnonzero(~self.stands)
        return float(self.time[moving[-1] + 1 if len(moving) else 0])

    @property
    def distance(self) -> float:
        """What the head travelled [m]."""
        return float(self.head_chainage[-1] - self.head_chainage[0])


@dataclass(frozen=True, slots=True)
class Stop:
    """What a brake application from ``begin`` [s] to ``end`` [s] (its release, or the end of the samples) came to.

    ``demand`` is the largest, 0..1; ``initial_speed`` [m/s] that of the head at its begin; ``stopping_time`` [s] and
    ``stopping_distance`` [m], of the head, are from its begin to the first sample in which every vehicle stands, None
    if the train did not stop. ``final_speed`` [m/s] is that of the head at its end. ``largest_deceleration`` [m/s^2] is
    that of the mean speed of all vehicles over `DECELERATION_WINDOW`.
    """

    begin: float
    end: float
    demand: float
    initial_speed: float
    final_speed: float
    stopping_time: float | None
    stopping_distance: float | None
    largest_deceleration: float

    @property
    def mean_deceleration(self) -> float | None:
        """Mean over the distance, ``v0^2 / (2 s)`` [m/s^2] as in EN 14531-1; None if the train did not stop."""
        if not self.stopping_distance:
            return None
        return self.initial_speed**2 / (2.0 * self.stopping_distance)


class MotionRecorder:
    """`Motion` taken piece by piece; keeps five numbers of each sample."""

    def __init__(self) -> None:
        self._pieces: list[tuple[NDArray[Any], ...]] = []

    def add(self, time: FloatArray, chainage: FloatArray, speed: FloatArray) -> None:
        """The next samples: ``time`` (m,) [s], ``chainage`` [m] and ``speed`` [m/s] (m, n_vehicles)."""
        columns = speed[:, 0].copy(), speed[:, -1].copy(), speed.mean(axis=1), chainage[:, 0].copy()
        stands = ~np.asarray(speed.any(axis=1))
        self._pieces.append((time, *columns, stands))

    def motion(self) -> Motion:
        """Of all samples so far."""
        if not self._pieces:
            none = np.empty(0)
            return Motion(none, none, none, none, none, np.empty(0, np.bool_))
        return Motion(*(np.concatenate(column) for column in zip(*self._pieces, strict=True)))


def applications(time: FloatArray, demand: FloatArray, until: float) -> list[tuple[float, float, float]]:
    """Brake applications of a locomotive: begin and end [s] and largest demand of each.

    ``demand`` (n,) holds from ``time`` (n,) [s] on until the next; an application lasts while it is above 0, at most
    ``until`` [s].
    """
    found: list[tuple[float, float, float]] = []
    begin, largest = None, 0.0
    for at, value in zip(time, demand, strict=True):
        if value > 0.0:
            begin = float(at) if begin is None else begin
            largest = max(largest, float(value))
        elif begin is not None:
            found.append((begin, float(at), largest))
            begin, largest = None, 0.0
    return [*found, (begin, until, largest)] if begin is not None else found


def stop(motion: Motion, begin: float, end: float, demand: float) -> Stop:
    """What a brake application came to, in a motion of at least one sample; speed and place at its begin and end are
    straight between samples."""
    time = motion.time
    standing = np.flatnonzero(motion.stands & (time >= begin) & (time <= end))
    at = int(standing[0]) if len(standing) else None
    start = float(np.interp(begin, time, motion.head_chainage))
    return Stop(
        begin=begin,
        end=end,
        demand=demand,
        initial_speed=float(np.interp(begin, time, motion.head_speed)),
        final_speed=float(np.interp(end, time, motion.head_speed)),
        stopping_time=None if at is None else float(time[at] - begin),
        stopping_distance=None if at is None else float(motion.head_chainage[at] - start),
        largest_deceleration=largest_deceleration(motion, begin, end),
    )


def largest_deceleration(motion: Motion, begin: float, end: float) -> float:
    """Largest fall [m/s^2] of the mean speed over any `DECELERATION_WINDOW` that lies between two times [s]; over all
    of that time if it is shorter."""
    window = min(DECELERATION_WINDOW, end - begin)
    if window <= 0.0 or not len(motion.time):
        return 0.0
    inside = motion.time[(motion.time >= begin) & (motion.time <= end - window)]
    starts = np.union1d(inside, [begin, end - window])
    before, after = (np.interp(at, motion.time, motion.mean_speed) for at in (starts, starts + window))
    return float(np.max(before - after) / window)
