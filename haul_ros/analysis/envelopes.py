"""Largest forces and strokes along the train."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.consist import Consist
from haul_ros.model.sample import CouplerExtremes, FloatArray


def largest_force(extremes: CouplerExtremes) -> FloatArray:
    """Envelope of |F| (n_couplers,) [N]: the larger of compression and tension of each coupler."""
    return np.maximum(extremes.compression, extremes.tension)


def full_strokes(consist: Consist) -> FloatArray:
    """Stroke [m] at which each draft gear (n_couplers,) is closed fully, slack included; infinite for a drawbar."""
    return np.array([gear.maximum_stroke + gear.slack / 2.0 if gear else np.inf for gear in consist.couplers])


def bottomed(full: FloatArray, extremes: CouplerExtremes) -> NDArray[np.bool_]:
    """Whether each draft gear (n_couplers,) came to its `full_strokes`, in either direction."""
    return np.maximum(extremes.compression_stroke, extremes.tension_stroke) >= full


def bottomed_couplers(consist: Consist, extremes: CouplerExtremes) -> tuple[int, ...]:
    """Indices of the couplers whose draft gear was closed fully."""
    return tuple(int(j) for j in np.flatnonzero(bottomed(full_strokes(consist), extremes)))
