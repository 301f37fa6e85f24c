"""Run-in and run-out: couplers that come into contact in buff or in draft, and how fast.

A run-in is a coupler that comes into compression out of its slack or out of tension, a run-out one that comes into
tension. The closing speed is the relative speed of the two vehicles at the contact, which is what impacts are told by
(AAR M-901 tests draft gears by it): the stroke rate where the force leaves 0. Where the force was 0 in the sample
before, the gear was in its slack, and the rate of that sample counts; where the force changes sign between two samples,
force and rate are straight between them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.sample import FloatArray

LEAST_FORCE = 50_000.0
"""Force [N] that a contact has to reach to be told of; chosen: 2 % of what couplers bear."""


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """Run-ins and run-outs (m,) in order of time.

    ``coupler`` is the column in the samples; ``time`` [s] that of the contact; ``run_in`` whether it is one in
    compression; ``speed`` [m/s] that of the two vehicles towards one another in a run-in, away from one another in a
    run-out; ``peak`` [N] the largest force of the contact, a magnitude, at ``peak_time`` [s].
    """

    coupler: NDArray[np.intp]
    time: FloatArray
    run_in: NDArray[np.bool_]
    speed: FloatArray
    peak: FloatArray
    peak_time: FloatArray


def contacts(
    time: FloatArray, force: FloatArray, stroke_rate: FloatArray, least_force: float = LEAST_FORCE
) -> Contacts:
    """Run-ins and run-outs whose force reaches ``least_force`` [N].

    ``force`` [N] and ``stroke_rate`` [m/s] (n, k), compression positive, at ``time`` (n,) [s]. A contact lasts until
    the force is 0 or of the other sign; what begins before the first sample is none, for nobody saw how.
    """
    finder = ContactFinder(force.shape[1], least_force)
    finder.add(time, force, stroke_rate)
    return finder.contacts()


class ContactFinder:
    """`contacts` of k couplers, taken piece by piece."""

    def __init__(self, couplers: int, least_force: float = LEAST_FORCE) -> None:
        self._least = least_force
        self._last = np.empty(0), np.empty((0, couplers)), np.empty((0, couplers))
        nothing = np.full(couplers, np.nan)
        # Of the contact that each coupler is in: NaN where none was seen to begin
        self._begun, self._speed = nothing.copy(), nothing.copy()
        self._peak, self._peak_time = np.zeros(couplers), nothing.copy()
        self._found: list[tuple[int, float, bool, float, float, float]] = []

    def add(self, time: FloatArray, force: FloatArray, stroke_rate: FloatArray) -> None:
        """The next samples (m,) [s], (m, k) [N] and [m/s]."""
        pairs = zip(self._last, (time, force, stroke_rate), strict=True)
        time, force, stroke_rate = (np.concatenate(pair) for pair in pairs)
        if not len(time):
            return
        sides = np.sign(force)
        changed = sides[1:] != sides[:-1]
        magnitude = np.abs(force)
        for j in range(force.shape[1]):
            starts = np.flatnonzero(changed[:, j]) + 1
            bounds = np.concatenate(([0], starts))
            peaks = np.maximum.reduceat(magnitude[:, j], bounds)
            self._go_on(j, time, magnitude[:, j], bounds, peaks)
            ends = np.append(bounds[1:], len(time))
            for start, end, peak in zip(starts, ends[1:], peaks[1:], strict=True):
                self._end(j, bool(sides[start - 1, j] > 0.0))
                if sides[start, j]:
                    begin, speed = _contact(int(start), time, force[:, j], stroke_rate[:, j])
                    self._begun[j], self._speed[j] = begin, speed * sides[start, j]
                    self._peak[j] = peak
                    self._peak_time[j] = time[start + int(np.argmax(magnitude[start:end, j]))]
        self._last = time[-1:].copy(), force[-1:].copy(), stroke_rate[-1:].copy()

    def contacts(self) -> Contacts:
        """Of all samples so far, with those contacts that still last."""
        force = self._last[1][0] if len(self._last[1]) else np.empty(0)
        lasting = [self._entry(j, bool(f > 0.0)) for j, f in enumerate(force) if self._counts(j)]
        rows = sorted([*self._found, *lasting], key=lambda row: (row[1], row[0]))
        columns = [np.array(column) for column in zip(*rows, strict=True)] or [
            np.empty(0, bool if field.name == "run_in" else np.intp if field.name == "coupler" else float)
            for field in fields(Contacts)
        ]
        return Contacts(*columns)

    def _go_on(
        self, j: int, time: FloatArray, magnitude: FloatArray, bounds: NDArray[np.intp], peaks: FloatArray
    ) -> None:
        """The contact of before lasts up to the first change."""
        if np.isfinite(self._begun[j]) and peaks[0] > self._peak[j]:
            end = bounds[1] if len(bounds) > 1 else len(time)
            self._peak[j], self._peak_time[j] = peaks[0], time[int(np.argmax(magnitude[:end]))]

    def _end(self, j: int, compression: bool) -> None:
        if self._counts(j):
            self._found.append(self._entry(j, compression))
        self._begun[j], self._peak[j] = np.nan, 0.0

    def _counts(self, j: int) -> bool:
        return bool(np.isfinite(self._begun[j]) and self._peak[j] >= self._least)

    def _entry(self, j: int, compression: bool) -> tuple[int, float, bool, float, float, float]:
        state = (self._begun, self._speed, self._peak, self._peak_time)
        begun, speed, peak, peak_time = (float(array[j]) for array in state)
        return j, begun, compression, speed, peak, peak_time


def _contact(start: int, time: FloatArray, force: FloatArray, rate: FloatArray) -> tuple[float, float]:
    """When the force leaves 0 on its way to the sample ``start`` [s], and the stroke rate then [m/s]."""
    before, behind = force[start - 1], force[start]
    part = before / (before - behind)  # 0 where the gear was in its slack
    return (
        float(time[start - 1] + part * (time[start] - time[start - 1])),
        float(rate[start - 1] + part * (rate[start] - rate[start - 1])),
    )
