"""Commands at full speed from several processes: an emergency is not delayed, nor is the simulation."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from mcap.reader import make_reader

from haul_ros.model.command import CommandKind
from haul_ros.recording.reader import Recording
from tests.ros.live_node import LOCOMOTIVES, TABLE, Couplers
from tests.ros.participants import participant

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

    StartNode = Callable[..., LiveNode]

RATE = 5.0


@pytest.fixture
def flood() -> Iterator[Callable[[list[str]], None]]:
    """Processes that publish to topics as fast as they can."""
    with ExitStack() as processes:

        def start(topics: list[str]) -> None:
            processes.enter_context(participant("tests.ros.flood", *topics))

        yield start


@pytest.mark.slow
def test_an_emergency_in_a_flood_of_demands_takes_effect_within_two_sample_periods(
    start_node: StartNode, observer: Observer, flood: Callable[[list[str]], None]
) -> None:
    node = start_node(record_path="run.mcap", publish_rate=RATE)
    Couplers(observer).wait_for_time(10**9)
    applied = {name: observer.watch_typed(TABLE.applied_brake[name]) for name in LOCOMOTIVES}
    last_first = LOCOMOTIVES[::-1]  # the master's goes to the slaves too
    reports = observer.watch_typed(TABLE.diagnostics)
    for kind in (CommandKind.BRAKE, CommandKind.TRACTION):
        flood([TABLE.commands[kind][locomotive].topic for locomotive in ("master", "slave_1", "slave_2")])
    observer.wait_until(lambda: replaced(reports) > 1000, "a count of what was replaced")
    sent_ns = []
    for locomotive in last_first:
        observer.get_ready_to_send(locomotive, CommandKind.EMERGENCY)
        sent_ns.append(time.time_ns())
        observer.send(locomotive, CommandKind.EMERGENCY, True)
        observer.wait_until(partial(is_emergency, applied[locomotive]), f"the emergency of {locomotive}")
    assert node.end() == 0
    emergencies = [TABLE.commands[CommandKind.EMERGENCY][locomotive].topic for locomotive in last_first]
    with (node.folder / "run.mcap").open("rb") as stream:
        taken_ns = [m.publish_time for _, _, m in make_reader(stream).iter_messages(topics=emergencies)]
    # A flood delays all of them; a machine that has other work as well, some
    assert min(np.subtract(taken_ns, sent_ns)) / 1e9 < 2.0 / RATE
    with Recording(node.folder / "run.mcap") as recording:
        info = recording.info()
        assert info.complete
        # at most one demand of each kind and locomotive in a period, each also told of by what it changes
        assert len(recording.commands()) <= 6 * (info.duration * RATE + 2)


def is_emergency(applied: list[Any]) -> bool:
    return any(message.data == 1.0 for message in applied)


def replaced(reports: list[object]) -> int:
    if not reports:
        return 0
    (status,) = (s for s in reports[-1].status if s.name == "haul: commands")  # type: ignore[attr-defined]
    return next(int(v.value) for v in status.values if v.key == "replaced by newer ones")
