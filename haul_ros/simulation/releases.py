"""Control valves of a pneumatic brake that release though no locomotive has asked for it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.sample import Sample
from haul_ros.physics.train_model import ValveState

APPLIED_AGAIN = 5e3
"""Fall of the brake pipe [Pa] by which a vehicle has felt the application that follows a release."""


class ReleaseWatch:
    """Knows which vehicles a release is still under way to, sample by sample.

    It takes its time along the train, so a vehicle may release for it when the locomotives have applied again already:
    until its pipe falls, or it applies.
    """

    def __init__(self, vehicles: int) -> None:
        self._asked = np.zeros(vehicles, dtype=bool)
        self._highest = np.full(vehicles, -np.inf)

    def unasked(self, before: ValveState, now: ValveState, sample: Sample) -> NDArray[np.bool_]:
        """Vehicles (v,) that have released from one sample to the next unasked; none that was cut out."""
        assert sample.pipe_pressure is not None
        if before.release_commanded or now.release_commanded:
            self._asked[:] = True
            self._highest[:] = sample.pipe_pressure
        np.maximum(self._highest, sample.pipe_pressure, out=self._highest)
        released = before.applied & ~now.applied & ~now.cut_out & ~self._asked
        self._asked &= (sample.pipe_pressure > self._highest - APPLIED_AGAIN) & (before.applied | ~now.applied)
        return np.asarray(released)
