"""Sessions: the same commands give the same arrays, and commands, radio and brake waves act when they should."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import AppliedBrake, PeriodLog
from haul_ros.model.radio import RadioLink, RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import FloatArray, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.model.track import Track
from haul_ros.scenario.loader import load_scenario
from haul_ros.simulation.session import Session
from haul_ros.units import seconds_to_ns
from tests.simulation.log_entries import commands, of_kind

# Locomotive + 10 wagons + 2 locomotives + 10 wagons + locomotive, service waves 200 m/s, release 150, emergency 220.
SMALL = load_scenario("daqin_1_2_1", {"consist.1.count": 10, "consist.3.count": 10})
SLAVES = ("slave_1", "slave_2", "slave_3")
FULL_SERVICE = SMALL.brakes.full_service


def brake(demand: float, locomotive: str = "master") -> Command:
    return Command(locomotive, CommandKind.BRAKE, demand)


def emergency(value: float = 1.0, locomotive: str = "master") -> Command:
    return Command(locomotive, CommandKind.EMERGENCY, value)


def traction(force: float, locomotive: str = "master") -> Command:
    return Command(locomotive, CommandKind.TRACTION, force)


def scenario(*plan: tuple[float, Command], base: Scenario = SMALL, **changes: object) -> Scenario:
    timed = tuple(TimedRequest(seconds_to_ns(time), command) for time, command in plan)
    return replace(base, commands=timed, **changes)  # type: ignore[arg-type]


def links(**changes: RadioLink) -> dict[str, RadioLink]:
    return {slave: changes.get(slave, RadioLink()) for slave in SLAVES}


def fractions(session: Session) -> FloatArray:
    """Cylinder pressures over those in emergency."""
    full = np.array([v.cylinder_pressure for v in session.consist.vehicles])
    return np.asarray(session.sample().cylinder_pressure / full)


def assert_same(one: Sample, other: Sample) -> None:
    for field in fields(Sample):
        np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name), err_msg=field.name)


def run_to_rest(session: Session) -> Session:
    while not session.finished:
        session.advance()
    return session


def applied_times(session: Session) -> dict[str, float]:
    """When each locomotive last changed what it applies [s]."""
    return {entry.locomotive: entry.time_ns / 1e9 for entry in of_kind(AppliedBrake, session.take_log())}


JITTERY = {slave: RadioLink(delay=0.3, jitter=0.5, loss_probability=0.2) for slave in SLAVES}
PLAN = (
    (0.0, brake(0.2)),
    (0.5013, brake(0.6, "slave_2")),
    (1.7, brake(0.35)),
    (2.0, brake(0.0, "slave_1")),
    (2.2, traction(200e3, "slave_1")),
    (3.0, emergency()),
)


# -- repeatability ---------------------------------------------------------------------------------------------------


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


def test_a_log_begins_with_every_link_and_every_brake_released() -> None:
    session = Session(scenario(radio=JITTERY))
    assert session.take_log().entries == (
        *(TimedRequest(0, RadioLinkChange(slave, 0.3, 0.5, 0.2, True)) for slave in SLAVES),
        *(AppliedBrake(0, name, 0.0) for name in ("master", *SLAVES)),
    )
    assert session.take_log().entries == ()


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (brake(0.5, "slave_9"), r"slave_9: no such locomotive, this train has master, slave_1, slave_2, slave_3"),
        (brake(float("nan")), "finite"),
        (brake(float("inf")), "finite"),
        (brake(1.01), r"0 \(release\) to 1 \(full\)"),
        (brake(-0.1), r"0 \(release\) to 1 \(full\)"),
        (emergency(0.5), "emergency = 0.5"),
        (traction(-1.0), "0 or more"),
        (traction(627.9e3, "slave_2"), "at most 627800"),
        (emergency(0.0), "at standstill only"),
    ],
)
def test_a_refused_command_changes_nothing(command: Command, message: str) -> None:
    case = scenario(radio=JITTERY)
    disturbed, calm = Session(case), Session(case)
    for session in (disturbed, calm):
        session.request(brake(0.3))
        session.request(emergency())
        session.advance(500)
    with pytest.raises(CommandError, match=message) as refusal:
        disturbed.request(command)
    assert "\n" not in str(refusal.value)
    for session in (disturbed, calm):
        session.request(brake(0.8, "slave_1"))  # draws from the radio's generator
    assert_same(disturbed.advance(3000), calm.advance(3000))
    assert disturbed.status() == calm.status()
    assert disturbed.take_log().entries == calm.take_log().entries


# -- radio -----------------------------------------------------------------------------------------------------------


def test_the_master_acts_at_once_and_each_slave_after_its_own_delay() -> None:
    delays = {"slave_1": 0.25, "slave_2": 1.0004, "slave_3": 3.0}
    radio = {slave: RadioLink(delay=delay) for slave, delay in delays.items()}
    session = Session(scenario((0.1, emergency()), radio=radio), play_commands=True)
    session.advance(4000)
    assert applied_times(session) == {
        "master": pytest.approx(0.1),
        **{slave: pytest.approx(0.1 + delay) for slave, delay in delays.items()},
    }


def test_a_late_slave_starts_its_own_wave_at_the_exact_time_of_arrival() -> None:
    # Slave 3, at the rear, hears it 1.0004 s later; the master's wave takes 1.7 s to get there.
    session = Session(
        scenario((0.0, emergency()), radio=links(slave_3=RadioLink(delay=1.0004), slave_2=DOWN, slave_1=DOWN)),
        play_commands=True,
    )
    session.advance(1300)
    assert fractions(session)[-1] == pytest.approx((1.3 - 1.0004) / 2.0, abs=1e-9)


DOWN = RadioLink(connected=False)


def test_a_command_to_a_slave_goes_to_it_alone_and_by_radio() -> None:
    session = Session(scenario(radio={slave: RadioLink(delay=0.5) for slave in SLAVES}))
    session.take_log()
    session.request(brake(0.4, "slave_2"))
    session.advance(2000)
    (applied,) = of_kind(AppliedBrake, session.take_log())
    assert (applied.locomotive, applied.value) == ("slave_2", 0.4)
    assert applied.time_ns == 500_000_000


def test_a_slave_without_radio_holds_and_brakes_when_the_wave_in_the_pipe_comes() -> None:
    session = Session(scenario((0.0, emergency()), radio=dict.fromkeys(SLAVES, DOWN)), play_commands=True)
    offsets = np.array(session.consist.centre_offsets)
    arrivals = (offsets - offsets[0]) / SMALL.brakes.wave_speeds.emergency
    session.advance(1000)
    np.testing.assert_allclose(fractions(session), np.clip((1.0 - arrivals) / 2.0, 0.0, 1.0), atol=1e-9)
    session.advance(3000)
    assert np.all(fractions(session) > 0.0)
    # Of its own accord it applies nothing.
    assert set(applied_times(session)) == {"master", *SLAVES}
    assert session.status().radio["slave_1"].connected is False
    assert session.status().radio["slave_1"].lost == 1


def test_a_slave_whose_link_fails_holds_the_brake_that_it_has() -> None:
    session = Session(scenario())
    session.request(brake(0.5))
    session.advance(3000)
    session.request(RadioLinkChange.to("slave_3", DOWN))
    session.take_log()
    session.request(brake(0.8))
    session.advance(1000)
    assert set(applied_times(session)) == {"master", "slave_1", "slave_2"}
    assert session.radio_link("slave_3") == DOWN


def test_a_slave_that_has_lost_its_link_stops_pulling_when_the_emergency_wave_reaches_it() -> None:
    session = Session(scenario(initial_speed=5.0))
    session.request(traction(400e3))
    session.advance(1000)
    for slave in SLAVES:
        session.request(RadioLinkChange.to(slave, DOWN))
    session.request(emergency())
    session.advance(3000)  # the wave has passed the whole train
    work = session.energy().traction_work
    session.advance(500)
    assert session.energy().traction_work == work


# -- brakes ----------------------------------------------------------------------------------------------------------


def test_partial_demands_travel_as_waves_and_end_at_their_share_of_full_service() -> None:
    session = Session(scenario(radio=dict.fromkeys(SLAVES, DOWN)))
    offsets = np.array(session.consist.centre_offsets)
    session.request(brake(0.5))
    session.advance(1000)
    np.testing.assert_array_equal(fractions(session) > 0.0, (offsets - offsets[0]) / 200.0 < 1.0)
    session.advance(19_000)
    np.testing.assert_allclose(fractions(session), 0.5 * FULL_SERVICE, rtol=1e-12)
    session.request(brake(0.2))
    session.advance(1000)
    np.testing.assert_array_equal(
        fractions(session) < 0.5 * FULL_SERVICE * (1 - 1e-12), (offsets - offsets[0]) / 150.0 < 1.0
    )
    session.advance(19_000)
    np.testing.assert_allclose(fractions(session), 0.2 * FULL_SERVICE, rtol=1e-12)
    session.request(brake(0.0))
    session.advance(20_000)
    np.testing.assert_array_equal(fractions(session), 0.0)


def test_brakes_applied_again_soon_after_a_release_hold_the_whole_train() -> None:
    session = Session(load_scenario("daqin_1_2_1"))
    session.request(brake(0.6))
    session.advance(15_000)
    session.request(brake(0.0))
    session.advance(2000)
    session.request(brake(0.6))
    session.advance(25_000)
    # The service wave, at 200 m/s, overtakes the release, at 150 m/s; the demand of every locomotive is 0.6.
    np.testing.assert_allclose(fractions(session), 0.6 * FULL_SERVICE, rtol=1e-12)


def test_an_emergency_is_latched_until_it_is_ended_at_standstill() -> None:
    session = Session(scenario())
    session.request(emergency())
    session.advance(3000)
    session.request(brake(0.0))
    with pytest.raises(CommandError, match="standstill"):
        session.request(emergency(0.0))
    session.advance(5000)
    np.testing.assert_array_equal(fractions(session), 1.0)
    while not session.at_standstill:
        session.advance()
    session.request(brake(0.0))
    session.advance(5000)
    np.testing.assert_array_equal(fractions(session), 1.0)
    session.take_log()
    session.request(emergency(0.0))
    assert {entry.locomotive: entry.value for entry in of_kind(AppliedBrake, session.take_log())} == {"master": 0.0}
    session.advance(40_000)
    np.testing.assert_array_equal(fractions(session), 0.0)
    assert session.at_standstill


def test_an_emergency_goes_on_while_any_locomotive_holds_it() -> None:
    session = Session(scenario(initial_speed=0.0))
    session.request(emergency())
    session.advance(5000)
    session.request(RadioLinkChange.to("slave_2", DOWN))
    session.request(emergency(0.0))
    session.advance(30_000)
    np.testing.assert_array_equal(fractions(session), 1.0)
    session.request(RadioLinkChange.to("slave_2", RadioLink()))
    session.request(emergency(0.0, "slave_2"))
    session.advance(30_000)
    np.testing.assert_array_equal(fractions(session), 0.0)


def test_an_emergency_that_is_ended_while_its_waves_still_run_leaves_no_brake_on() -> None:
    session = Session(load_scenario("daqin_1_2_1", {"initial_speed_kmh": 0}))
    session.request(emergency())
    session.advance(2000)
    session.request(emergency(0.0))
    session.advance(60_000)
    np.testing.assert_array_equal(fractions(session), 0.0)


def test_a_brake_demand_cuts_the_traction_of_its_locomotive() -> None:
    session = Session(scenario(initial_speed=5.0))
    session.request(traction(400e3))
    session.advance(1000)
    pulled = session.energy().traction_work
    assert pulled > 4 * 400e3 * 4.9
    session.request(brake(0.1))
    session.advance(1000)
    assert session.energy().traction_work == pytest.approx(pulled)
    session.request(traction(400e3))
    session.advance(1000)
    assert session.energy().traction_work == pytest.approx(pulled)


def test_the_brake_goes_to_the_strongest_of_many_demands_and_back() -> None:
    random = np.random.default_rng(5)
    session = Session(scenario(radio=JITTERY, initial_speed=30.0))
    for _ in range(1500):
        session.request(brake(float(random.random()), str(random.choice(["master", *SLAVES]))))
        session.advance(2)
    for slave in SLAVES:
        session.request(RadioLinkChange.to(slave, RadioLink()))
    session.request(brake(0.0))
    session.advance(3000)
    session.request(brake(1.0))
    session.advance(20_000)
    np.testing.assert_allclose(fractions(session), FULL_SERVICE, rtol=1e-12)
    assert session.status().solver.unconverged_steps == 0


# -- the end ---------------------------------------------------------------------------------------------------------


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


def test_a_log_has_the_sample_of_an_instant_once_and_the_extremes_once_a_second_and_at_the_end() -> None:
    session = Session(SMALL)
    first, again = session.take_log(), session.take_log()
    assert first.sample is not None
    assert (first.time_ns, first.sample.step, first.extremes is None) == (0, 0, False)
    assert (again.time_ns, again.entries, again.sample, again.extremes) == (0, (), None, None)
    found = []
    for steps in (999, 1, 1, 1200, 1):
        sample = session.advance(steps)
        log = session.take_log()
        assert log.sample is not None
        assert_same(log.sample, sample)
        found.append(log.extremes is not None)
    assert found == [False, True, False, True, False]
    assert session.take_log().extremes is None
    end = session.take_log(last=True)
    assert end.sample is None
    assert end.extremes is not None
    np.testing.assert_array_equal(end.extremes.compression, session.extremes().compression)
    assert session.take_log(last=True).extremes is None
    session.advance(1)
    whole = session.take_log(last=True)
    assert whole.sample is not None
    assert whole.extremes is not None


def test_entries_are_in_order_of_time_and_a_request_stands_before_its_effects() -> None:
    session = Session(scenario(radio=links(slave_1=RadioLink(delay=0.0104), slave_2=DOWN, slave_3=DOWN)))
    session.advance(10)
    session.take_log()
    session.request(RadioLinkChange("slave_2", connected=True))
    session.request(RadioLinkChange("slave_2", connected=False))
    session.request(brake(0.5))
    session.request(emergency())
    at_once = session.take_log()
    at_ns = 10_000_000
    radio = EventKind.RADIO
    assert at_once.sample is None
    assert at_once.entries == (
        TimedRequest(at_ns, RadioLinkChange("slave_2", connected=True)),
        Event(at_ns, radio, "slave_2: radio link up"),
        TimedRequest(at_ns, RadioLinkChange("slave_2", connected=False)),
        Event(at_ns, radio, "slave_2: radio link down"),
        TimedRequest(at_ns, brake(0.5)),
        AppliedBrake(at_ns, "master", 0.5),
        Event(at_ns, radio, "slave_2: telegram lost: brake 0.5"),
        Event(at_ns, radio, "slave_3: telegram lost: brake 0.5"),
        TimedRequest(at_ns, emergency()),
        AppliedBrake(at_ns, "master", 1.0),
        Event(at_ns, EventKind.EMERGENCY, "master: emergency latched"),
        Event(at_ns, radio, "slave_2: telegram lost: emergency 1"),
        Event(at_ns, radio, "slave_3: telegram lost: emergency 1"),
    )
    session.advance(2000)
    later = session.take_log().entries
    assert later[:3] == (
        AppliedBrake(20_400_000, "slave_1", 0.5),
        AppliedBrake(20_400_000, "slave_1", 1.0),
        Event(20_400_000, EventKind.EMERGENCY, "slave_1: emergency latched"),
    )
    assert [entry.time_ns for entry in later] == sorted(entry.time_ns for entry in later)
    assert any(isinstance(entry, Event) and entry.kind is EventKind.WAVE for entry in later)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (RadioLinkChange("master", delay=1.0), "master: no such slave locomotive, this train has slave_1, slave_2"),
        (RadioLinkChange("slave_1", delay=float("nan")), "slave_1: .* delay and jitter must be finite"),
        (RadioLinkChange("slave_1", connected=False, loss_probability=1.1), "slave_1: .* loss_probability 0 to 1"),
    ],
)
def test_a_refused_change_of_a_link_changes_nothing(change: RadioLinkChange, message: str) -> None:
    session = Session(scenario(radio=JITTERY))
    session.take_log()
    with pytest.raises(CommandError, match=message):
        session.request(change)
    assert session.take_log().entries == ()
    assert [session.radio_link(slave) for slave in SLAVES] == list(JITTERY.values())
