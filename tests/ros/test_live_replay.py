"""What was simulated live is simulated again from its recording, bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

pytest.importorskip("rclpy")

from mcap.reader import make_reader

from haul_ros.analysis.replay import replay_and_compare
from haul_ros.messages.cdr import decode_bool, decode_float64
from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.radio import RadioLinkChange
from haul_ros.recording.reader import Recording
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.session import Session
from tests.ros.live_node import TABLE

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

pytestmark = pytest.mark.no_cover  # other tests reach the same lines of the node

COMMANDS = {
    channel.topic: (locomotive, kind)
    for kind, by_locomotive in TABLE.commands.items()
    for locomotive, channel in by_locomotive.items()
}
LINKS = {
    channel.topic: (slave, field) for field, by_slave in TABLE.radio.items() for slave, channel in by_slave.items()
}


def replay_differences(path: Path, chunk_of_steps: int) -> tuple[int, int]:
    """Simulate the recorded requests again in chunks of so many steps.

    Returns the number of samples compared, and how many of their messages differ in any bit.
    """
    with Recording(path) as recording:
        scenario = load_scenario_text(recording.scenario_document, "replay")
    session = Session(scenario, play_commands=False)
    encoder = TelemetryEncoder(scenario.consist)
    time_step_ns = round(scenario.time_step * 1e9)
    samples = differences = 0
    with path.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            if channel.topic == TABLE.couplers.topic:
                while remaining := (message.log_time - session.time_ns) // time_step_ns:
                    session.advance(min(remaining, chunk_of_steps))
                couplers = encoder.sample(session.sample())[0]
                samples += 1
                differences += couplers.data != message.data
            elif channel.topic == TABLE.vehicles.topic:
                differences += encoder.sample(session.sample())[1].data != message.data
            elif channel.topic == TABLE.brake_cylinder_pressure.topic:
                differences += encoder.sample(session.sample())[2].data != message.data
            elif channel.topic in COMMANDS:
                locomotive, kind = COMMANDS[channel.topic]
                decode = decode_bool if kind is CommandKind.EMERGENCY else decode_float64
                session.request(Command(locomotive, kind, float(decode(message.data))))
            elif channel.topic in LINKS:
                slave, field = LINKS[channel.topic]
                decode = decode_bool if field == "connected" else decode_float64
                value: dict[str, Any] = {field: decode(message.data)}
                session.request(RadioLinkChange(slave, **value))
    return samples, differences


@pytest.mark.parametrize(("real_time_factor", "publish_rate"), [(1.0, 50.0), (0.0, 50.0), (4.0, 20.0)])
def test_a_recorded_live_run_is_repeated_exactly_whatever_its_pacing(
    start_node: Callable[..., LiveNode], observer: Observer, real_time_factor: float, publish_rate: float
) -> None:
    node = start_node(
        record_path="run.mcap",
        real_time_factor=real_time_factor,
        publish_rate=publish_rate,
        radio__slave_1__delay=0.3,
        radio__slave_2__jitter=0.2,
        radio__slave_3__loss_probability=0.5,
    )
    applied = {slave: observer.watch_typed(channel) for slave, channel in TABLE.applied_brake.items()}

    def wait_for(locomotive: str, value: float) -> None:
        messages = applied[locomotive]
        observer.wait_until(lambda: bool(messages) and messages[-1].data == value, f"{value} at {locomotive}")

    for demand in (0.2, 0.7, 0.4):
        observer.send("master", CommandKind.BRAKE, demand)
        wait_for("slave_2", demand)
    for name, value in (("slave_1.delay", 0.8), ("slave_1.jitter", 0.7), ("slave_3.loss_probability", 1.0)):
        assert observer.set_parameter(f"radio.{name}", value).successful
    observer.send("slave_1", CommandKind.BRAKE, 0.9)
    wait_for("slave_1", 0.9)
    observer.send("slave_3", CommandKind.BRAKE, 0.8)
    for name, value in (("slave_3.loss_probability", 0.25), ("slave_2.jitter", 0.0), ("slave_3.jitter", 0.4)):
        assert observer.set_parameter(f"radio.{name}", value).successful
    observer.send("master", CommandKind.BRAKE, 0.5)
    wait_for("slave_2", 0.5)
    observer.send("slave_2", CommandKind.EMERGENCY, True)
    wait_for("slave_2", 1.0)
    assert node.end() == 0

    for chunk_of_steps in (1_000_000, 7):
        samples, differences = replay_differences(node.folder / "run.mcap", chunk_of_steps)
        assert samples > 10
        assert differences == 0
    with Recording(node.folder / "run.mcap") as recording:
        changed = {field for timed in recording.requests() if isinstance(timed.request, RadioLinkChange)
                   for field in timed.request.values()}  # fmt: skip
        found = replay_and_compare(recording)
    assert changed == {"delay", "jitter", "loss_probability"}
    assert found.identical
    assert found.messages > 3 * samples
