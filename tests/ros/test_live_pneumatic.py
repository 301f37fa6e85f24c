"""A live train with a pneumatic brake: pressures on topics, electric brake over topics, replay to the bit."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from haul_ros.analysis.replay import replay_and_compare
from haul_ros.messages.channels import channel_table
from haul_ros.model.command import CommandKind
from haul_ros.model.fault import Fault, FaultKind
from haul_ros.recording.reader import Recording
from tests.ros.live_node import LOCOMOTIVES, Couplers

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

PNEUMATIC = channel_table(LOCOMOTIVES, pneumatic=True)


def test_a_live_pneumatic_train_brakes_tells_its_pressures_and_is_repeated_exactly(
    start_node: Callable[..., LiveNode], observer: Observer
) -> None:
    node = start_node(scenario="daqin_1_2_1_pneumatic", record_path="run.mcap", real_time_factor=4.0)
    couplers = Couplers(observer)
    pipe_channel, auxiliary_channel = PNEUMATIC.pressures[1:]
    pipe, auxiliary = observer.watch_typed(pipe_channel), observer.watch_typed(auxiliary_channel)
    effort = observer.watch_typed(PNEUMATIC.tractive_effort["slave_3"])
    couplers.wait_for_time(10**9)
    observer.send("master", CommandKind.ELECTRIC_BRAKE, 200e3)
    observer.wait_until(lambda: bool(effort) and effort[-1].data < -20e3, "the electric brake of the last slave")
    observer.send("master", CommandKind.BRAKE, 0.5)
    observer.wait_until(lambda: pipe[-1].data[100] < 440e3, "the brake pipe to fall")
    assert pipe[-1].layout.dim[0].label == "vehicle"
    assert len(pipe[-1].data) == len(auxiliary[-1].data) == 208
    observer.wait_until(lambda: auxiliary[-1].data[100] < 480e3, "the auxiliary reservoirs to follow")
    assert effort[-1].data < 0.0, "a service application leaves the electric brake"
    observer.send("master", CommandKind.EMERGENCY, True)
    observer.wait_until(lambda: pipe[-1].data[100] < 20e3, "the brake pipe to be vented")
    observer.wait_until(lambda: effort[-1].data == 0.0, "the electric brake to end")
    assert node.end() == 0
    with Recording(node.folder / "run.mcap") as recording:
        series, reservoirs = recording.pipe_pressure(), recording.auxiliary_pressure()
        assert series is not None
        assert reservoirs is not None
        assert series.pressure[0] == pytest.approx(np.full(208, 500e3))
        assert series.pressure[-1, 100] < 20e3
        assert series.names == recording.vehicles().names == reservoirs.names
        assert reservoirs.pressure.shape == series.pressure.shape
        assert recording.scalars("slave_3/tractive_effort").values.min() < -20e3
        comparison = replay_and_compare(recording)
    assert comparison.identical
    assert comparison.messages > 5 * len(series.time_ns)  # of every sample, and the extremes


def test_faults_over_topics_happen_are_recorded_and_repeated_and_impossible_ones_warn_once(
    start_node: Callable[..., LiveNode], observer: Observer
) -> None:
    node = start_node(scenario="daqin_1_2_1_pneumatic", record_path="run.mcap", real_time_factor=4.0)
    Couplers(observer).wait_for_time(0)
    pipe, events = observer.watch_typed(PNEUMATIC.pressures[1]), observer.watch_typed(PNEUMATIC.events)
    reports = observer.watch_typed(PNEUMATIC.diagnostics)
    faults = PNEUMATIC.faults
    for impossible in (0, 208, 999):
        observer.send_fault(faults[FaultKind.PART_HOSE], impossible)
    observer.wait_until(lambda: "3" in map(rejected, reports), "three rejected faults")
    observer.send_fault(faults[FaultKind.LEAK], [150.0, 0.006])
    observer.send_fault(faults[FaultKind.UNCOUPLE], 104)
    observer.wait_until(lambda: any("uncoupled" in event.msg for event in events), "the event of the uncoupling")
    observer.send_fault(faults[FaultKind.PART_HOSE], 104)
    observer.wait_until(lambda: bool(pipe) and pipe[-1].data[104] < 100e3, "the brake pipe to be vented")
    assert node.end() == 0
    assert node.log.count("/haul/part_hose rejected") == 1
    assert {event.name for event in events} >= {"haul.fault", "haul.separation"}
    with Recording(node.folder / "run.mcap") as recording:
        asked = [timed.request for timed in recording.requests() if isinstance(timed.request, Fault)]
        assert asked == [
            Fault(FaultKind.LEAK, 150, 0.006), Fault(FaultKind.UNCOUPLE, 104), Fault(FaultKind.PART_HOSE, 104)
        ]  # fmt: skip
        assert replay_and_compare(recording).identical


def rejected(report: Any) -> str:
    """How many requests a report of the diagnostics says were rejected."""
    (commands,) = [status for status in report.status if status.name.endswith("commands")]
    return next(str(value.value) for value in commands.values if value.key == "rejected")
