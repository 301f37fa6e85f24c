"""What reaches the simulation of a flood of requests."""

from __future__ import annotations

import pytest

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.fault import Fault, FaultKind
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import Request
from haul_ros.ros.inbox import REPLACED, Inbox

HOLD = 20_000_000


def demand(value: float, locomotive: str = "master", kind: CommandKind = CommandKind.BRAKE) -> Command:
    return Command(locomotive, kind, value)


def emergency(value: float, locomotive: str = "master") -> Command:
    return Command(locomotive, CommandKind.EMERGENCY, value)


def taken(inbox: Inbox, now: int) -> list[Request]:
    return [waiting.request for waiting in inbox.take(now)]


def test_the_newest_demand_of_a_period_counts() -> None:
    inbox = Inbox(HOLD)
    results = [inbox.put(demand(n / 10)) for n in range(10)]
    assert [announce for _, announce in results] == [True] + [False] * 9
    assert [result.result() for result, _ in results[:-1]] == [REPLACED] * 9
    assert not results[-1][0].done()
    assert taken(inbox, 0) == [demand(0.9)]
    assert inbox.replaced == 9


def test_a_second_one_waits_for_the_next_period_or_as_long_as_one_takes() -> None:
    inbox = Inbox(HOLD)
    inbox.put(demand(0.1))
    assert taken(inbox, 5) == [demand(0.1)]
    assert inbox.put(demand(0.2))[1]
    assert taken(inbox, 6) == []
    assert inbox.due_ns(6) == 5 + HOLD
    inbox.next_period()
    assert inbox.due_ns(7) == 7
    assert taken(inbox, 7) == [demand(0.2)]
    inbox.put(demand(0.3))
    assert taken(inbox, 7 + HOLD) == [demand(0.3)]
    assert inbox.due_ns(8 + HOLD) is None


@pytest.mark.parametrize("flood", [0, 1, 1000])
def test_an_emergency_goes_first_and_is_replaced_by_nothing(flood: int) -> None:
    inbox = Inbox(HOLD)
    for n in range(flood):
        inbox.put(demand(n / flood, "slave_1"))
    inbox.put(emergency(1.0))
    inbox.put(emergency(0.0))
    inbox.put(demand(0.0))
    found = taken(inbox, 0)
    assert found[0] == emergency(1.0)
    assert set(found[1:]) == {emergency(0.0), demand(0.0)} | (
        {demand((flood - 1) / flood, "slave_1")} if flood else set()
    )


def test_an_emergency_right_after_a_demand_of_the_same_period_does_not_wait() -> None:
    inbox = Inbox(HOLD)
    inbox.put(demand(0.5))
    inbox.take(0)
    inbox.put(emergency(1.0))
    assert taken(inbox, 1) == [emergency(1.0)]


def test_different_things_keep_their_order() -> None:
    inbox = Inbox(HOLD)
    requests: list[Request] = [
        demand(0.5),
        RadioLinkChange("slave_1", delay=2.0),
        demand(100.0, kind=CommandKind.TRACTION),
        RadioLinkChange("slave_1", connected=False),
        demand(0.5, "slave_1"),
        RadioLinkChange("slave_2", delay=2.0),
        Fault(FaultKind.CLOSE_ANGLE_COCK, 3),
        Fault(FaultKind.OPEN_ANGLE_COCK, 3),
        Fault(FaultKind.CLOSE_ANGLE_COCK, 4),
    ]
    for request in requests:
        inbox.put(request)
    assert taken(inbox, 0) == requests


def test_a_fault_is_handed_out_once_a_period_and_no_number_gets_in_that_no_train_has() -> None:
    inbox = Inbox(HOLD)
    for bore in (1e-3, 2e-3):
        inbox.put(Fault(FaultKind.LEAK, 3, bore))
    assert taken(inbox, 0) == [Fault(FaultKind.LEAK, 3, 2e-3)]
    for number in (0, 2001):
        with pytest.raises(CommandError):
            inbox.put(Fault(FaultKind.PART_HOSE, number))
    assert (inbox.replaced, inbox.refused) == (1, 2)


def test_what_is_left_is_given_back() -> None:
    inbox = Inbox(HOLD)
    result, _ = inbox.put(demand(0.5))
    assert [waiting.result for waiting in inbox.take_all()] == [result]
    assert inbox.due_ns(0) is None
