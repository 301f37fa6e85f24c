"""Figures of the loop's timing."""

from __future__ import annotations

import pytest

from haul_ros.ros.timing import TimingWindow

MS = 1_000_000


def test_a_report_gives_the_figures_of_its_window() -> None:
    window = TimingWindow(now_ns=100 * MS, simulation_time_ns=0)
    window.period(steps=20, busy_ns=1 * MS, lateness_ns=2 * MS, missed=0)
    window.period(steps=20, busy_ns=3 * MS, lateness_ns=1 * MS, missed=0)
    timing = window.report(now_ns=150 * MS, simulation_time_ns=40 * MS)
    assert timing.real_time_factor == pytest.approx(0.8)
    assert timing.step_time_mean == pytest.approx(100e-6)
    assert timing.step_time_max == pytest.approx(150e-6)
    assert timing.lateness_max == pytest.approx(2e-3)
    assert (timing.overruns, timing.missed_periods, timing.missed_now) == (0, 0, 0)


def test_overruns_are_counted_since_the_start_and_told_once_as_new() -> None:
    window = TimingWindow(0, 0)
    window.period(20, MS, 0, missed=6)
    window.period(20, MS, 0, missed=7)
    first = window.report(1000 * MS, 40 * MS)
    second = window.report(2000 * MS, 40 * MS)
    assert (first.overruns, first.missed_periods, first.missed_now) == (2, 13, 13)
    assert (second.overruns, second.missed_periods, second.missed_now) == (2, 13, 0)


def test_a_window_in_which_nothing_ran_has_the_real_time_factor_zero() -> None:
    window = TimingWindow(0, 5 * MS)
    timing = window.report(1000 * MS, 5 * MS)
    assert timing.real_time_factor == 0.0
    assert timing.step_time_mean == timing.step_time_max == 0.0
