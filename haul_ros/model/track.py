"""Grades, curves and speed limits by chainage."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass

Steps = tuple[tuple[float, float], ...]
"""Values by chainage [m], in rising order: each holds from its chainage on to the next."""


def _chainage(step: tuple[float, float]) -> float:
    return step[0]


@dataclass(frozen=True, slots=True)
class Track:
    """Line over which the train runs, as steps along the chainage [m], which grows forward.

    ``grades`` holds (chainage, grade [m/m], rising positive), ``curves`` (chainage, curvature 1/R [1/m], >= 0) and
    ``speed_limits`` (chainage, speed [m/s], infinite: none): each value holds from its chainage on to the next; before
    the first entry the line is level and straight and has no limit. A change of grade is a linear ramp of
    ``grade_ramp`` [m] with its middle at the chainage of the change (a vertical curve, parabolic in height); 0: a step.
    ``start_chainage`` [m] is where the head of the train stands at t = 0.
    """

    start_chainage: float = 0.0
    grades: Steps = ()
    curves: Steps = ()
    grade_ramp: float = 0.0
    speed_limits: Steps = ()

    @property
    def grade_changes(self) -> Steps:
        """The entries of ``grades`` that differ from what holds before them."""
        changes: list[tuple[float, float]] = []
        before = 0.0
        for chainage, grade in self.grades:
            if grade != before:
                changes.append((chainage, grade))
            before = grade
        return tuple(changes)

    def speed_limit(self, chainage: float) -> float:
        """Speed limit at a chainage [m/s]; infinite: none."""
        index = bisect_right(self.speed_limits, chainage, key=_chainage) - 1
        return self.speed_limits[index][1] if index >= 0 else math.inf

    def lowest_speed_limit(self, rear: float, front: float) -> float:
        """Lowest speed limit [m/s] anywhere between two chainages: under a train, or on the way that lies ahead."""
        first = bisect_right(self.speed_limits, rear, key=_chainage)
        end = bisect_right(self.speed_limits, front, key=_chainage)
        return min([self.speed_limit(rear), *(limit for _, limit in self.speed_limits[first:end])])
