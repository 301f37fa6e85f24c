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
    last = recording.last_extremes()
    if last is None:
        raise RecordingError(f"{recording.path}: holds no {recording.channels.max_compression.topic}: nothing was run")
    compression, tension = last
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
    full = np.array([j.maximum_stroke + j.slack / 2.0 if j else np.inf for j in consist.couplers])
    reached = np.maximum(extremes.compression_stroke, extremes.tension_stroke)
    return tuple(int(j) for j in np.flatnonzero(reached >= full))


def _column_starts(count: int, max_columns: int) -> NDArray[np.intp]:
    return np.unique(np.linspace(0, count, min(count, max_columns), endpoint=False, dtype=np.intp))


class Thinning:
    """A long series in at most ``max_columns`` samples, built up from its pieces in bounded memory.

    Each value is the one of largest magnitude of the samples that it stands for, its time that of the first of them.
    """

    def __init__(self, count: int, max_columns: int) -> None:
        self._starts = _column_starts(count, max_columns)
        self._time_ns = np.zeros(len(self._starts), np.int64)
        self._names: tuple[str, ...] = ()
        self._highest: FloatArray | None = None
        self._lowest: FloatArray | None = None
        self._seen = 0

    def add(self, piece: JointSeries) -> None:
        """The next samples; ``count`` in all."""
        n = len(piece.time_ns)
        if not n:
            return
        values = np.stack((piece.position, piece.velocity, piece.effort))
        if self._highest is None or self._lowest is None:
            shape = (3, len(self._starts), len(piece.names))
            self._names, self._highest, self._lowest = piece.names, np.full(shape, -np.inf), np.full(shape, np.inf)
        columns = np.searchsorted(self._starts, np.arange(self._seen, self._seen + n), side="right") - 1
        met, begins = np.unique(columns, return_index=True)
        self._highest[:, met] = np.maximum(self._highest[:, met], np.maximum.reduceat(values, begins, axis=1))
        self._lowest[:, met] = np.minimum(self._lowest[:, met], np.minimum.reduceat(values, begins, axis=1))
        new = self._starts[met] >= self._seen
        self._time_ns[met[new]] = piece.time_ns[begins[new]]
        self._seen += n

    def result(self) -> JointSeries:
        """The thinned series, after at least one sample."""
        assert self._highest is not None
        assert self._lowest is not None
        position, velocity, effort = np.where(self._highest >= -self._lowest, self._highest, self._lowest)
        return JointSeries(self._time_ns, self._names, position, velocity, effort)


def force_history(couplers: JointSeries, max_columns: int) -> tuple[FloatArray, FloatArray]:
    """Coupler force over time in at most ``max_columns`` columns, for a picture.

    Returns the time [s] at the edges of the columns (m + 1,) and the force [N] (m, n_couplers): of
    the samples in a column the one of the largest magnitude, so that no peak is lost. Each sample
    holds until the next; there must be at least one.
    """
    n = len(couplers.time_ns)
    starts = _column_starts(n, max_columns)
    highest = np.maximum.reduceat(couplers.effort, starts)
    lowest = np.minimum.reduceat(couplers.effort, starts)
    time = couplers.time_ns / NS_PER_S
    period = (time[-1] - time[0]) / (n - 1) if n > 1 else 1.0
    return np.append(time[starts], time[-1] + period), np.where(highest >= -lowest, highest, lowest)
