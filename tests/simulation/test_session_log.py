"""What a session hands out: everything once, in order."""

from __future__ import annotations

import numpy as np

from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import AppliedBrake, Effort, RadioSeen
from haul_ros.model.radio import RadioLink, RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.simulation.session import Session
from tests.simulation.session_cases import (
    DOWN,
    JITTERY,
    SLAVES,
    SMALL,
    assert_same,
    brake,
    emergency,
    links,
    scenario,
)


def test_a_log_begins_with_every_link_and_every_brake_released() -> None:
    session = Session(scenario(radio=JITTERY))
    assert session.take_log().entries == (
        *(TimedRequest(0, RadioLinkChange.to(slave, link)) for slave, link in JITTERY.items()),
        *(kind(0, name, 0.0) for name in ("master", *SLAVES) for kind in (AppliedBrake, Effort)),
        *(RadioSeen(0, slave, what, True) for slave in JITTERY for what in ("heard", "acknowledged")),
    )
    assert session.take_log().entries == ()


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
