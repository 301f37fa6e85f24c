"""For how long couplers bear more than a limit."""

from __future__ import annotations

import numpy as np

from haul_ros.model.sample import FloatArray

STRENGTH_LIMIT = 2_250_000.0
"""Force [N] that couplers of such trains are to bear at most in use: Chang 2023, Railway Sciences 2(4)."""


def time_above(time: FloatArray, values: FloatArray, limit: float) -> FloatArray:
    """For how long (k,) [s] each of values (n, k) at ``time`` (n,) [s] is above a limit, straight between samples.

    Of an interval from f0 to f1 the part ``(max - limit) / (max - min)``, not below 0 nor above 1: exact for what is
    straight between samples.
    """
    if len(time) < 2:
        return np.zeros(values.shape[1])
    high, low = np.maximum(values[:-1], values[1:]), np.minimum(values[:-1], values[1:])
    span = high - low
    part = np.divide(high - limit, span, out=np.where(high > limit, 1.0, 0.0), where=span > 0.0)
    return np.asarray(np.diff(time) @ np.clip(part, 0.0, 1.0))


class LimitWatch:
    """`time_above` a limit [N] of k couplers' buff and draft forces, taken piece by piece.

    ``compression`` and ``tension`` (k,) [s]: for how long so far.
    """

    def __init__(self, couplers: int, limit: float = STRENGTH_LIMIT) -> None:
        self.limit = limit
        self.compression = np.zeros(couplers)
        self.tension = np.zeros(couplers)
        self._last: tuple[FloatArray, FloatArray] = np.empty(0), np.empty((0, couplers))

    def add(self, time: FloatArray, force: FloatArray) -> None:
        """The next samples (m,) [s], (m, k) [N], compression positive."""
        if not len(time):
            return
        peak = max(np.abs(part).max(initial=0.0) for part in (force, self._last[1]))
        if peak > self.limit:  # seldom: most pieces need no more than this
            times = np.concatenate((self._last[0], time))
            forces = np.concatenate((self._last[1], force))
            self.compression += time_above(times, forces, self.limit)
            self.tension += time_above(times, -forces, self.limit)
        self._last = time[-1:].copy(), force[-1:].copy()
