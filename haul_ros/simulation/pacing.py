"""When the next period of a paced simulation is due: arithmetic on given times, no clock, no sleeping."""

from __future__ import annotations

from dataclasses import dataclass

MAX_PERIODS_BEHIND = 5


@dataclass(frozen=True, slots=True)
class Pace:
    """When the next period is due [ns, monotonic clock] and how many whole periods were given up to get there."""

    deadline_ns: int
    missed: int


def wall_period(period_ns: int, real_time_factor: float) -> int:
    """Wall time [ns] for ``period_ns`` of simulation at a real-time factor; 0 for the factor 0, as fast as possible."""
    return round(period_ns / real_time_factor) if real_time_factor > 0.0 else 0


def next_deadline(deadline_ns: int, now_ns: int, period_ns: int, max_behind: int = MAX_PERIODS_BEHIND) -> Pace:
    """Deadline that follows ``deadline_ns``, seen at ``now_ns``.

    Deadlines are absolute, so a late period is caught up by shorter waits. More than ``max_behind``
    periods behind, all periods that have passed whole are missed instead of run in a burst: wall
    time is dropped, and the phase of the deadlines kept. A ``period_ns`` of 0 is due at once.
    """
    if period_ns == 0:
        return Pace(now_ns, 0)
    following = deadline_ns + period_ns
    behind = (now_ns - following) // period_ns
    if behind <= max_behind:
        return Pace(following, 0)
    return Pace(following + behind * period_ns, behind)
