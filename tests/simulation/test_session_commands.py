"""Commands, radio and brake waves of a session act where and when they should."""

from __future__ import annotations

import numpy as np
import pytest

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.event import Event
from haul_ros.model.log import AppliedBrake
from haul_ros.model.radio import RadioLink, RadioLinkChange
from haul_ros.physics import assembly
from haul_ros.physics.train_model import WaveKind
from haul_ros.scenario.loader import load_scenario
from haul_ros.simulation import session as session_module
from haul_ros.simulation.session import Session
from tests.empirical import wave_brakes
from tests.simulation.log_entries import of_kind
from tests.simulation.session_cases import (
    DOWN,
    FULL_SERVICE,
    JITTERY,
    SLAVES,
    SMALL,
    applied_times,
    assert_same,
    brake,
    emergency,
    fractions,
    links,
    scenario,
    traction,
)


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
    arrivals = (offsets - offsets[0]) / wave_brakes(SMALL).wave_speeds.emergency
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


@pytest.mark.parametrize("application", [emergency(), brake(0.4)])
def test_a_slave_that_has_lost_its_link_stops_pulling_when_the_brake_pipe_tells_it_of_an_application(
    application: Command,
) -> None:
    session = Session(scenario(initial_speed=5.0))
    session.request(traction(400e3))
    session.advance(1000)
    for slave in SLAVES:
        session.request(RadioLinkChange.to(slave, DOWN))
    session.request(application)
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


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (RadioLinkChange("master", delay=1.0), "master: no such slave locomotive, this train has slave_1, slave_2"),
        (RadioLinkChange("slave_1", delay=float("nan")), "slave_1: .* delay and jitter must be 0 to 3600 s"),
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


def test_waves_that_cannot_act_any_more_are_dropped_and_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    case = load_scenario("daqin_1_2_1", {"commands": []})
    models = []
    for room in (8, 10_000):
        monkeypatch.setattr(assembly, "_ROOM_FOR_WAVES", room)
        models.append(Session(case)._model)
    for model in models:
        for n in range(60):  # of which none is spent
            model.start_wave(model.time, 0, WaveKind.SERVICE, n / 100)
            model.start_wave(model.time, 100, WaveKind.RELEASE, n / 200)
            model.advance(20)
        model.start_wave(model.time, 100, WaveKind.EMERGENCY)
        model.advance(8000)
        for n in range(3000):  # all of which are, for the whole pipe is vented
            model.start_wave(model.time, 0, WaveKind.SERVICE, n / 3000)
        model.start_wave(model.time, 0, WaveKind.EMERGENCY_RELEASE)
    few, many = (model.waves_under_way for model in models)
    assert few <= 256
    assert many > 3000
    for _ in range(40):
        for model in models:
            model.advance(1000)
        first, second = (model.sample() for model in models)
        for name in ("speed", "coupler_force", "cylinder_pressure"):
            assert getattr(first, name).tobytes() == getattr(second, name).tobytes()
    assert first.cylinder_pressure.max() == 0.0


def test_at_too_many_waves_demands_are_refused_and_an_emergency_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session_module, "MOST_UNDER_WAY", 20)
    session = Session(load_scenario("daqin_1_2_1", {"commands": []}))
    with pytest.raises(CommandError, match=r"master: brake = .* waves and telegrams are under way, expected fewer"):
        for n in range(30):
            session.request(Command("master", CommandKind.BRAKE, n / 30))
    session.request(Command("master", CommandKind.EMERGENCY, 1.0))
    session.advance(2000)
    assert session.sample().cylinder_pressure[0] > 0.0


def test_emergencies_said_again_and_again_do_not_pile_up_on_slow_links_and_every_slave_hears_of_the_last_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(session_module, "MOST_UNDER_WAY", 20)
    still = {"commands": [], "initial_speed_kmh": 0, "radio.default.delay_s": 100, "radio.slave_3.delay_s": 200}
    session = Session(load_scenario("daqin_1_2_1", still))
    session.request(Command("slave_1", CommandKind.EMERGENCY, 1.0))
    session.request(Command("slave_1", CommandKind.EMERGENCY, 0.0))  # an emergency is on its way, and its end behind it
    for _ in range(100):
        session.request(Command("slave_2", CommandKind.EMERGENCY, 1.0))
    for _ in range(100):
        session.request(Command("master", CommandKind.EMERGENCY, 1.0))
    with pytest.raises(CommandError, match=r"master: emergency = 0.* are under way, expected fewer commands"):
        session.request(Command("master", CommandKind.EMERGENCY, 0.0))
    assert session._under_way <= 20 + 4
    session.advance(201_000)
    latched = [entry.text for entry in session.take_log().entries if isinstance(entry, Event)]
    for slave in ("slave_1", "slave_2", "slave_3"):
        assert latched.count(f"{slave}: emergency latched") == 1 + (slave == "slave_1")


def test_traction_that_arrives_after_the_link_is_down_and_the_pipe_has_told_of_a_brake_does_not_pull() -> None:
    session = Session(load_scenario("daqin_1_2_1", {"commands": [], "radio.slave_2.delay_s": 10}))
    slave = session.consist.locomotives[2].vehicle
    session.request(Command("slave_2", CommandKind.TRACTION, 400e3))
    session.advance(1000)
    session.request(RadioLinkChange("slave_2", connected=False))
    session.request(Command("master", CommandKind.BRAKE, 0.5))
    session.advance(11_000)
    assert session.sample().cylinder_pressure[slave] > 0.0
    assert session.energy().traction_work == 0.0
