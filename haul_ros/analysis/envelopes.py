"""Largest forces and strokes along the train, and coupler forces over time, from a recording."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haul_ros.errors import RecordingError
from haul_ros.model.consist import Consist
from haul_ros.model.sample import CouplerExtremes, FloatArray
from haul_ros.recording.reader import JointSeries, Recording
from haul_ros.units import NS_PER_S


def recorded_extremes(recording: Recording) -> CouplerExtremes:
    """The last extremes in a recording: those of every time step up to then.

    ``bottomed_time`` is not recorded and NaN throughout; see `bottomed_couplers`.

    Raises
    ------
    RecordingError
        The file is damaged or holds no extremes.
    """
    compression, tension = recording.max_compression(), recording.max_tension()
    if not (len(compression.time_ns) and len(tension.time_ns)):
        raise RecordingError(f"{recording.path}: holds no {recording.channels.max_compression.topic}: nothing was run")
    return CouplerExtremes(
        compression=compression.effort[-1],
        compression_time=compression.velocity[-1],
        tension=np.abs(tension.effort[-1]),
        tension_time=tension.velocity[-1],
        compression_stroke=compression.position[-1],
        tension_stroke=np.abs(tension.position[-1]),
        bottomed_time=np.full(len(compression.names), np.nan),
    )


def largest_force(extremes: CouplerExtremes) -> FloatArray:
    """Envelope of |F| (n_couplers,) [N]: the larger of compression and tension of each coupler."""
    return np.maximum(extremes.compression, extremes.tension)


def bottomed_couplers(consist: Consist, extremes: CouplerExtremes) -> tuple[int, ...]:
    """Indices of the couplers whose draft gear was closed fully, slack included, in either direction."""
    full = np.array([j.maximum_stroke + j.slack / 2.0 if j else np.inf for j in consist.joints])
    reached = np.maximum(extremes.compression_stroke, extremes.tension_stroke)
    return tuple(int(j) for j in np.flatnonzero(reached >= full))


def force_history(couplers: JointSeries, max_columns: int) -> tuple[FloatArray, FloatArray]:
    """Coupler force over time in at most ``max_columns`` columns, for a picture.

    Returns the time [s] at the edges of the columns (m + 1,) and the force [N] (m, n_couplers): of
    the samples in a column the one of the largest magnitude, so that no peak is lost. Each sample
    holds until the next; there must be at least one.
    """
    n = len(couplers.time_ns)
    starts: NDArray[np.intp] = np.unique(np.linspace(0, n, min(n, max_columns), endpoint=False, dtype=np.intp))
    highest = np.maximum.reduceat(couplers.effort, starts)
    lowest = np.minimum.reduceat(couplers.effort, starts)
    time = couplers.time_ns / NS_PER_S
    period = (time[-1] - time[0]) / (n - 1) if n > 1 else 1.0
    return np.append(time[starts], time[-1] + period), np.where(highest >= -lowest, highest, lowest)
