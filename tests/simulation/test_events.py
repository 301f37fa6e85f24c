"""Events of a run: what, where, and when, the same whoever asks."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest

from haul_ros.model.event import Event, EventKind
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.batch import periods
from haul_ros.simulation.events import SLACK_SPEED, EventWatch
from haul_ros.simulation.session import Session

SECOND = 10**9
TRAIN = """\
description: short train, emergency from 20 km/h
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 20}
  - {vehicle: SS4, role: slave}
  - {vehicle: C80, count: 5}
coupler: MT-2
brakes: paper_set_b
initial_speed_kmh: 20
max_duration_s: 60
radio: {default: {delay_s: 1.5}}
commands:
  - {at_s: 0.5, locomotive: master, emergency: true}
"""


def scenario(**overrides: object) -> Scenario:
    return load_scenario_text(TRAIN, "train", {key.replace("__", "."): value for key, value in overrides.items()})


def events_of(run: Scenario) -> list[Event]:
    return [event for period in periods(Session(run, play_commands=True)) for event in period.events]


def of_kind(kind: EventKind, run: Scenario) -> list[tuple[int, str]]:
    return [(event.time_ns, event.text) for event in events_of(run) if event.kind is kind]


def test_an_emergency_is_told_at_the_instant_at_which_it_is_latched() -> None:
    assert of_kind(EventKind.EMERGENCY, scenario(radio__default__delay_s=1.2345)) == [
        (500_000_000, "master: emergency latched"),
        (1_734_500_000, "slave_1: emergency latched"),
    ]


def test_a_wave_is_told_at_locomotives_and_the_tail_with_the_sample_that_shows_it() -> None:
    run = scenario(radio__default__connected=False)
    offsets, speed = run.consist.centre_offsets, run.brakes.wave_speeds.emergency
    told = of_kind(EventKind.WAVE, run)
    assert [text for _, text in told] == [
        "master: brake wave: emergency",
        "slave_1: brake wave: emergency",
        "tail, vehicle_027_C80: brake wave: emergency",
    ]
    for (time_ns, _), vehicle in zip(told, (0, 21, 26), strict=True):
        arrival = 0.5 + (offsets[vehicle] - offsets[0]) / speed
        assert 0.0 < time_ns / SECOND - arrival <= 0.02 + 1e-9


def test_service_and_release_are_told_with_their_level() -> None:
    commands = [
        {"at_s": 0.1, "locomotive": "master", "brake": 0.5},
        {"at_s": 5.0, "locomotive": "master", "brake": 0.0},
    ]
    run = scenario(commands=commands, radio__default__delay_s=0.0)
    percent = f"{50 * run.brakes.full_service:.0f} %"
    texts = [text for _, text in of_kind(EventKind.WAVE, run)]
    assert f"master: brake wave: service application to {percent} of emergency" in texts
    assert "slave_1: brake wave: release to 0 % of emergency" in texts


def test_a_lost_telegram_is_told_when_it_is_sent() -> None:
    run = scenario(radio__default__loss_probability=1.0)
    assert of_kind(EventKind.RADIO, run) == [(500_000_000, "slave_1: telegram lost: emergency 1")]


def test_a_link_that_goes_down_and_up_is_told_once_each() -> None:
    session = Session(scenario())
    watch = EventWatch(session)
    session.advance(7)
    link = session.radio_link("slave_1")
    for connected in (False, False, True):
        session.set_radio_link("slave_1", replace(link, connected=connected))
    assert watch.look(session.sample()) == (
        Event(7_000_000, EventKind.RADIO, "slave_1: radio link down"),
        Event(7_000_000, EventKind.RADIO, "slave_1: radio link up"),
    )
    assert watch.look(session.sample()) == ()


def test_every_vehicle_stops_once_and_the_train_at_its_stop_time() -> None:
    session = Session(scenario(), play_commands=True)
    told = [event for period in periods(session) for event in period.events if event.kind is EventKind.STOPPED]
    (train,) = (event for event in told if event.text == "train: stopped")
    assert session.stop_time is not None
    assert train.time_ns == round(session.stop_time * SECOND)
    assert any(event.text.startswith("vehicle_001_SS4") for event in told)
    assert any(event.text.endswith("vehicle_027_C80: stopped") for event in told)


def test_a_draft_gear_that_closes_is_told_once_at_its_time() -> None:
    overrides = {"couplers.MT-2.maximum_stroke_mm": 5, "couplers.MT-2.bottoming_stiffness_kN_per_mm": 500}
    run = load_scenario_text(TRAIN, "train", overrides)
    session = Session(run, play_commands=True)
    told = [event for period in periods(session) for event in period.events if event.kind is EventKind.BOTTOMED]
    times = session.extremes().bottomed_time
    closed = {round(time * SECOND) for time in times if time == time}
    assert closed
    assert {event.time_ns for event in told} == closed
    assert told[0].text.endswith("draft gear closed fully")


@pytest.mark.parametrize(("slack_mm", "found"), [(20, True), (0, False)])
def test_slack_that_closes_fast_enough_is_told_of_gears_that_have_some(slack_mm: float, found: bool) -> None:
    run = load_scenario_text(TRAIN, "train", {"couplers.MT-2.slack_mm": slack_mm})
    session = Session(run, play_commands=True)
    told = list(periods(session))
    closings = set()
    half = slack_mm / 2e3
    for before, after in pairwise(told):
        speed = (after.sample.stroke - before.sample.stroke) * 50.0
        if ((before.sample.stroke < half) & (after.sample.stroke >= half) & (speed > SLACK_SPEED)).any():
            closings.add(after.sample.time_ns)
    run_ins = {e.time_ns for period in told for e in period.events if "slack run-in" in e.text}
    assert run_ins == (closings if found else set())
    assert bool(run_ins) is found


def test_events_do_not_depend_on_how_the_steps_are_grouped() -> None:
    session = Session(scenario(), play_commands=True)
    watch = EventWatch(session)
    found = [*watch.look(session.sample())]
    while not session.finished:
        for steps in (3, 7, 10):
            session.advance(steps)
        found += watch.look(session.sample())
    assert found == events_of(scenario())
    assert len(found) > 10
