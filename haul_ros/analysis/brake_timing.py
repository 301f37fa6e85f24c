"""When brake cylinders fill along the train."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from haul_ros.model.sample import FloatArray

LEVELS = (0.1, 0.9)
"""Parts of the pressure reached by which a filling is told."""
LONGEST_FILLING = 300.0
"""Time [s] from the begin of an application after which no cylinder still fills: the last of 204 wagons is at 95 % of
full service 142 s after one locomotive began."""
LEAST_PRESSURE = 10_000.0
"""Pressure [Pa] that a cylinder has to reach for a filling to be told of; chosen: less moves no piston."""


@dataclass(frozen=True, slots=True, eq=False)
class Filling:
    """How the cylinders of k vehicles filled in an application that began at ``begin`` [s].

    ``pressure`` (k,) [Pa] is the largest reached; ``times`` (levels, k) [s after begin] when the pressure first came to
    each of `LEVELS` of it, straight between samples. NaN where the pressure stayed below `LEAST_PRESSURE`.
    """

    begin: float
    pressure: FloatArray
    times: FloatArray


def filling(time: FloatArray, pressure: FloatArray, begin: float, levels: Sequence[float] = LEVELS) -> Filling:
    """The filling of brake cylinders (n, k) [Pa] at ``time`` (n,) [s], of which those before ``begin`` count not."""
    first = int(np.searchsorted(time, begin))
    if first == len(time):
        return Filling(begin, np.full(pressure.shape[1], np.nan), np.full((len(levels), pressure.shape[1]), np.nan))
    # The sample before, for a pressure that rises between the two
    first = max(0, first - 1)
    time, pressure = time[first:], pressure[first:]
    largest = pressure.max(axis=0)
    times = np.array([_first_times(time, pressure, level * largest) - begin for level in levels])
    times[:, largest < LEAST_PRESSURE] = np.nan
    return Filling(begin, largest, np.maximum(times, 0.0))


class FillingRecorder:
    """`filling` of applications that begin and end at known times [s], in order, taken piece by piece.

    Keeps the samples of one application, of `LONGEST_FILLING` at most.
    """

    def __init__(self, applications: Sequence[tuple[float, float]]) -> None:
        self._waiting = list(applications)
        self._pieces: list[tuple[FloatArray, FloatArray]] = []
        self._found: list[Filling] = []

    def add(self, time: FloatArray, pressure: FloatArray) -> None:
        """The next samples (m,) [s], (m, k) [Pa]."""
        while len(time) and self._waiting:
            begin, end = self._waiting[0]
            end = min(end, begin + LONGEST_FILLING)
            if time[-1] < begin:
                self._pieces = [(time[-1:].copy(), pressure[-1:].copy())]
                return
            until = int(np.searchsorted(time, end, side="right"))
            self._pieces.append((time[:until].copy(), pressure[:until].copy()))
            if until == len(time):
                return
            self._finish()

    def fillings(self) -> list[Filling]:
        """Of all applications that had begun, in their order."""
        if self._waiting and self._pieces and self._pieces[-1][0][-1:] >= self._waiting[0][0]:
            self._finish()
        return self._found

    def _finish(self) -> None:
        begin, _ = self._waiting.pop(0)
        time, pressure = (np.concatenate(part) for part in zip(*self._pieces, strict=True))
        self._found.append(filling(time, pressure, begin))
        self._pieces = [(time[-1:], pressure[-1:])]


def _first_times(time: FloatArray, values: FloatArray, levels: FloatArray) -> FloatArray:
    """When values (n, k) first come to levels (k,) that they reach, straight between samples."""
    at = (values >= levels).argmax(axis=0)
    columns = np.arange(values.shape[1])
    before = np.maximum(at - 1, 0)
    low, high = values[before, columns], values[at, columns]
    part = np.divide(levels - low, high - low, out=np.ones_like(low), where=high > low)
    return np.asarray(time[before] + part * (time[at] - time[before]))
