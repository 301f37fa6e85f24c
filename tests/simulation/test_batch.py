from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from haul_ros.model.command import Command, CommandKind, TimedCommand
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.batch import RunError, periods, share_done
from haul_ros.simulation.session import Session

SECOND = 10**9
PERIOD = SECOND // 50


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    text = """\
description: short train, emergency from 20 km/h
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 4}
  - {vehicle: SS4, role: slave}
coupler: paper_set_b
brakes: paper_set_b
initial_speed_kmh: 20
max_duration_s: 60
radio: {default: {delay_s: 1.003}}
commands:
  - {at_s: 0.5, locomotive: master, emergency: true}
"""
    return load_scenario_text(text, "short_train")


def test_a_run_begins_before_the_first_step_and_ends_with_the_session(scenario: Scenario) -> None:
    session = Session(scenario, play_commands=True)
    told = list(periods(session))
    assert [period.sample.time_ns for period in told] == [n * PERIOD for n in range(len(told))]
    assert session.finished
    assert session.stop_time is not None
    assert told[-1].sample.time_ns == session.time_ns
    assert not told[-1].sample.speed.any()
    assert told[-2].sample.speed.any()


def test_commands_and_applied_brakes_are_told_in_the_period_of_their_time(scenario: Scenario) -> None:
    told = list(periods(Session(scenario, play_commands=True)))
    (commanded,) = (period for period in told if period.commands)
    assert [(taken.time_ns, taken.command) for taken in commanded.commands] == [
        (SECOND // 2, Command("master", CommandKind.EMERGENCY, 1.0))
    ]
    assert commanded.sample.time_ns == SECOND // 2 + PERIOD
    applied = [change for period in told for change in period.applied_brakes]
    assert [(a.time_ns, a.locomotive, a.value) for a in applied] == [
        (0, "master", 0.0),
        (0, "slave_1", 0.0),
        (SECOND // 2, "master", 1.0),
        (SECOND * 1503 // 1000, "slave_1", 1.0),
    ]
    for before, period in pairwise(told):
        for change in period.applied_brakes:
            assert before.sample.time_ns <= change.time_ns <= period.sample.time_ns


def test_extremes_are_told_at_the_start_every_second_and_at_the_end(scenario: Scenario) -> None:
    session = Session(scenario, play_commands=True)
    told = [(p.sample.time_ns, p.extremes) for p in periods(session) if p.extremes]
    times = [time for time, _ in told]
    assert times[:-1] == [n * SECOND for n in range(len(times) - 1)]
    assert times[-1] == session.time_ns
    last = told[-1][1]
    assert last is not None
    np.testing.assert_array_equal(last.compression, session.extremes().compression)


def test_a_run_that_is_to_stop_ends_with_its_present_period_and_the_extremes(scenario: Scenario) -> None:
    answers = iter([False, False, False, True])
    session = Session(scenario, play_commands=True)
    told = list(periods(session, lambda: next(answers)))
    assert len(told) == 4
    assert told[-1].extremes is not None
    assert session.time_ns == 3 * PERIOD


def test_a_command_of_the_scenario_that_cannot_be_carried_out_ends_the_run_with_its_time(scenario: Scenario) -> None:
    too_early = TimedCommand(1.0, Command("master", CommandKind.EMERGENCY, 0.0))
    session = Session(replace(scenario, commands=(*scenario.commands, too_early)), play_commands=True)
    with pytest.raises(RunError, match=r"short_train: at 1\.000 s: master: an emergency .* ends at standstill only"):
        list(periods(session))


def test_the_share_done_is_that_of_speed_shed_or_of_time_used_up(scenario: Scenario) -> None:
    sample = Session(scenario).sample()
    assert share_done(scenario, sample) == 0.0
    assert share_done(scenario, replace(sample, time_ns=15 * SECOND)) == 0.25
    assert share_done(scenario, replace(sample, speed=sample.speed / 2)) == pytest.approx(0.5)
    assert share_done(scenario, replace(sample, speed=sample.speed * 2)) == 0.0
    assert share_done(replace(scenario, initial_speed=0.0), sample) == 0.0
    assert share_done(scenario, replace(sample, time_ns=90 * SECOND)) == 1.0
