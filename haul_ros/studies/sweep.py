"""Which cases a study has: products of varied values, and seeded random samples."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from haul_ros.studies.case import Case
from haul_ros.studies.errors import StudyError

Spec = TypeVar("Spec")

_WHOLE = 1e-9
MOST_VALUES = 1_000_000
"""Longest range."""
MOST_CASES = 1_000_000
"""Most cases of a study."""
MOST_DRAWN = 10_000_000
"""Most drawn values of a study, samples times draws: 80 MB."""
_TOO_MANY = f"more than {MOST_CASES} cases: fewer values or samples are needed"
_CHECK_ALL = 32
"""Axes up to so many points are checked point by point before anything runs, longer ones (ranges) at their ends."""


@dataclass(frozen=True, slots=True)
class Point:
    """One point of an axis: how it is called in names of cases, its columns in tables, and what it sets."""

    name: str
    values: Mapping[str, object]
    overrides: Mapping[str, object]


@dataclass(frozen=True, slots=True)
class Axis:
    """What is varied in one direction; the values of each point have one under the name of the axis."""

    name: str
    points: tuple[Point, ...]

    @property
    def plain(self) -> int | None:
        """Index of the one point that sets nothing, to compare the others with; None if there is no such one."""
        plain = [number for number, point in enumerate(self.points) if not point.overrides]
        return plain[0] if len(plain) == 1 else None

    def index(self, case: Case) -> int:
        """Index of the point at which a case lies."""
        return [point.values[self.name] for point in self.points].index(case.values[self.name])


@dataclass(frozen=True, slots=True)
class Draw:
    """A key whose value is drawn: ``uniform`` between two bounds, or ``normal`` with mean and standard deviation."""

    key: str
    distribution: str
    parameters: tuple[float, float]

    def __post_init__(self) -> None:
        first, second = self.parameters
        if not (math.isfinite(first) and math.isfinite(second)):
            raise StudyError(f"draw {self.key}: must be finite numbers")
        if self.distribution == "uniform" and second < first:
            raise StudyError(f"draw {self.key}: uniform from {first:g} to {second:g}, the second must not be below")
        if self.distribution == "normal" and second < 0.0:
            raise StudyError(f"draw {self.key}: standard deviation {second:g}, must not be below 0")


@dataclass(frozen=True, slots=True)
class PaperValues:
    """What the text of the paper says on the cases of certain values, None where it says nothing: [N], [m], j/N."""

    where: Mapping[str, object] = field(default_factory=dict)
    force: float | None = None
    stroke: float | None = None
    position: float | None = None


@dataclass(frozen=True, slots=True)
class Trend:
    """What is published on a quantity along an axis: that it rises, or falls; ``source`` says where."""

    along: str
    quantity: str
    rises: bool
    source: str


def has_values(case: Case, where: Mapping[str, object]) -> bool:
    """Whether a case has these values."""
    return all(name in case.values and case.values[name] == value for name, value in where.items())


@dataclass(frozen=True, slots=True)
class Sweep:
    """The cases of a study: every scenario with every combination of points, each with every random sample.

    At most `MOST_CASES` and `MOST_DRAWN`, else StudyError. The first n of more samples are those of n samples, and the
    samples are the same in all combinations.
    ``kind`` says what is made of them (`haul_ros.studies.kinds.table.KINDS`). ``fitted`` has the values of
    the cases whose claims the parameters were fitted to; none: what comes out was in no fit. ``quantity`` is what a map
    shows, ``trends`` what it is judged by.
    """

    name: str
    description: str
    scenarios: tuple[str, ...]
    overrides: Mapping[str, object] = field(default_factory=dict)
    axes: tuple[Axis, ...] = ()
    draws: tuple[Draw, ...] = ()
    samples: int = 0
    seed: int = 0
    paper: tuple[PaperValues, ...] = ()
    fitted: tuple[Mapping[str, object], ...] = ()
    kind: str = "sweep"
    quantity: str = "force"
    trends: tuple[Trend, ...] = ()

    def __post_init__(self) -> None:
        if self._size() > MOST_CASES:
            raise StudyError(_TOO_MANY)
        if len(self.draws) * self.samples > MOST_DRAWN:
            raise StudyError(f"more than {MOST_DRAWN} drawn values: fewer draws or samples are needed")

    def __len__(self) -> int:
        return self._size()

    def _size(self) -> int:
        return len(self.scenarios) * math.prod(len(axis.points) for axis in self.axes) * max(self.samples, 1)

    def cases(self) -> Iterator[Case]:
        """All cases, one by one."""
        samples = self._samples()
        for scenario in self.scenarios:
            for points in itertools.product(*(axis.points for axis in self.axes)):
                if not self.draws:
                    yield self._case(scenario, points)
                for number, row in enumerate(samples):
                    yield self._case(scenario, points, (_sample_point(number + 1, self.draws, row),))

    def paper_values(self, case: Case) -> PaperValues:
        """What the paper says on a case: the first that fits."""
        return next((values for values in self.paper if has_values(case, values.where)), PaperValues())

    def in_fit(self, *cases: Case) -> bool:
        """Whether a claim on these cases, all without any, was in the fit of the parameters."""
        return any(has_values(case, where) for case in cases or self.cases() for where in self.fitted)

    def check(self) -> tuple[str, ...]:
        """Refuse what cannot be, before anything runs: loads the points of every axis, the others at their first.

        Returns the statements of those loaded on fitted, assumed and changed data, as `Scenario.caveats`.

        Raises
        ------
        HaulError
            An unknown key or a value out of range, in one line.
        """
        samples = self._samples()
        last = (_sample_point(1, self.draws, samples[0]),) if self.draws else ()
        base = [axis.points[0] for axis in self.axes]
        caveats: dict[str, None] = {}
        for scenario in self.scenarios:
            caveats |= dict.fromkeys(self._case(scenario, tuple(base), last).load().caveats)
            for number, axis in enumerate(self.axes):
                rest = axis.points[1:] if len(axis.points) <= _CHECK_ALL else axis.points[-1:]
                for point in rest:
                    case = self._case(scenario, (*base[:number], point, *base[number + 1 :]), last)
                    caveats |= dict.fromkeys(case.load().caveats)
        return tuple(caveats)

    def _samples(self) -> NDArray[np.float64]:
        """Drawn values (samples, draws); one generator per draw, so that more of them change nothing in the others."""
        columns = []
        for number, draw in enumerate(self.draws):
            generator = np.random.default_rng([self.seed, number])
            law = generator.uniform if draw.distribution == "uniform" else generator.normal
            columns.append(law(*draw.parameters, size=self.samples))
        return np.array(columns).T

    def _case(self, scenario: str, points: tuple[Point, ...], drawn: tuple[Point, ...] = ()) -> Case:
        every = points + drawn
        names = [Path(scenario).stem] if len(self.scenarios) > 1 or not every else []
        overrides = dict(self.overrides)
        values: dict[str, object] = {}
        for point in every:
            overrides |= point.overrides
            values |= point.values
        return Case(", ".join([*names, *(point.name for point in every)]), scenario, overrides, values)


def _sample_point(number: int, draws: tuple[Draw, ...], row: NDArray[np.float64]) -> Point:
    values: dict[str, object] = {draw.key: float(value) for draw, value in zip(draws, row, strict=True)}
    return Point(f"sample {number}", {"sample": number, **values}, values)


def bounded_axes(specs: Iterable[Spec], make: Callable[[Spec, int], Axis]) -> tuple[Axis, ...]:
    """One axis after the other, made of no more points than `MOST_CASES` leaves room for; else StudyError.

    So many long axes are refused before they fill the memory.
    """
    axes, most = [], MOST_CASES
    for spec in specs:
        axis = make(spec, most)
        axes.append(axis)
        most //= max(len(axis.points), 1)
    return tuple(axes)


def list_axis(key: str, values: list[object], most: int = MOST_CASES) -> Axis:
    """A key over given values, ``most`` of them."""
    if not values:
        raise StudyError(f"over {key}: no values, expected at least one")
    if len(values) > most:
        raise StudyError(_TOO_MANY)
    return Axis(key, tuple(Point(f"{key}={_short(value)}", {key: value}, {key: value}) for value in values))


def _short(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def variants_axis(name: str, variants: Mapping[str, Mapping[str, object]]) -> Axis:
    """Named sets of overrides."""
    return Axis(
        name, tuple(Point(variant, {name: variant, **overrides}, overrides) for variant, overrides in variants.items())
    )


def range_values(key: str, first: float, last: float, step: float | None, count: int | None) -> list[object]:
    """Values from the first to the last, both included, by step or count.

    Raises
    ------
    StudyError
        Not exactly one of step and count, an empty range, or one without end.
    """
    where = f"over {key}: from {first:g} to {last:g}"
    if (step is None) == (count is None):
        raise StudyError(f"{where}: expected a step or a count, one of them")
    if not all(map(math.isfinite, (first, last, step or 0.0))):
        raise StudyError(f"{where}: must be finite numbers")
    if count is None:
        assert step is not None
        if step == 0.0 or (last - first) / step < 0.0:
            raise StudyError(f"{where} by {step:g}: an empty range, expected a step towards the end")
        count = math.floor(min((last - first) / step, 2.0 * MOST_VALUES) * (1.0 + _WHOLE) + _WHOLE) + 1
    else:
        if count < 2:
            raise StudyError(f"{where}: count {count}, must be 2 or more")
        step = (last - first) / (count - 1)
    if count > MOST_VALUES:
        raise StudyError(f"{where}: more than {MOST_VALUES} values")
    # 12 digits: 0.1 + 2 * 0.1 is meant to be 0.3
    values = [float(f"{first + n * step:.12g}") for n in range(count)]
    whole = all(value.is_integer() for value in values)
    return [int(value) if whole else value for value in values]
