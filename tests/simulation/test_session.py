"""Sessions: the same requests give the same arrays, and a run ends when nothing is to come."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.model.log import AppliedBrake, PeriodLog
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.model.track import Track
from haul_ros.scenario.loader import load_scenario
from haul_ros.simulation.session import Session
from haul_ros.units import seconds_to_ns
from tests.simulation.log_entries import commands, of_kind
from tests.simulation.session_cases import (
    JITTERY,
    PLAN,
    SMALL,
    applied_times,
    assert_same,
    brake,
    emergency,
    run_to_rest,
    scenario,
    traction,
)


@settings(deadline=None, max_examples=15)
@given(chunks=st.lists(st.integers(0, 900), min_size=1, max_size=12))
def test_the_grouping_of_steps_changes_no_bit(chunks: list[int]) -> None:
    case = scenario(*PLAN, radio=JITTERY)
    whole, pieces = Session(case, play_commands=True), Session(case, play_commands=True)
    for steps in chunks:
        pieces.advance(steps)
    end = max(pieces.step, 3500)
    pieces.advance(end - pieces.step)
    assert_same(whole.advance(end), pieces.sample())
    assert whole.take_log().entries == pieces.take_log().entries
    for field in fields(whole.extremes()):
        mine, other = (getattr(session.extremes(), field.name) for session in (whole, pieces))
        np.testing.assert_array_equal(mine, other)


def test_single_steps_and_one_long_run_give_the_same_bits_for_the_whole_train() -> None:
    one, other = (Session(load_scenario("daqin_1_2_1"), play_commands=True) for _ in range(2))
    for _ in range(1500):
        one.advance(1)
    assert_same(one.sample(), other.advance(1500))


def test_commands_given_live_act_like_those_of_the_scenario_at_the_same_steps() -> None:
    case = scenario(*PLAN, radio=JITTERY)
    played, live = Session(case, play_commands=True), Session(case)
    for time, command in PLAN:
        live.advance(int(np.ceil(time / case.time_step - 1e-6)) - live.step)
        live.request(command)
    live.advance(6000 - live.step)
    assert_same(played.advance(6000), live.sample())
    assert played.take_log().entries == live.take_log().entries


def test_what_was_logged_can_be_requested_again_bit_for_bit() -> None:
    live = Session(scenario(radio=JITTERY))
    live.advance(137)
    # Requests within one turn of a node's loop bear the same time; their order matters.
    for request in (
        brake(0.5),
        brake(0.0),
        RadioLinkChange("slave_1", jitter=0.9),
        traction(150e3),
        RadioLinkChange("slave_1", delay=0.1, jitter=0.0),
        RadioLinkChange("slave_2", loss_probability=1.0),
        brake(0.4),
    ):
        live.request(request)
    live.advance(900)
    live.request(RadioLinkChange("slave_2", loss_probability=0.0, connected=True))
    live.request(RadioLinkChange("slave_3", connected=False))
    live.request(emergency())
    live.advance(2000)
    log = live.take_log().entries
    links = len(JITTERY)
    again = Session(scenario(radio=JITTERY), requests=of_kind(TimedRequest, PeriodLog(0, log[links:])))
    assert_same(live.sample(), again.advance(live.step))
    assert again.take_log().entries == log
    unchanged = Session(
        scenario(radio=JITTERY), requests=[TimedRequest(*entry) for entry in commands(PeriodLog(0, log))]
    )
    unchanged.advance(live.step)
    assert of_kind(AppliedBrake, unchanged.take_log()) != of_kind(AppliedBrake, PeriodLog(0, log))


def test_a_request_is_due_again_at_the_step_at_which_it_was_logged_whatever_the_time_step() -> None:
    # A thirtieth of a millisecond is no whole number of nanoseconds: its stamps are rounded up and down.
    case = scenario(time_step=1e-3 / 30.0)
    for step in (1, 2, 3, 4, 5, 6, 7, 100, 1001, 59_999):
        time_ns = seconds_to_ns(step * case.time_step)
        session = Session(case, requests=[TimedRequest(time_ns, brake(0.5))])
        session.advance(step)
        assert commands(session.take_log()) == []
        session.advance(1)
        assert commands(session.take_log()) == [(time_ns, brake(0.5))]


def test_commands_of_the_same_time_are_given_in_the_order_in_which_they_are_written() -> None:
    plan = ((0.0, brake(0.5)), (1.0, brake(0.0)), (1.0, traction(100e3)))
    session = Session(scenario(*plan), play_commands=True)
    session.advance(2000)
    assert [command for _, command in commands(session.take_log())] == [command for _, command in plan]
    # Released first, the master may pull; the other way round its brake would have cut the traction.
    assert session.energy().traction_work > 0.0


def test_other_seeds_give_other_delays() -> None:
    runs = [run_to_rest(Session(scenario((0.0, emergency()), radio=JITTERY, radio_seed=seed), play_commands=True))
            for seed in (1, 1, 2)]  # fmt: skip
    first, again, other = (applied_times(run) for run in runs)
    assert first == again
    assert first != other


# -- commands --------------------------------------------------------------------------------------------------------


def test_a_command_between_two_steps_is_given_at_the_first_step_after_it() -> None:
    session = Session(scenario((0.5013, emergency()), (0.7, brake(0.0))), play_commands=True)
    session.advance(501)
    assert commands(session.take_log()) == []
    session.advance(1)  # the command acts in the step that begins at 0.502 s
    assert commands(session.take_log()) == []
    session.advance(1)
    assert commands(session.take_log()) == [(502_000_000, emergency())]


def test_a_run_is_finished_at_standstill_when_no_command_is_to_come() -> None:
    session = Session(scenario((0.0, emergency()), (200.0, emergency(0.0))), play_commands=True)
    while not session.at_standstill:
        assert not session.finished
        assert session.stop_time is None
        session.advance()
    stop = session.stop_time
    assert stop is not None
    assert session.time - 0.02 <= stop <= session.time
    assert not session.finished
    session.advance(200_000 - session.step)
    assert not session.finished
    run_to_rest(session)
    # As the brakes let go, couplers that were held under force move the train a little once more.
    assert session.stop_time is not None
    assert session.stop_time >= stop
    assert session.at_standstill


def test_a_run_is_finished_after_its_longest_duration() -> None:
    session = run_to_rest(Session(scenario(max_duration=2.0)))
    assert session.time == pytest.approx(2.0)
    assert not session.at_standstill


def test_a_run_is_not_finished_while_a_release_is_on_its_way_through_a_standing_train() -> None:
    grade = Track(0.0, ((-1e5, -0.02),))
    case = scenario((0.0, emergency()), (30.0, emergency(0.0)), initial_speed=1.0, track=grade, max_duration=60.0)
    session = run_to_rest(Session(case, play_commands=True))
    # Its brakes released, the train runs down the grade: the run ends with its time.
    assert session.time == pytest.approx(60.0)
    assert not session.at_standstill


def test_a_run_of_a_train_that_the_grade_sets_in_motion_is_not_finished_before_it_began() -> None:
    session = Session(scenario(initial_speed=0.0, track=Track(0.0, ((-1e5, -0.02),)), max_duration=5.0))
    assert not session.finished
    run_to_rest(session)
    assert session.time == pytest.approx(5.0)
    assert session.travelled > 1.0


def test_a_sample_period_is_a_whole_number_of_steps_and_time_is_counted() -> None:
    session = Session(SMALL)
    assert session.steps_per_sample == 20
    for n in range(1, 51):
        assert session.advance().time_ns == n * 20_000_000
    assert session.time_ns == 1_000_000_000


def test_samples_are_copies() -> None:
    session = Session(SMALL)
    sample = session.sample()
    before = sample.speed.copy()
    session.request(emergency())
    session.advance(5000)
    np.testing.assert_array_equal(sample.speed, before)


# -- log -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "copied", [copy.deepcopy, lambda session: pickle.loads(pickle.dumps(session))], ids=["deepcopy", "pickle"]
)
def test_a_copy_of_a_session_goes_on_by_itself_as_the_original_does(copied: Callable[[Session], Session]) -> None:
    session = Session(scenario((1.0, brake(0.5)), (3.0, emergency()), radio=JITTERY), play_commands=True)
    session.advance(1500)
    session.take_log()
    other = copied(session)
    samples = [session.advance(2500) for _ in range(2)]
    log = session.take_log()
    assert other.step == 1500
    for sample in samples:
        assert_same(other.advance(2500), sample)
    assert other.take_log().entries == log.entries
    assert any(isinstance(entry, AppliedBrake) for entry in log.entries)
    with pytest.raises(ValueError, match="read-only"):
        other._model.train.vehicle_parameters.mass[0] = 1.0
