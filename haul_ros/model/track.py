"""Grades and curves by chainage."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Track:
    """Line over which the train runs, as steps along the chainage [m], which grows forward.

    ``grades`` holds (chainage, grade [m/m], rising positive) and ``curves`` (chainage, curvature
    1/R [1/m], >= 0): each value holds from its chainage on to the next; before the first entry the
    line is level and straight. ``start_chainage`` [m] is where the head of the train stands at t = 0.
    """

    start_chainage: float = 0.0
    grades: tuple[tuple[float, float], ...] = ()
    curves: tuple[tuple[float, float], ...] = ()
