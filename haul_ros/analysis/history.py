"""Coupler forces and speed over time in as many columns as a picture shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.sample import FloatArray
from haul_ros.recording.series import Samples
from haul_ros.units import NS_PER_S


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """A run in few columns; of the samples in a column the value of largest magnitude, so that no peak is lost.

    ``force`` (m, n_couplers) [N], compression positive, in columns that begin and end at ``force_edges`` (m + 1,) [s];
    ``head_speed`` and ``tail_speed`` (p,) [m/s] in columns that begin at ``speed_time`` (p,) [s].
    """

    force_edges: FloatArray
    force: FloatArray
    speed_time: FloatArray
    head_speed: FloatArray
    tail_speed: FloatArray


class HistoryBuilder:
    """The history of about ``samples`` samples in at most ``max_columns`` columns, taken piece by piece."""

    def __init__(self, samples: int, max_columns: int) -> None:
        self._force, self._speed = Thinning(samples, max_columns), Thinning(samples, max_columns)

    def add(self, block: Samples) -> None:
        """The next samples."""
        self._force.add(block.couplers.time_ns, block.couplers.force)
        if len(block.vehicles.time_ns):
            self._speed.add(block.vehicles.time_ns, block.vehicles.speed[:, [0, -1]])

    def history(self) -> History:
        """Of all samples so far, of which there is at least one of couplers; without vehicles there are no speeds."""
        force, speed = self._force, self._speed
        head_speed, tail_speed = speed.values.T if len(speed.time) else (np.empty(0), np.empty(0))
        return History(_edges(force.time), force.values, speed.time, head_speed, tail_speed)


class Thinning:
    """A quantity at n instants in at most ``max_columns`` columns, built up from pieces in bounded memory.

    Where there come fewer than the ``count`` expected, columns are missing in the end; of more, the last has the rest.
    """

    def __init__(self, count: int, max_columns: int) -> None:
        count = max(1, count)
        self._starts = np.unique(np.linspace(0, count, min(count, max_columns), endpoint=False, dtype=np.intp))
        self._time_ns = np.zeros(len(self._starts), np.int64)
        self._highest = self._lowest = np.empty((len(self._starts), 0))
        self._seen = 0

    def add(self, time_ns: NDArray[np.int64], values: FloatArray) -> None:
        """The next samples: values (m, k) at ``time_ns`` (m,)."""
        if not len(time_ns):
            return
        if not self._seen:
            shape = (len(self._starts), values.shape[1])
            self._highest, self._lowest = np.full(shape, -np.inf), np.full(shape, np.inf)
        samples = np.arange(self._seen, self._seen + len(time_ns))
        columns, first = np.unique(np.searchsorted(self._starts, samples, side="right") - 1, return_index=True)
        self._highest[columns] = np.maximum(self._highest[columns], np.maximum.reduceat(values, first))
        self._lowest[columns] = np.minimum(self._lowest[columns], np.minimum.reduceat(values, first))
        begun = self._starts[columns] >= self._seen
        self._time_ns[columns[begun]] = time_ns[first[begun]]
        self._seen += len(time_ns)

    @property
    def time(self) -> FloatArray:
        """When each column begins [s]: the time of its first sample."""
        return self._time_ns[: self._begun] / NS_PER_S

    @property
    def values(self) -> FloatArray:
        """Of each column the value of largest magnitude, with its sign."""
        highest, lowest = self._highest[: self._begun], self._lowest[: self._begun]
        return np.where(highest >= -lowest, highest, lowest)

    @property
    def _begun(self) -> int:
        return int(np.searchsorted(self._starts, self._seen))


def _edges(begins: FloatArray) -> FloatArray:
    """Where columns begin and end; the last is as long as the others are on the average."""
    period = (begins[-1] - begins[0]) / (len(begins) - 1) if len(begins) > 1 else 1.0
    return np.append(begins, begins[-1] + period)
