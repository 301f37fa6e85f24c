"""Fatigue: rainflow counting of coupler forces (ASTM E1049-85, section 5.4.4) and damage-equivalent ranges.

The counting is that of the library rainflow (extra ``fatigue``). It sees turning points alone, and between pieces of
a recording the half cycles so far: those are all that what follows can still close, so the counts are the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from haul_ros.errors import HaulError
from haul_ros.model.sample import FloatArray

DAMAGE_EXPONENT = 5.0
"""Exponent m of the Woehler line ``N ~ range^-m``: that of the FKM guideline for normal stress in parts that are not
welded, as couplers are; welded draft sills have 3."""
BIN_WIDTH = 50_000.0
"""Width [N] of the ranges of `Spectrum`."""
_MOST_POINTS = 4096
"""Turning points of a coupler that wait to be counted."""


class FatigueError(HaulError):
    """Fatigue cannot be counted here."""


@dataclass(frozen=True, slots=True, eq=False)
class Cycles:
    """Cycles of one force: ``ranges`` (m,) [N] from valley to peak, ``means`` (m,) [N], ``counts`` (m,) 1 or 0.5."""

    ranges: FloatArray
    means: FloatArray
    counts: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Cycles of k couplers.

    ``cycles`` (k,) is their number, halves too, ``largest_range`` (k,) [N]; ``damage`` (k,) is the sum of
    ``count range^m`` [N^m] with the exponent m; ``histogram`` (k, b) has the cycles whose range is from
    ``i BIN_WIDTH`` to below ``(i + 1) BIN_WIDTH`` in column i.
    """

    exponent: float
    cycles: FloatArray
    largest_range: FloatArray
    damage: FloatArray
    histogram: FloatArray

    def equivalent_range(self, cycles: float = 1.0) -> FloatArray:
        """Force range (k,) [N] that does the same damage in so many cycles: ``(damage / cycles)^(1/m)``.

        That of one cycle does not depend on how many small cycles were seen; the damage of two runs is as the m-th
        power of theirs.
        """
        return np.asarray((self.damage / cycles) ** (1.0 / self.exponent))


def rainflow_available() -> bool:
    """Whether the library that counts is installed."""
    return find_spec("rainflow") is not None


def rainflow_cycles(force: FloatArray) -> Cycles:
    """Cycles of a force (n,) [N]; the first and the last sample count as turning points.

    Raises
    ------
    FatigueError
        The library is not installed.
    """
    cycles, rest = _count(turning_points(force))
    return _joined([cycles, _half_cycles(rest)])


def turning_points(values: FloatArray) -> FloatArray:
    """The first and the last of values (n,), and those between where they turn; of equal ones the first."""
    if not len(values):
        return values
    values = values[np.concatenate(([True], values[1:] != values[:-1]))]
    if len(values) == 1:
        return values
    rises = np.diff(values) > 0.0
    return values[np.concatenate(([True], rises[1:] != rises[:-1], [True]))]


class FatigueCounter:
    """Cycles of k couplers with a damage exponent m, taken piece by piece in bounded memory.

    Raises
    ------
    FatigueError
        The library is not installed.
    """

    def __init__(self, couplers: int, exponent: float = DAMAGE_EXPONENT) -> None:
        _extract_cycles()
        self._exponent = exponent
        self._points: list[FloatArray] = [np.empty(0)] * couplers
        """Of each coupler the half cycles and turning points so far, and last the newest sample."""
        self._counted = [0] * couplers
        """How many of them have been seen by the library."""
        self._closed = _Totals(couplers, exponent)

    def add(self, force: FloatArray) -> None:
        """The next samples (m, k) [N]."""
        for j, points in enumerate(self._points):
            self._points[j] = turning_points(np.concatenate((points, force[:, j])))
            if len(self._points[j]) > self._counted[j] + _MOST_POINTS:
                self._count(j)

    def spectrum(self) -> Spectrum:
        """Of all samples so far."""
        totals = self._closed.copy()
        for j, points in enumerate(self._points):
            cycles, rest = _count(points)
            totals.add(j, cycles)
            totals.add(j, _half_cycles(rest))
        return totals.spectrum()

    def _count(self, j: int) -> None:
        """Count what is closed; the newest sample may not be a turning point yet."""
        cycles, rest = _count(self._points[j][:-1])
        self._closed.add(j, cycles)
        self._points[j] = np.append(rest, self._points[j][-1])
        self._counted[j] = len(rest)


class _Totals:
    def __init__(self, couplers: int, exponent: float) -> None:
        self.exponent = exponent
        self.cycles, self.largest, self.damage = (np.zeros(couplers) for _ in range(3))
        self.histogram = np.zeros((couplers, 1))

    def copy(self) -> _Totals:
        totals = _Totals(len(self.cycles), self.exponent)
        totals.cycles, totals.largest = self.cycles.copy(), self.largest.copy()
        totals.damage, totals.histogram = self.damage.copy(), self.histogram.copy()
        return totals

    def add(self, j: int, found: Cycles) -> None:
        if not len(found.ranges):
            return
        self.cycles[j] += found.counts.sum()
        self.largest[j] = max(self.largest[j], found.ranges.max())
        self.damage[j] += found.counts @ found.ranges**self.exponent
        bins = (found.ranges // BIN_WIDTH).astype(np.intp)
        if (more := int(bins.max()) + 1 - self.histogram.shape[1]) > 0:
            self.histogram = np.pad(self.histogram, ((0, 0), (0, more)))
        self.histogram[j] += np.bincount(bins, found.counts, self.histogram.shape[1])

    def spectrum(self) -> Spectrum:
        return Spectrum(self.exponent, self.cycles, self.largest, self.damage, self.histogram)


def _extract_cycles() -> Callable[[list[float]], Iterable[tuple[float, float, float, int, int]]]:
    try:
        import rainflow
    except ImportError:
        raise FatigueError("fatigue needs the library rainflow: pip install 'haul_ros[fatigue]'") from None
    return rainflow.extract_cycles  # type: ignore[no-any-return]


def _count(points: FloatArray) -> tuple[Cycles, FloatArray]:
    """Full cycles of turning points, and the turning points of the half cycles that are left."""
    # The library takes no notice of the last of two points alone; one said twice is the same
    series = [*points.tolist(), *points[-1:].tolist()]
    full, rest = [], []
    for size, mean, count, begin, _ in _extract_cycles()(series):
        if count == 1.0:
            full.append((size, mean, count))
        else:
            rest.append(begin)
    left = points[rest] if rest else points[:0]
    return _cycles(full), np.append(left, points[-1:])


def _cycles(rows: list[tuple[float, float, float]]) -> Cycles:
    ranges, means, counts = np.array(rows, dtype=float).reshape(-1, 3).T
    return Cycles(ranges, means, counts)


def _half_cycles(points: FloatArray) -> Cycles:
    halves = np.full(max(0, len(points) - 1), 0.5)
    return Cycles(np.abs(np.diff(points)), (points[1:] + points[:-1]) / 2.0, halves)


def _joined(parts: list[Cycles]) -> Cycles:
    return Cycles(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("ranges", "means", "counts")))
