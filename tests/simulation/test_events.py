"""Events of a run: what, where, and when, the same whoever asks."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from haul_ros.model.event import Event, EventKind
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.batch import periods
from haul_ros.simulation.events import SLACK_SPEED, EventDetector, TrainState
from haul_ros.simulation.session import Session
from tests.empirical import wave_brakes
from tests.simulation.log_entries import of_kind, samples

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
    return of_kind(Event, *periods(Session(run, play_commands=True)))


def about(kind: EventKind, run: Scenario) -> list[tuple[int, str]]:
    return [(event.time_ns, event.text) for event in events_of(run) if event.kind is kind]


def test_an_emergency_is_logged_at_the_instant_at_which_it_is_latched() -> None:
    assert about(EventKind.EMERGENCY, scenario(radio__default__delay_s=1.2345)) == [
        (500_000_000, "master: emergency latched"),
        (1_734_500_000, "slave_1: emergency latched"),
    ]


def test_a_wave_is_logged_at_locomotives_and_the_tail_with_the_sample_that_shows_it() -> None:
    run = scenario(radio__default__connected=False)
    offsets, speed = run.consist.centre_offsets, wave_brakes(run).wave_speeds.emergency
    found = about(EventKind.WAVE, run)
    assert [text for _, text in found] == [
        "master: brake wave: emergency",
        "slave_1: brake wave: emergency",
        "tail, vehicle_027_C80: brake wave: emergency",
    ]
    for (time_ns, _), vehicle in zip(found, (0, 21, 26), strict=True):
        arrival = 0.5 + (offsets[vehicle] - offsets[0]) / speed
        assert 0.0 < time_ns / SECOND - arrival <= 0.02 + 1e-9


def test_service_and_release_are_logged_with_their_level() -> None:
    commands = [
        {"at_s": 0.1, "locomotive": "master", "brake": 0.5},
        {"at_s": 5.0, "locomotive": "master", "brake": 0.0},
    ]
    run = scenario(commands=commands, radio__default__delay_s=0.0)
    percent = f"{50 * wave_brakes(run).full_service:.0f} %"
    texts = [text for _, text in about(EventKind.WAVE, run)]
    assert f"master: brake wave: service application to {percent} of emergency" in texts
    assert "slave_1: brake wave: release to 0 % of emergency" in texts


def test_a_lost_telegram_is_logged_when_it_is_sent() -> None:
    run = scenario(radio__default__loss_probability=1.0)
    assert about(EventKind.RADIO, run) == [(500_000_000, "slave_1: telegram lost: emergency 1")]


def test_a_link_that_goes_down_and_up_is_logged_once_each() -> None:
    session = Session(scenario())
    session.advance(7)
    for connected in (False, False, True):
        session.request(RadioLinkChange("slave_1", connected=connected))
    assert of_kind(Event, session.take_log()) == [
        Event(7_000_000, EventKind.RADIO, "slave_1: radio link down"),
        Event(7_000_000, EventKind.RADIO, "slave_1: radio link up"),
    ]
    assert of_kind(Event, session.take_log()) == []


def test_every_vehicle_stops_once_and_the_train_at_its_stop_time() -> None:
    session = Session(scenario(), play_commands=True)
    stops = [event for event in of_kind(Event, *periods(session)) if event.kind is EventKind.STOPPED]
    (train,) = (event for event in stops if event.text == "train: stopped")
    assert session.stop_time is not None
    assert train.time_ns == round(session.stop_time * SECOND)
    assert any(event.text.startswith("vehicle_001_SS4") for event in stops)
    assert any(event.text.endswith("vehicle_027_C80: stopped") for event in stops)


def test_a_draft_gear_that_closes_is_logged_once_at_its_time() -> None:
    overrides = {"couplers.MT-2.maximum_stroke_mm": 5, "couplers.MT-2.bottoming_stiffness_kN_per_mm": 500}
    run = load_scenario_text(TRAIN, "train", overrides)
    session = Session(run, play_commands=True)
    found = [event for event in of_kind(Event, *periods(session)) if event.kind is EventKind.BOTTOMED]
    times = session.extremes().bottomed_time
    closed = {round(time * SECOND) for time in times if time == time}
    assert closed
    assert {event.time_ns for event in found} == closed
    assert found[0].text.endswith("draft gear closed fully")


@pytest.mark.parametrize(("slack_mm", "found"), [(20, True), (0, False)])
def test_slack_that_closes_fast_enough_is_logged_of_gears_that_have_some(slack_mm: float, found: bool) -> None:
    run = load_scenario_text(TRAIN, "train", {"couplers.MT-2.slack_mm": slack_mm})
    session = Session(run, play_commands=True)
    logs = list(periods(session))
    closings = set()
    half = slack_mm / 2e3
    for before, after in pairwise(samples(logs)):
        speed = (after.stroke - before.stroke) * 50.0
        if ((before.stroke < half) & (after.stroke >= half) & (speed > SLACK_SPEED)).any():
            closings.add(after.time_ns)
    run_ins = {event.time_ns for event in of_kind(Event, *logs) if "slack run-in" in event.text}
    assert run_ins == (closings if found else set())
    assert bool(run_ins) is found


def test_events_do_not_depend_on_how_the_steps_are_grouped() -> None:
    session = Session(scenario(), play_commands=True)
    found = of_kind(Event, session.take_log())
    while not session.finished:
        for steps in (3, 7, 10):
            session.advance(steps)
        found += of_kind(Event, session.take_log())
    assert found == events_of(scenario())
    assert len(found) > 10


def test_what_is_compared_is_the_state_of_the_last_update() -> None:
    run = scenario()
    sample = Session(run).sample()
    released, braked = np.zeros(27), np.full(27, 1.0)
    open_gears = np.full(26, np.nan)
    detector = EventDetector(run.consist, TrainState(sample, released, open_gears, None))
    later = replace(sample, time_ns=SECOND, speed=np.zeros(27))
    closed = open_gears.copy()
    closed[[3, 4, 9]] = 0.5
    now = TrainState(later, braked, closed, 0.75)
    assert {(event.time_ns, event.text) for event in detector.update(now)} == {
        (SECOND, "master: brake wave: emergency"),
        (SECOND, "slave_1: brake wave: emergency"),
        (SECOND, "tail, vehicle_027_C80: brake wave: emergency"),
        (SECOND // 2, "coupler_004 to coupler_005, coupler_010: draft gear closed fully"),
        (SECOND, "vehicle_001_SS4 to vehicle_027_C80: stopped"),
        (SECOND * 3 // 4, "train: stopped"),
    }
    assert detector.update(now) == []
