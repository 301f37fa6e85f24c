"""Sessions: the same commands give the same arrays, and commands, radio and brake waves act when they should."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind, TimedCommand
from haul_ros.model.radio import RadioLink
from haul_ros.model.sample import FloatArray, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.model.track import Track
from haul_ros.scenario.loader import load_scenario
from haul_ros.simulation.session import AppliedBrake, Session

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


def scenario(*commands: tuple[float, Command], base: Scenario = SMALL, **changes: object) -> Scenario:
    timed = tuple(TimedCommand(time, command) for time, command in commands)
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
    return {entry.locomotive: entry.time_ns / 1e9 for entry in session.take_applied_brakes()}


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
    assert whole.take_applied_brakes() == pieces.take_applied_brakes()
    assert whole.take_commands() == pieces.take_commands()
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
        live.command(command)
    live.advance(6000 - live.step)
    assert_same(played.advance(6000), live.sample())
    assert played.take_applied_brakes() == live.take_applied_brakes()
    assert played.take_commands() == live.take_commands()


def test_what_was_taken_can_be_played_again_bit_for_bit() -> None:
    live = Session(scenario(radio=JITTERY))
    live.advance(137)
    # Three commands within one turn of a node's loop bear the same time; their order matters.
    for command in (brake(0.5), brake(0.0), traction(150e3)):
        live.command(command)
    live.advance(900)
    live.command(emergency())
    live.advance(2000)
    taken = live.take_commands()
    again = Session(
        scenario(*((entry.time_ns / 1e9, entry.command) for entry in taken), radio=JITTERY), play_commands=True
    )
    assert_same(live.sample(), again.advance(live.step))
    assert again.take_commands() == taken


def test_commands_of_the_same_time_are_given_in_the_order_in_which_they_are_written() -> None:
    plan = ((0.0, brake(0.5)), (1.0, brake(0.0)), (1.0, traction(100e3)))
    session = Session(scenario(*plan), play_commands=True)
    session.advance(2000)
    assert [entry.command for entry in session.take_commands()] == [command for _, command in plan]
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
    assert session.take_commands() == []
    session.advance(1)  # the command acts in the step that begins at 0.502 s
    assert session.take_commands() == []
    session.advance(1)
    (taken,) = session.take_commands()
    assert (taken.time_ns, taken.command) == (502_000_000, emergency())


def test_at_the_start_every_locomotive_has_its_brake_released() -> None:
    session = Session(SMALL)
    assert session.take_applied_brakes() == [AppliedBrake(0, name, 0.0) for name in ("master", *SLAVES)]
    assert session.take_applied_brakes() == []


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
        session.command(brake(0.3))
        session.command(emergency())
        session.advance(500)
    with pytest.raises(CommandError, match=message) as refusal:
        disturbed.command(command)
    assert "\n" not in str(refusal.value)
    for session in (disturbed, calm):
        session.command(brake(0.8, "slave_1"))  # draws from the radio's generator
    assert_same(disturbed.advance(3000), calm.advance(3000))
    assert disturbed.status() == calm.status()
    assert disturbed.take_commands() == calm.take_commands()
    assert disturbed.take_applied_brakes() == calm.take_applied_brakes()


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
    session.take_applied_brakes()
    session.command(brake(0.4, "slave_2"))
    session.advance(2000)
    (applied,) = session.take_applied_brakes()
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
    session.command(brake(0.5))
    session.advance(3000)
    session.set_radio_link("slave_3", DOWN)
    session.take_applied_brakes()
    session.command(brake(0.8))
    session.advance(1000)
    assert set(applied_times(session)) == {"master", "slave_1", "slave_2"}
    assert session.radio_link("slave_3") == DOWN


def test_a_slave_that_has_lost_its_link_stops_pulling_when_the_emergency_wave_reaches_it() -> None:
    session = Session(scenario(initial_speed=5.0))
    session.command(traction(400e3))
    session.advance(1000)
    for slave in SLAVES:
        session.set_radio_link(slave, DOWN)
    session.command(emergency())
    session.advance(3000)  # the wave has passed the whole train
    work = session.energy().traction_work
    session.advance(500)
    assert session.energy().traction_work == work


# -- brakes ----------------------------------------------------------------------------------------------------------


def test_partial_demands_travel_as_waves_and_end_at_their_share_of_full_service() -> None:
    session = Session(scenario(radio=dict.fromkeys(SLAVES, DOWN)))
    offsets = np.array(session.consist.centre_offsets)
    session.command(brake(0.5))
    session.advance(1000)
    np.testing.assert_array_equal(fractions(session) > 0.0, (offsets - offsets[0]) / 200.0 < 1.0)
    session.advance(19_000)
    np.testing.assert_allclose(fractions(session), 0.5 * FULL_SERVICE, rtol=1e-12)
    session.command(brake(0.2))
    session.advance(1000)
    np.testing.assert_array_equal(
        fractions(session) < 0.5 * FULL_SERVICE * (1 - 1e-12), (offsets - offsets[0]) / 150.0 < 1.0
    )
    session.advance(19_000)
    np.testing.assert_allclose(fractions(session), 0.2 * FULL_SERVICE, rtol=1e-12)
    session.command(brake(0.0))
    session.advance(20_000)
    np.testing.assert_array_equal(fractions(session), 0.0)


def test_brakes_applied_again_soon_after_a_release_hold_the_whole_train() -> None:
    session = Session(load_scenario("daqin_1_2_1"))
    session.command(brake(0.6))
    session.advance(15_000)
    session.command(brake(0.0))
    session.advance(2000)
    session.command(brake(0.6))
    session.advance(25_000)
    # The service wave, at 200 m/s, overtakes the release, at 150 m/s; the demand of every locomotive is 0.6.
    np.testing.assert_allclose(fractions(session), 0.6 * FULL_SERVICE, rtol=1e-12)


def test_an_emergency_is_latched_until_it_is_ended_at_standstill() -> None:
    session = Session(scenario())
    session.command(emergency())
    session.advance(3000)
    session.command(brake(0.0))
    with pytest.raises(CommandError, match="standstill"):
        session.command(emergency(0.0))
    session.advance(5000)
    np.testing.assert_array_equal(fractions(session), 1.0)
    while not session.at_standstill:
        session.advance()
    session.command(brake(0.0))
    session.advance(5000)
    np.testing.assert_array_equal(fractions(session), 1.0)
    session.take_applied_brakes()
    session.command(emergency(0.0))
    assert {entry.locomotive: entry.value for entry in session.take_applied_brakes()} == {"master": 0.0}
    session.advance(40_000)
    np.testing.assert_array_equal(fractions(session), 0.0)
    assert session.at_standstill


def test_an_emergency_goes_on_while_any_locomotive_holds_it() -> None:
    session = Session(scenario(initial_speed=0.0))
    session.command(emergency())
    session.advance(5000)
    session.set_radio_link("slave_2", DOWN)
    session.command(emergency(0.0))
    session.advance(30_000)
    np.testing.assert_array_equal(fractions(session), 1.0)
    session.set_radio_link("slave_2", RadioLink())
    session.command(emergency(0.0, "slave_2"))
    session.advance(30_000)
    np.testing.assert_array_equal(fractions(session), 0.0)


def test_an_emergency_that_is_ended_while_its_waves_still_run_leaves_no_brake_on() -> None:
    session = Session(load_scenario("daqin_1_2_1", {"initial_speed_kmh": 0}))
    session.command(emergency())
    session.advance(2000)
    session.command(emergency(0.0))
    session.advance(60_000)
    np.testing.assert_array_equal(fractions(session), 0.0)


def test_a_brake_demand_cuts_the_traction_of_its_locomotive() -> None:
    session = Session(scenario(initial_speed=5.0))
    session.command(traction(400e3))
    session.advance(1000)
    pulled = session.energy().traction_work
    assert pulled > 4 * 400e3 * 4.9
    session.command(brake(0.1))
    session.advance(1000)
    assert session.energy().traction_work == pytest.approx(pulled)
    session.command(traction(400e3))
    session.advance(1000)
    assert session.energy().traction_work == pytest.approx(pulled)


def test_the_brake_goes_to_the_strongest_of_many_demands_and_back() -> None:
    random = np.random.default_rng(5)
    session = Session(scenario(radio=JITTERY, initial_speed=30.0))
    for _ in range(1500):
        session.command(brake(float(random.random()), str(random.choice(["master", *SLAVES]))))
        session.advance(2)
    for slave in SLAVES:
        session.set_radio_link(slave, RadioLink())
    session.command(brake(0.0))
    session.advance(3000)
    session.command(brake(1.0))
    session.advance(20_000)
    np.testing.assert_allclose(fractions(session), FULL_SERVICE, rtol=1e-12)
    assert session.status().unconverged_steps == 0


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
    session.command(emergency())
    session.advance(5000)
    np.testing.assert_array_equal(sample.speed, before)
