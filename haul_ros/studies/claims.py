"""Claims of the paper on computed cases, and how their numbers are written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from haul_ros.studies.case import CaseResult

TOLERANCE = 0.03
"""Relative, against numbers that the text gives as "about"."""


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim of the paper, whether it holds (None: it cannot be decided, or there is none), and by how much.

    ``fitted``: the parameters were fitted to it, so that its holding is no prediction.
    """

    text: str
    holds: bool | None
    found: str
    fitted: bool = False

    @property
    def verdict(self) -> str:
        """What a computation says on the claim."""
        if self.holds is None:
            return "result"
        if not self.holds:
            return "contradicted"
        return "reproduced (fitted)" if self.fitted else "predicted"

    def __str__(self) -> str:
        return f"{self.verdict}: {self.text}: {self.found}"


def peak(result: CaseResult) -> float:
    """Largest force of the whole train [N]."""
    return float(result.force.max())


def is_rising(values: Sequence[float]) -> bool:
    """Whether each value is above the one before."""
    return all(before < after for before, after in pairwise(values))


def about(what: str, paper: float, computed: float, fitted: bool) -> Claim:
    """The claim that a force [N] is about that of the paper's text."""
    found = f"{kn(computed)}, {percent(computed, paper)}"
    return Claim(f"{what} about {paper / 1e3:.0f} kN", abs(computed / paper - 1.0) <= TOLERANCE, found, fitted)


def relative(value: float, reference: float) -> float:
    """Change against a reference, which may be 0: trains that nothing pulls or brakes have no forces."""
    if reference == 0.0:
        return 0.0 if value == 0.0 else math.inf
    return value / reference - 1.0


def kn(force: float) -> str:
    """A force [N] in kN."""
    return f"{force / 1e3:.1f} kN"


def mm(stroke: float) -> str:
    """A stroke [m] in mm."""
    return f"{stroke * 1e3:.2f} mm"


def percent(value: float, reference: float) -> str:
    """Difference from a reference, with its sign."""
    return f"{relative(value, reference) * 100.0:+.1f} %"


def series(values: Sequence[float], unit: str, factor: float, digits: int = 1) -> str:
    """Values times a factor beside one another, with one unit."""
    return f"{'/'.join(f'{value * factor:.{digits}f}' for value in values)} {unit}"
