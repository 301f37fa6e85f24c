"""Deadline arithmetic: absolute, bounded catch-up, phase kept."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haul_ros.simulation.pacing import Pace, next_deadline, wall_period

PERIOD = 20_000_000


def test_a_period_on_time_is_followed_by_the_next_absolute_deadline() -> None:
    assert next_deadline(1000, 1000 + PERIOD // 3, PERIOD) == Pace(1000 + PERIOD, 0)


def test_a_late_period_does_not_shift_the_deadlines_after_it() -> None:
    assert next_deadline(0, PERIOD + 7, PERIOD) == Pace(PERIOD, 0)


def test_up_to_five_periods_behind_every_period_is_caught_up() -> None:
    assert next_deadline(0, 6 * PERIOD + PERIOD - 1, PERIOD) == Pace(PERIOD, 0)


def test_more_than_five_periods_behind_whole_periods_are_missed_and_the_phase_kept() -> None:
    assert next_deadline(3, 3 + 7 * PERIOD + 11, PERIOD) == Pace(3 + 7 * PERIOD, 6)


def test_the_bound_of_catching_up_can_be_chosen() -> None:
    assert next_deadline(0, 2 * PERIOD, PERIOD, max_behind=0) == Pace(2 * PERIOD, 1)


def test_as_fast_as_possible_is_due_at_once_and_never_misses() -> None:
    assert next_deadline(0, 123_456_789, 0) == Pace(123_456_789, 0)


@pytest.mark.parametrize(("factor", "expected"), [(1.0, PERIOD), (2.0, PERIOD // 2), (0.5, 2 * PERIOD), (0.0, 0)])
def test_the_real_time_factor_divides_the_period_and_zero_means_no_waiting(factor: float, expected: int) -> None:
    assert wall_period(PERIOD, factor) == expected


@given(
    deadline=st.integers(0, 10**15),
    lateness=st.integers(-(10**9), 10**12),
    period=st.integers(1, 10**10),
    max_behind=st.integers(0, 10),
)
def test_deadlines_grow_stay_on_the_grid_and_account_for_every_period(
    deadline: int, lateness: int, period: int, max_behind: int
) -> None:
    now = deadline + lateness
    pace = next_deadline(deadline, now, period, max_behind)
    assert pace.deadline_ns == deadline + (1 + pace.missed) * period
    assert now < pace.deadline_ns + (max_behind + 1) * period
    assert pace.missed == 0 or pace.deadline_ns <= now < pace.deadline_ns + period
