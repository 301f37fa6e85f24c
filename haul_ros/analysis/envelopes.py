"""Largest forces and strokes along the train."""

from __future__ import annotations

import numpy as np

from haul_ros.model.consist import Consist
from haul_ros.model.sample import CouplerExtremes, FloatArray


def largest_force(extremes: CouplerExtremes) -> FloatArray:
    """Envelope of |F| (n_couplers,) [N]: the larger of compression and tension of each coupler."""
    return np.maximum(extremes.compression, extremes.tension)


def bottomed_couplers(consist: Consist, extremes: CouplerExtremes) -> tuple[int, ...]:
    """Indices of the couplers whose draft gear was closed fully, slack included, in either direction."""
    full = np.array([gear.maximum_stroke + gear.slack / 2.0 if gear else np.inf for gear in consist.couplers])
    reached = np.maximum(extremes.compression_stroke, extremes.tension_stroke)
    return tuple(int(j) for j in np.flatnonzero(reached >= full))
