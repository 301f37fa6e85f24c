"""When to look next at whether something has come to a place on the line, whatever the sample rate."""

from __future__ import annotations

LONGEST = 0.1
"""Longest time between two looks [s]: collisions may make a vehicle faster at once."""

_GAIN = 1.0
"""Speed [m/s] by which a vehicle is reckoned to gain until then, beside twice the speed that it has."""


def steps_to_look(way: float, speed: float, time_step: float) -> int:
    """Time steps after which to look again at a vehicle that is ``way`` [m] from a place, at a speed [m/s].

    Few enough that it is seen there in the very time step, but for one that is pushed harder than `_GAIN` in `LONGEST`.
    """
    soonest = min(LONGEST, way / (2.0 * abs(speed) + _GAIN))
    return max(1, int(soonest / time_step))
