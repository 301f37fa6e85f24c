"""What was simulated live is simulated again from its recording, bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

pytest.importorskip("rclpy")

from mcap.reader import make_reader

from haul_ros.analysis.replay import replay_and_compare
from haul_ros.messages.cdr import decode_bool, decode_float64, decode_int32, decode_string
from haul_ros.messages.channels import BOOL, FLOAT64, INT32, STRING
from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.radio import RadioLinkChange
from haul_ros.recording.reader import Recording
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.session import Session
from tests.ros.live_node import TABLE

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

COMMANDS = {
    channel.topic: (locomotive, kind)
    for kind, by_locomotive in TABLE.commands.items()
    for locomotive, channel in by_locomotive.items()
}
LINKS = {
    channel.topic: (slave, field) for field, by_slave in TABLE.radio.items() for slave, channel in by_slave.items()
}

LINK_VALUE: dict[str, Callable[[bytes], Any]] = {
    BOOL: decode_bool,
    FLOAT64: decode_float64,
    INT32: decode_int32,
    STRING: decode_string,
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
                value: dict[str, Any] = {field: LINK_VALUE[TABLE.radio[field][slave].msgtype](message.data)}
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


def test_a_rough_link_is_repeated_exactly_with_every_change_of_it_and_tells_of_itself_on_topics(
    start_node: Callable[..., LiveNode], observer: Observer
) -> None:
    node = start_node(
        record_path="run.mcap",
        real_time_factor=4.0,
        radio__slave_1__retries=16,
        radio__slave_1__retry_interval=0.1,
        radio__slave_1__loss_probability=0.4,
        radio__slave_2__in_order=False,
        radio__slave_2__jitter=1.5,
        radio__slave_2__jitter_law="exponential",
        radio__slave_3__duplicate_probability=1.0,
    )
    applied = {slave: observer.watch_typed(channel) for slave, channel in TABLE.applied_brake.items()}
    law = observer.watch_typed(TABLE.radio["jitter_law"]["slave_2"])
    observer.wait_until(lambda: bool(law) and law[-1].data == "exponential", "the law of slave_2")

    def applies(slave: str, demand: float) -> bool:
        return bool(applied[slave]) and applied[slave][-1].data == demand

    def brake(demand: float) -> None:
        observer.send("master", CommandKind.BRAKE, demand)
        for slave in ("slave_1", "slave_3"):
            observer.wait_until(partial(applies, slave, demand), f"{demand} at {slave}")

    for demand in (0.1, 0.2, 0.3, 0.4):
        brake(demand)
    changes: dict[str, Any] = {
        "slave_1.fails": "from_slave",
        "slave_1.retries": 8,
        "slave_1.retry_interval": 0.05,
        "slave_2.jitter_law": "gamma",
        "slave_2.in_order": True,
        "slave_3.duplicate_probability": 0.5,
        "slave_3.burst_length": 0.5,
        "slave_3.burst_spacing": 0.5,
        "slave_3.burst_loss_probability": 0.25,
        "slave_3.retries": 16,
    }
    for name, value in changes.items():
        assert observer.set_parameter(f"radio.{name}", value).successful
    observer.wait_until(lambda: law[-1].data == "gamma", "the new law of slave_2")
    for demand in (0.5, 0.6, 0.7):
        brake(demand)
    assert not observer.set_parameter("radio.slave_1.retries", 17).successful
    assert not observer.set_parameter("radio.slave_1.jitter_law", "cauchy").successful
    assert node.end() == 0

    for chunk_of_steps in (1_000_000, 7):
        samples, differences = replay_differences(node.folder / "run.mcap", chunk_of_steps)
        assert samples > 10
        assert differences == 0
    with Recording(node.folder / "run.mcap") as recording:
        asked = [t.request for t in recording.requests() if isinstance(t.request, RadioLinkChange)]
        events = " ".join(event.text for event in recording.events())
        retries = recording.scalars("slave_1/radio_retries").values.tolist()
        assert replay_and_compare(recording).identical
    assert {(f"{change.slave}.{field}", value) for change in asked for field, value in change.values().items()} == set(
        changes.items()
    )
    assert retries == [16.0, 8.0]
    for what in ("slave_1: sent again", "slave_1: acknowledgement lost", "slave_3: duplicate ignored"):
        assert what in events
