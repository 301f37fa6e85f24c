"""Extremes of force and stroke of every coupler, with their times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.sample import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class SampledPeaks:
    """Largest values of k couplers (k,) in samples: forces [N] and strokes [m] as magnitudes, times [s].

    A coupler that never bore any compression has 0 there, at NaN; so with tension.
    """

    compression: FloatArray
    compression_time: FloatArray
    tension: FloatArray
    tension_time: FloatArray
    compression_stroke: FloatArray
    compression_stroke_time: FloatArray
    tension_stroke: FloatArray
    tension_stroke_time: FloatArray

    @property
    def force(self) -> FloatArray:
        """Envelope of \\|F\\| (k,) [N]: the larger of compression and tension."""
        return np.maximum(self.compression, self.tension)


def sampled_peaks(time: FloatArray, force: FloatArray, stroke: FloatArray) -> SampledPeaks:
    """Largest values of force [N] and stroke [m] (n, k), compression positive, at ``time`` (n,) [s]; the first of
    equals."""
    finder = PeakFinder(force.shape[1])
    finder.add(time, force, stroke)
    return finder.peaks()


class PeakFinder:
    """`sampled_peaks` of k couplers, taken piece by piece."""

    def __init__(self, couplers: int) -> None:
        self._largest = [(np.zeros(couplers), np.full(couplers, np.nan)) for _ in range(4)]

    def add(self, time: FloatArray, force: FloatArray, stroke: FloatArray) -> None:
        """The next samples."""
        if not len(time):
            return
        # argmin and argmax, rather than argmax of a negative copy
        for (largest, when), values, sign in zip(
            self._largest, (force, force, stroke, stroke), (1.0, -1.0, 1.0, -1.0), strict=True
        ):
            at = values.argmax(axis=0) if sign > 0.0 else values.argmin(axis=0)
            found = sign * values[at, np.arange(values.shape[1])]
            _take(largest, when, found, time[at])

    def peaks(self) -> SampledPeaks:
        """Of all samples so far."""
        return SampledPeaks(*(array.copy() for pair in self._largest for array in pair))


def _take(largest: FloatArray, when: FloatArray, found: FloatArray, times: FloatArray) -> None:
    better: NDArray[np.bool_] = found > largest
    largest[better], when[better] = found[better], times[better]
