"""Speed limits of a line, looked up; changes of grade."""

from __future__ import annotations

import math

import pytest

from haul_ros.model.track import Track

LIMITS = ((0.0, 22.0), (1000.0, 19.0), (1500.0, 16.0), (1520.0, 19.0), (3000.0, math.inf))
TRACK = Track(speed_limits=LIMITS)


@pytest.mark.parametrize(
    ("chainage", "limit"),
    [(-1.0, math.inf), (0.0, 22.0), (999.9, 22.0), (1000.0, 19.0), (1510.0, 16.0), (2999.9, 19.0), (3000.0, math.inf)],
)
def test_a_limit_holds_from_its_chainage_on(chainage: float, limit: float) -> None:
    assert TRACK.speed_limit(chainage) == limit


@pytest.mark.parametrize(
    ("rear", "front", "limit"),
    [
        (-500.0, -1.0, math.inf),
        (-500.0, 0.0, 22.0),
        (0.0, 999.0, 22.0),
        (900.0, 1000.0, 19.0),
        (900.0, 2500.0, 16.0),  # one that lies wholly between both
        (1519.9, 2500.0, 16.0),  # its last part, under the rear alone
        (1520.0, 2500.0, 19.0),
        (3000.0, 9000.0, math.inf),
    ],
)
def test_the_lowest_limit_is_that_of_any_place_under_the_train(rear: float, front: float, limit: float) -> None:
    assert TRACK.lowest_speed_limit(rear, front) == limit


def test_a_line_without_limits_has_none_anywhere() -> None:
    assert Track().speed_limit(0.0) == Track().lowest_speed_limit(-1e7, 1e7) == math.inf


def test_entries_that_repeat_a_grade_change_nothing() -> None:
    track = Track(grades=((0.0, 0.0), (100.0, 0.004), (200.0, 0.004), (300.0, 0.0), (400.0, 0.0)))
    assert track.grade_changes == ((100.0, 0.004), (300.0, 0.0))
