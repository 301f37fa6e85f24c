from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.log import AppliedBrake
from haul_ros.model.request import TimedRequest
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario, load_scenario_text
from haul_ros.simulation.batch import RunError, periods, share_done
from haul_ros.simulation.session import Session
from tests.simulation.log_entries import commands, of_kind, samples

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
    logs = list(periods(session))
    states = samples(logs)
    assert [log.time_ns for log in logs] == [sample.time_ns for sample in states]
    assert [log.time_ns for log in logs] == [n * PERIOD for n in range(len(logs))]
    assert session.finished
    assert session.stop_time is not None
    assert logs[-1].time_ns == session.time_ns
    assert not states[-1].speed.any()
    assert states[-2].speed.any()


def test_commands_and_applied_brakes_are_logged_in_the_period_of_their_time(scenario: Scenario) -> None:
    logs = list(periods(Session(scenario, play_commands=True)))
    (commanded,) = (log for log in logs if commands(log))
    assert commands(commanded) == [(SECOND // 2, Command("master", CommandKind.EMERGENCY, 1.0))]
    assert commanded.time_ns == SECOND // 2 + PERIOD
    assert of_kind(AppliedBrake, *logs) == [
        AppliedBrake(0, "master", 0.0),
        AppliedBrake(0, "slave_1", 0.0),
        AppliedBrake(SECOND // 2, "master", 1.0),
        AppliedBrake(SECOND * 1503 // 1000, "slave_1", 1.0),
    ]
    for before, log in pairwise(logs):
        for entry in log.entries:
            assert before.time_ns <= entry.time_ns <= log.time_ns


def test_extremes_are_logged_at_the_start_every_second_and_at_the_end(scenario: Scenario) -> None:
    session = Session(scenario, play_commands=True)
    found = [(log.time_ns, log.extremes) for log in periods(session) if log.extremes]
    times = [time for time, _ in found]
    assert times[:-1] == [n * SECOND for n in range(len(times) - 1)]
    assert times[-1] == session.time_ns
    last = found[-1][1]
    assert last is not None
    np.testing.assert_array_equal(last.compression, session.extremes().compression)


def test_a_run_that_is_to_stop_ends_with_its_present_period_and_the_extremes(scenario: Scenario) -> None:
    session = Session(scenario, play_commands=True)
    logs = list(periods(session, lambda: session.time_ns >= 3 * PERIOD))
    assert len(logs) == 4
    assert logs[-1].extremes is not None
    assert session.time_ns == 3 * PERIOD


def test_a_command_of_the_scenario_that_cannot_be_carried_out_ends_the_run_with_its_time(scenario: Scenario) -> None:
    too_early = TimedRequest(SECOND, Command("master", CommandKind.EMERGENCY, 0.0))
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


@pytest.mark.parametrize(("rate", "duration"), [(0.1, 2.5), (50.0, 0.005), (10.0, 0.25), (50.0, 0.3)])
def test_the_longest_duration_ends_a_run_within_its_sample_period(rate: float, duration: float) -> None:
    scenario = load_scenario("daqin_1_1_0", {"sample_rate_hz": rate, "max_duration_s": duration, "commands": []})
    logs = list(periods(Session(scenario)))
    assert logs[-1].time_ns == round(duration * SECOND)
    assert logs[-1].sample is not None
    assert logs[-1].extremes is not None


def test_a_period_of_a_hundred_thousand_steps_can_be_stopped_in_its_middle() -> None:
    scenario = load_scenario("daqin_1_1_0", {"sample_rate_hz": 0.1, "time_step_ms": 0.01, "commands": []})
    session = Session(scenario)
    asked: list[int] = []

    def third_time() -> bool:
        asked.append(session.step)
        return len(asked) >= 3

    logs = list(periods(session, third_time))
    assert 0 < session.step < 100_000
    assert logs[-1].time_ns == session.time_ns
