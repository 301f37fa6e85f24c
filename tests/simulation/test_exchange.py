"""Radio of whole runs: outages, tunnels, one-way failures, retries, status telegrams, and what lost links do."""

from __future__ import annotations

from dataclasses import replace

import pytest

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import RadioSeen
from haul_ros.model.radio import RadioLink, RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.model.scenario import Scenario
from haul_ros.simulation.session import Session
from tests.simulation.log_entries import of_kind
from tests.simulation.session_cases import SLAVES, SMALL, assert_same, brake, emergency, links, scenario, traction

PERIOD = 0.02
"""Of a sample [s]."""


def radio_events(session: Session, until: float) -> list[tuple[float, str]]:
    """Time [s] and text of what happens on the radio up to a time [s]."""
    found = []
    while session.time < until:
        session.advance()
        found += [e for e in of_kind(Event, session.take_log()) if e.kind is EventKind.RADIO]
    return [(event.time_ns / 1e9, event.text) for event in found]


def applied(session: Session, slave: str) -> float:
    """What a slave pulls with now [N]."""
    vehicle = next(loco.vehicle for loco in session.consist.locomotives if loco.name == slave)
    return float(session._model.efforts[vehicle])


def with_link(link: RadioLink, *plan: tuple[float, Command]) -> Scenario:
    return scenario(*plan, radio=links(slave_2=link))


def test_nothing_goes_over_a_link_in_an_outage_and_what_is_sent_again_after_it_does() -> None:
    link = RadioLink(delay=0.1, outages=((1.0, 3.0), (5.0, 6.0)), retries=3, retry_interval=0.8)
    case = with_link(link, (0.5, brake(0.2)), (1.2, brake(0.4)), (5.5, brake(0.6)))
    session = Session(case, play_commands=True)
    assert radio_events(session, 8.0) == [
        (1.0, "slave_2: radio outage begins: 1 to 3 s"),
        (1.2, "slave_2: telegram lost: brake 0.4"),
        (2.0, "slave_2: sent again, 1 of 3: brake 0.4"),
        (2.0, "slave_2: telegram lost: brake 0.4"),
        (2.8, "slave_2: sent again, 2 of 3: brake 0.4"),
        (2.8, "slave_2: telegram lost: brake 0.4"),
        (3.0, "slave_2: radio outage ends: 1 to 3 s"),
        (3.6, "slave_2: sent again, 3 of 3: brake 0.4"),
        (5.0, "slave_2: radio outage begins: 5 to 6 s"),
        (5.5, "slave_2: telegram lost: brake 0.6"),
        (6.0, "slave_2: radio outage ends: 5 to 6 s"),
        (6.3, "slave_2: sent again, 1 of 3: brake 0.6"),
    ]
    status = session.status().radio["slave_2"]
    assert (status.sent, status.lost, status.retried, status.given_up) == (3, 4, 4, 0)
    assert status.connected
    assert session.status().radio["slave_1"].lost == 0


def test_the_link_is_out_while_master_or_slave_are_in_the_tunnel() -> None:
    slave = next(loco.vehicle for loco in SMALL.consist.locomotives if loco.name == "slave_2")
    sample = Session(SMALL).sample()
    head, rear = float(sample.chainage[0]), float(sample.chainage[slave])
    begin, end = head + 50.0, head + 90.0
    link = RadioLink(tunnels=((begin, end),))
    speed = 20.0
    session = Session(replace(with_link(link), initial_speed=speed))
    times = radio_events(session, (end - rear) / speed + 3.0)
    name = f"the tunnel from {begin:g} to {end:g} m"
    expected = [(begin - head, "master"), (end - head, "master"), (begin - rear, "slave_2"), (end - rear, "slave_2")]
    assert [text for _, text in times] == [
        f"slave_2: radio outage {what}: {who} in {name}"
        for what, (_, who) in zip(["begins", "ends"] * 2, expected, strict=True)
    ]
    for (time, _), (distance, _) in zip(times, expected, strict=True):
        assert time == pytest.approx(distance / speed, rel=0.02, abs=2 * PERIOD)


@pytest.mark.parametrize("rate", [1.0, 50.0])
def test_an_outage_begins_and_ends_in_its_time_step_whatever_the_sample_rate(rate: float) -> None:
    link = RadioLink(outages=((1.013, 1.027), (2.3456, 2.9)))
    told = [time for time, _ in radio_events(Session(replace(with_link(link), sample_rate=rate)), 3.0)]
    assert told == [1.013, 1.027, 2.346, 2.9]


@pytest.mark.parametrize("rate", [1.0, 50.0])
def test_a_tunnel_is_seen_in_the_time_step_in_which_a_locomotive_comes_to_it_whatever_the_sample_rate(
    rate: float,
) -> None:
    case = replace(SMALL, initial_speed=20.0, sample_rate=rate)
    slave = next(loco.vehicle for loco in case.consist.locomotives if loco.name == "slave_2")
    head = float(Session(case).sample().chainage[0])
    begin, end = head + 7.3, head + 19.9
    told = [
        time
        for time, _ in radio_events(
            Session(replace(case, radio=links(slave_2=RadioLink(tunnels=((begin, end),))))), 16.0
        )
    ]
    witness = Session(case)
    crossed: list[float] = []
    places = [(0, begin), (0, end), (slave, begin), (slave, end)]
    while len(crossed) < len(places):
        vehicle, place = places[len(crossed)]
        if witness.advance(1).chainage[vehicle] >= place:
            crossed.append(witness.time)
    assert told == pytest.approx(crossed, abs=1e-9)


def test_what_is_sent_in_the_tunnel_is_lost() -> None:
    head = float(Session(SMALL).sample().chainage[0])
    inside, ahead = (RadioLink(tunnels=((head + a, head + a + 5.0),)) for a in (-1.0, 10.0))
    session = Session(scenario(radio=links(slave_1=inside, slave_2=ahead), initial_speed=0.0))
    session.request(brake(0.5))
    lost = {slave: status.lost for slave, status in session.status().radio.items()}
    assert lost == {"slave_1": 1, "slave_2": 0, "slave_3": 0}
    assert not session.status().radio["slave_1"].connected


def test_links_change_at_the_times_of_the_scenario() -> None:
    plan = (TimedRequest(10**9, RadioLinkChange("slave_1", fails="from_slave", retries=1, delay=0.2)),)
    case = replace(scenario((2.0, brake(0.5))), commands=(*plan, *scenario((2.0, brake(0.5))).commands))
    session = Session(case, play_commands=True)
    assert radio_events(session, 4.0) == [
        (1.0, "slave_1: radio link: no answers come"),
        (2.2, "slave_1: acknowledgement lost: brake 0.5"),
        (2.5, "slave_1: sent again, 1 of 1: brake 0.5"),
        (2.7, "slave_1: acknowledgement lost: brake 0.5"),
        (2.7, "slave_1: duplicate ignored: brake 0.5"),
        (3.0, "slave_1: given up, not acknowledged: brake 0.5"),
    ]
    status = session.status().radio["slave_1"]
    assert (status.connected, status.duplicates, status.given_up) == (False, 1, 1)


@pytest.mark.parametrize(
    ("action", "words", "pulls", "brakes"),
    [
        ("hold", "it holds", True, False),
        ("idle", "it idles", False, False),
        ("apply", "it applies full service", False, True),
    ],
)
def test_a_slave_that_hears_nothing_does_what_the_scenario_says(
    action: str, words: str, pulls: bool, brakes: bool
) -> None:
    link = RadioLink(delay=0.1, outages=((3.5, 9.0),), heartbeat=1.0, link_timeout=2.5, link_lost=action)
    session = Session(replace(with_link(link, (0.5, traction(100e3))), initial_speed=10.0), play_commands=True)
    events = radio_events(session, 5.58)
    assert applied(session, "slave_2") > 0.0
    events += radio_events(session, 5.8)
    assert (applied(session, "slave_2") > 0.0) is pulls
    assert (session._model.brake_target(session._vehicles["slave_2"]) > 0.0) is brakes
    assert applied(session, "slave_1") > 0.0
    events += radio_events(session, 11.0)
    assert events == [
        (3.5, "slave_2: radio outage begins: 3.5 to 9 s"),
        (5.6, f"slave_2: heard nothing for 2.5 s: {words}"),
        (9.0, "slave_2: radio outage ends: 3.5 to 9 s"),
        (9.1, "slave_2: heard the master again"),
    ]


def test_commands_count_as_heard_and_status_telegrams_change_no_luck() -> None:
    plain = RadioLink(delay=0.3, jitter=0.5, loss_probability=0.2)
    watched = replace(plain, heartbeat=0.5, link_timeout=3.0, link_lost="hold")
    plan = [(0.4 * n, brake(0.01 * n)) for n in range(1, 20)]
    logs = []
    for link in (plain, watched):
        session = Session(with_link(link, *plan), play_commands=True)
        logs.append((radio_events(session, 10.0), session.sample()))
    assert logs[0][0] == logs[1][0]
    assert_same(logs[0][1], logs[1][1])
    deaf = replace(plain, loss_probability=0.0, heartbeat=20.0, link_timeout=21.0)
    session = Session(with_link(deaf, (15.0, brake(0.1))), play_commands=True)
    radio_events(session, 22.0)
    assert session._exchange._heartbeats.lost("slave_2") is False


ROUGH = RadioLink(
    delay=0.3,
    jitter=0.2,
    loss_probability=0.3,
    jitter_law="gamma",
    retries=5,
    retry_interval=0.21,
    duplicate_probability=0.3,
    in_order=False,
    burst_length=1.0,
    burst_spacing=2.0,
    outages=((2.0, 2.5),),
    tunnels=((40.0, 80.0),),
    heartbeat=0.3,
    link_lost="idle",
    link_timeout=0.8,
)


def rough(seed: int = 1) -> Scenario:
    plan = [(0.17 * n, brake(round(0.05 * (n % 7), 2))) for n in range(1, 30)]
    return scenario(*plan, (5.5, emergency()), radio=dict.fromkeys(SLAVES, ROUGH), radio_seed=seed)


def test_whatever_the_grouping_of_calls_the_same_comes_out() -> None:
    runs = []
    for steps in (7, 20, 1000):
        session = Session(rough(), play_commands=True)
        while session.step < 14_000:
            session.advance(min(steps, 14_000 - session.step))
        radio = [e for e in of_kind(Event, session.take_log()) if e.kind is EventKind.RADIO]
        runs.append((session.sample(), session.status().radio, radio))
    for sample, links_then, events in runs[1:]:
        assert_same(sample, runs[0][0])
        assert links_then == runs[0][1]
        assert events == runs[0][2]
    words = " ".join(event.text for event in runs[0][2])
    for what in ("lost", "sent again", "duplicate", "out of order", "outage begins", "outage ends", "heard nothing"):
        assert what in words
    status = runs[0][1]["slave_1"]
    assert min(status.lost, status.retried, status.duplicates, status.out_of_order) > 0


def test_what_was_asked_live_gives_the_same_again_with_changes_of_every_field() -> None:
    live = Session(rough())
    changes = {
        "jitter_law": "exponential",
        "retries": 2,
        "retry_interval": 0.4,
        "duplicate_probability": 0.6,
        "in_order": True,
        "fails": "from_slave",
        "burst_length": 0.0,
        "burst_spacing": 5.0,
        "burst_loss_probability": 0.5,
        "connected": False,
    }
    entries = list(live.take_log().entries)
    for n, (field, value) in enumerate(changes.items()):
        live.advance(313)
        live.request(RadioLinkChange("slave_1", **{field: value}))  # type: ignore[arg-type]
        live.request(Command("master", CommandKind.BRAKE, 0.05 * (n + 1)))
        entries += live.take_log().entries
    live.advance(3000)
    requests = [entry for entry in entries if isinstance(entry, TimedRequest)][len(SLAVES) :]
    assert len(requests) == 2 * len(changes)
    again = Session(rough(), requests=requests)
    while again.step < live.step:
        again.advance(min(11, live.step - again.step))
    assert_same(again.sample(), live.sample())
    assert again.status() == live.status()
    other = Session(rough(seed=2), requests=requests)
    other.advance(live.step)
    assert other.status().radio != live.status().radio


def test_a_link_that_is_down_from_the_start_lets_the_pipe_end_traction() -> None:
    session = Session(scenario(radio=links(slave_1=RadioLink(fails="to_slave"))))
    vehicle = session._vehicles["slave_1"]
    assert session._model._train.vehicles.link_down[vehicle] == 1.0
    assert session._model._train.vehicles.link_down[session._vehicles["slave_2"]] == 0.0


def test_a_run_waits_for_retries_and_not_for_what_has_been_acknowledged() -> None:
    answered, silent = (
        Session(
            replace(
                with_link(RadioLink(retries=1, retry_interval=100.0, fails=fails)), initial_speed=0.0, max_duration=1e3
            )
        )
        for fails in ("none", "from_slave")
    )
    for session in (answered, silent):
        session.request(brake(0.0))
        while not session.finished:
            session.advance()
    assert answered.time < 1.0
    assert silent.time == pytest.approx(200.0, abs=2 * PERIOD)
    assert silent.status().radio["slave_2"].given_up == 1


def test_status_telegrams_heard_at_any_fraction_of_a_step_let_the_train_go_on() -> None:
    session = Session(with_link(RadioLink(delay=0.1 + 1e-9, heartbeat=0.1, link_timeout=0.25)))
    for fraction in (0.9999990, 0.99999900001, 1.0, 1.0000009999, 1.000001, 1.0000010001):
        session._exchange._heartbeats.heard("slave_2", (session.step + 2 + fraction) * SMALL.time_step)
        session.advance(5)
    assert session.step == 30


def test_a_slave_that_hears_nothing_listens_to_its_pipe_until_it_hears_something() -> None:
    session = Session(with_link(RadioLink(loss_probability=1.0, heartbeat=0.1, link_timeout=0.25)))
    vehicle, down = session._vehicles["slave_2"], session._model._train.vehicles.link_down
    session.advance(240)
    assert down[vehicle] == 0.0
    session.advance(20)
    assert down[vehicle] == 1.0
    session.request(RadioLinkChange("slave_2", loss_probability=0.0))
    assert down[vehicle] == 1.0
    session.advance(100)
    assert down[vehicle] == 0.0


def seen(session: Session, until: float) -> list[tuple[float, str, bool]]:
    """Time [s], what, and whether, of what the ends of the link to slave_2 make of it."""
    found = []
    while session.time < until:
        session.advance()
        found += [entry for entry in of_kind(RadioSeen, session.take_log()) if entry.slave == "slave_2"]
    return [(entry.time_ns / 1e9, entry.what, entry.value) for entry in found]


def test_what_both_ends_make_of_a_link_is_told_as_it_changes_and_once() -> None:
    """Out from 1 to 4 s: the slave's patience of 1.5 s ends 1.5 s after what it heard last, at 1.0 s; the master sends
    at 1.2 s and twice more, 0.5 s apart, and gives up at 2.7 s; at 5 s he sends again and knows 0.5 s later."""
    link = RadioLink(delay=0.1, outages=((1.0, 4.0),), retries=2, retry_interval=0.5, heartbeat=0.3, link_timeout=1.5)
    case = with_link(link, (0.5, brake(0.1)), (1.2, brake(0.2)), (1.3, brake(0.3)), (5.0, brake(0.4)))
    assert seen(Session(case, play_commands=True), 6.0) == [
        (0.0, "heard", True),
        (0.0, "acknowledged", True),
        (pytest.approx(2.5, abs=0.002), "heard", False),
        (pytest.approx(2.8, abs=0.002), "acknowledged", False),
        (pytest.approx(4.3, abs=0.002), "heard", True),
        (pytest.approx(5.5, abs=0.002), "acknowledged", True),
    ]


def test_a_dead_answering_direction_is_seen_by_the_master_alone_and_without_retries_by_nobody() -> None:
    for retries, expected in ((1, [("acknowledged", False)]), (0, [])):
        link = RadioLink(delay=0.1, fails="from_slave", retries=retries, heartbeat=0.3, link_timeout=1.0)
        told = seen(Session(with_link(link, (0.5, brake(0.1))), play_commands=True), 4.0)
        assert [(what, value) for time, what, value in told if time > 0.0] == expected
