"""Changes of couplers between buff and draft."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.sample import FloatArray

DEAD_BAND = 10_000.0
"""Force [N] on either side of 0 within which a coupler is neither in buff nor in draft; chosen: 0.5 % of what couplers
bear, well above rounding and what a strain gauge resolves."""


def force_reversals(force: FloatArray, dead_band: float = DEAD_BAND) -> NDArray[np.intp]:
    """How often (k,) each coupler changes between buff and draft: forces (n, k) [N], compression positive."""
    counter = ReversalCounter(force.shape[1], dead_band)
    counter.add(force)
    return counter.to_buff + counter.to_draft


class ReversalCounter:
    """`force_reversals` of k couplers, taken piece by piece.

    ``to_buff`` and ``to_draft`` (k,) are how often a coupler came into compression above the dead band that was in
    tension beyond it before, whatever lay between, and the other way round.
    """

    def __init__(self, couplers: int, dead_band: float = DEAD_BAND) -> None:
        self._dead_band = dead_band
        self._side = np.zeros(couplers, np.int8)
        self.to_buff = np.zeros(couplers, np.intp)
        self.to_draft = np.zeros(couplers, np.intp)

    def add(self, force: FloatArray) -> None:
        """The next samples (m, k) [N]."""
        sides = np.concatenate((self._side[None, :], _sides(force, self._dead_band)))
        # The row of the newest sample up to each that was on a side
        rows = np.where(sides != 0, np.arange(len(sides))[:, None], 0)
        held = np.take_along_axis(sides, np.maximum.accumulate(rows, axis=0), axis=0)
        change = np.diff(held, axis=0)  # from no side yet: 1; from one to the other: 2
        self.to_buff += (change == 2).sum(axis=0)
        self.to_draft += (change == -2).sum(axis=0)
        self._side = held[-1]


def _sides(force: FloatArray, dead_band: float) -> NDArray[np.int8]:
    return (force > dead_band).astype(np.int8) - (force < -dead_band).astype(np.int8)
