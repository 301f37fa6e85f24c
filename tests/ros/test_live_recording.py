"""A live train that is recorded less often than it is published, rounded, with sensors beside the truth."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

pytest.importorskip("rclpy")

from haul_ros.analysis.replay import replay_and_compare
from haul_ros.messages.cdr import JointStateCodec
from haul_ros.messages.channels import channel_table
from haul_ros.model.command import CommandKind
from haul_ros.recording.reader import Recording
from haul_ros.resources import shipped_scenarios
from tests.ros.live_node import LOCOMOTIVES, Couplers

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

TABLE = channel_table(LOCOMOTIVES, sensors=True)
SENSORS = (
    "sensors: {couplers: [52, 104], rate_hz: 20, force: {noise_kN: 2, quantisation_kN: 1}, stroke: {noise_mm: 1}}\n"
)


def test_what_is_recorded_is_every_tenth_of_what_is_published_rounded_alike(
    start_node: Callable[..., LiveNode], observer: Observer, scenario_with_sensors: str
) -> None:
    node = start_node(
        scenario=scenario_with_sensors,
        record_path="run.mcap",
        publish_rate=100.0,
        record_rate=10,
        **{"rounding.coupler_force": 100.0, "rounding.speed": 0.001, "rounding.pressure": 128.0},
    )
    couplers = Couplers(observer)
    published = observer.watch(TABLE.couplers)
    measured = observer.watch_typed(TABLE.measured[0])
    couplers.wait_for_time(10**9)
    observer.send("master", CommandKind.EMERGENCY, True)
    couplers.wait_for_time(6 * 10**9)
    assert observer.parameter("record_rate").double_value == 10.0
    assert observer.parameter("rounding.stroke").double_value == 0.0
    assert not observer.set_parameter("record_rate", 20.0).successful  # the file has begun
    assert node.end() == 0
    forces = {codec_time(data): JointStateCodec.of(data).decode(data)[2] for data in published}
    with Recording(node.folder / "run.mcap") as recording:
        series, sensors, info = recording.couplers(), recording.measured_couplers(), recording.info()
        pressure, speed = recording.pressure().pressure, recording.vehicles().speed
        comparison = replay_and_compare(recording)
    assert comparison.identical
    assert (info.record_rate, info.plan.every) == (10.0, 10)
    assert info.plan.rounding.resolutions() == {"coupler_force": 64.0, "speed": 2.0**-10, "pressure": 128.0}
    assert (series.time_ns[:-1] % 100_000_000 == 0).all()
    assert len(series.time_ns) > 50
    both = [n for n, time_ns in enumerate(series.time_ns.tolist()) if time_ns in forces]
    assert len(both) > 10  # a reader that lacks time does not get all
    for n in both:
        assert series.force[n].tobytes() == forces[int(series.time_ns[n])].tobytes()
    assert all((force % 64.0 == 0.0).all() for force in forces.values())
    assert max(np.abs(force).max() for force in forces.values()) > 100e3
    assert (pressure % 128.0 == 0.0).all()
    assert (speed % 2.0**-10 == 0.0).all()
    assert sensors is not None
    assert sensors.names == ("coupler_052", "coupler_104")
    assert (np.diff(sensors.time_ns) == 50_000_000).all()
    by_time = dict(zip(sensors.time_ns.tolist(), sensors.force.tolist(), strict=True))
    for message in measured:
        assert message.name == ["coupler_052", "coupler_104"]
        assert len(message.position) == 2
        assert len(message.velocity) == 0
        stamp = message.header.stamp
        assert by_time[stamp.sec * 10**9 + stamp.nanosec] == list(message.effort)
    assert len(measured) > 10


def codec_time(data: bytes) -> int:
    """The stamp of a JointState [ns]."""
    seconds, nanoseconds = np.frombuffer(data, "<u4", 2, 4)
    return int(seconds) * 10**9 + int(nanoseconds)


@pytest.fixture
def scenario_with_sensors(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A scenario file: the shipped 1+2+1 train with two instrumented couplers."""
    path = tmp_path_factory.mktemp("scenario") / "instrumented.yaml"
    path.write_text(shipped_scenarios()["daqin_1_2_1"].read_text("utf-8") + SENSORS, "utf-8")
    return str(path)
