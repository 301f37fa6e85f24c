"""The node live: commands in, braking out, at the right simulation times; topics, services, parameters, recording."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from mcap.reader import make_reader

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.radio import RadioLinkChange
from haul_ros.recording.reader import Recording
from haul_ros.ros.unrecorded import CLOCK_CHANNEL
from haul_ros.scenario import load_scenario, load_scenario_text
from haul_ros.units import seconds_to_ns
from tests.empirical import wave_brakes
from tests.ros.live_node import LOCOMOTIVES, TABLE, Couplers

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

    StartNode = Callable[..., LiveNode]

SECOND = 10**9
PERIOD = SECOND // 50
BRAKE, EMERGENCY, TRACTION = CommandKind.BRAKE, CommandKind.EMERGENCY, CommandKind.TRACTION


def diagnostics(received: list[Any]) -> dict[str, Any]:
    """The newest status of each part by name, with its values as ``values_by_key``."""
    return {status.name.removeprefix("haul: "): status for status in received[-1].status} if received else {}


def padded(data: bytes) -> bytes:
    """Filled up to whole words, as DDS may do on the way."""
    return data + bytes(-len(data) % 4)


def value_of(status: Any, key: str) -> str:
    return str({item.key: item.value for item in status.values}[key])


def test_an_emergency_acts_on_the_master_at_once_on_slaves_after_their_delay_and_on_wagons_with_the_wave(
    start_node: StartNode, observer: Observer, tmp_path: Path
) -> None:
    delays = {"master": 0.0, "slave_1": 0.5, "slave_2": 1.25, "slave_3": 2.0}
    node = start_node(
        record_path="run.mcap",
        real_time_factor=10.0,
        radio__slave_1__delay=0.5,
        radio__slave_2__delay=1.25,
        radio__slave_3__delay=2.0,
    )
    couplers = Couplers(observer)
    couplers.wait_for_time(SECOND)
    observer.send("master", EMERGENCY, True)
    applied = observer.watch_typed(TABLE.applied_brake["slave_3"])
    observer.wait_until(lambda: bool(applied) and applied[-1].data == 1.0, "the emergency at the last slave")
    couplers.wait_for_time(couplers.time_ns + 10 * SECOND)
    assert node.end() == 0

    with Recording(node.folder / "run.mcap") as recording:
        ((commanded_ns, command),) = recording.commands()
        assert command == Command("master", EMERGENCY, 1.0)
        braked_ns = {name: commanded_ns + seconds_to_ns(delay) for name, delay in delays.items()}
        for name in LOCOMOTIVES:
            times, values = recording.scalars(f"{name}/applied_brake")
            assert times.tolist() == [0, braked_ns[name]]
            assert values.tolist() == [0.0, 1.0]
        scenario = load_scenario_text(recording.scenario_document, "run")
        series = recording.pressure()

    offsets = np.array(scenario.consist.centre_offsets)
    waves = [
        braked_ns[locomotive.name]
        + np.abs(offsets - offsets[locomotive.vehicle]) / wave_brakes(scenario).wave_speeds.emergency * SECOND
        for locomotive in scenario.consist.locomotives
    ]
    arrival_ns = np.min(waves, axis=0)
    braked = series.pressure > 0.0
    assert braked.any(axis=0).all()
    first_seen_ns = series.time_ns[braked.argmax(axis=0)]
    assert (first_seen_ns >= arrival_ns).all()
    assert (first_seen_ns - arrival_ns <= PERIOD + 1).all()


def test_arrays_have_every_coupler_and_vehicle_with_its_name(start_node: StartNode, observer: Observer) -> None:
    start_node(record_path="none", initial_speed=20.0)
    couplers = observer.watch_typed(TABLE.couplers)
    vehicles = observer.watch_typed(TABLE.vehicles)
    pressures = observer.watch_typed(TABLE.brake_cylinder_pressure)
    extremes = observer.watch_typed(TABLE.max_compression)
    observer.wait_until(lambda: all((couplers, vehicles, pressures, extremes)), "all arrays")
    consist = load_scenario("daqin_1_2_1").consist
    assert list(couplers[0].name) == [f"coupler_{n:03d}" for n in range(1, 208)]
    assert list(vehicles[0].name) == list(consist.vehicle_names)
    assert vehicles[0].name[0] == "vehicle_001_SS4"
    assert list(extremes[0].name) == list(couplers[0].name)
    for message, size in ((couplers[0], 207), (vehicles[0], 208), (extremes[0], 207)):
        assert len(message.position) == len(message.velocity) == len(message.effort) == size
    assert vehicles[0].velocity[0] == pytest.approx(20.0, abs=0.5)
    (dimension,) = pressures[0].layout.dim
    assert (dimension.label, dimension.size, len(pressures[0].data)) == ("vehicle", 208, 208)


def test_the_file_holds_what_was_published_byte_for_byte(start_node: StartNode, observer: Observer) -> None:
    node = start_node(record_path="run.mcap", radio__slave_1__delay=0.1)
    received = {c.topic: observer.watch(c) for c in TABLE if not c.received}
    couplers = received[TABLE.couplers.topic]
    observer.send("master", BRAKE, 0.5)
    observer.wait_until(lambda: len(couplers) >= 100 and all(received.values()), "messages on every topic")
    assert node.end() == 0

    recorded: dict[str, list[bytes]] = {topic: [] for topic in received}
    with (node.folder / "run.mcap").open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            recorded.setdefault(channel.topic, []).append(padded(message.data))
    for topic, serialized in received.items():
        messages = [padded(data) for data in serialized]
        # Early messages may be equal, such as the pressure before the brakes apply: try every place in the file.
        pieces = (recorded[topic][start : start + len(messages)] for start in range(len(recorded[topic])))
        assert any(piece == messages for piece in pieces), topic
    assert len(recorded[TABLE.commands[BRAKE]["master"].topic]) == 1


def test_who_subscribes_late_gets_the_applied_brake_and_the_state_of_the_radio(
    start_node: StartNode, observer: Observer
) -> None:
    values = {"connected": False, "delay": 3.0, "jitter": 0.25, "loss_probability": 0.125}
    start_node(record_path="none", **{f"radio__slave_2__{field}": value for field, value in values.items()})
    Couplers(observer).wait_for_time(PERIOD)
    applied = observer.watch_typed(TABLE.applied_brake["slave_2"])
    link = {field: observer.watch_typed(TABLE.radio[field]["slave_2"]) for field in values}
    observer.wait_until(lambda: all((applied, *link.values())), "the latched topics")
    assert applied[0].data == 0.0
    assert {field: messages[0].data for field, messages in link.items()} == values


def test_a_radio_delay_set_while_running_acts_on_the_next_command(start_node: StartNode, observer: Observer) -> None:
    node = start_node(record_path="run.mcap", real_time_factor=5.0, radio__slave_1__delay=0.5)
    applied = observer.watch_typed(TABLE.applied_brake["slave_1"])
    events = observer.watch_typed(TABLE.events)

    def send_and_wait(demand: float) -> None:
        observer.send("slave_1", BRAKE, demand)
        observer.wait_until(lambda: bool(applied) and applied[-1].data == demand, f"demand {demand}")

    send_and_wait(0.3)
    assert observer.set_parameter("radio.slave_1.delay", 1.25).successful
    send_and_wait(0.6)
    assert observer.set_parameter("radio.slave_1.connected", False).successful
    observer.send("slave_1", BRAKE, 0.9)
    observer.wait_until(lambda: any("telegram lost: brake 0.9" in e.msg for e in events), "the telegram that is lost")
    assert node.end() == 0

    with Recording(node.folder / "run.mcap") as recording:
        (first, _), (second, _), _ = recording.commands()
        times, values = recording.scalars("slave_1/applied_brake")
        delays = recording.scalars("slave_1/radio_delay")
        connected = recording.scalars("slave_1/radio_connected")
    assert values.tolist() == [0.0, 0.3, 0.6]
    assert times.tolist() == [0, first + SECOND // 2, second + 5 * SECOND // 4]
    assert delays.values.tolist() == [0.5, 1.25]
    assert connected.values.tolist() == [1.0, 0.0]
    assert first < delays.time_ns[1] <= second < connected.time_ns[1]


def test_jitter_and_loss_set_while_running_act_on_the_next_command_and_are_published(
    start_node: StartNode, observer: Observer
) -> None:
    node = start_node(record_path="run.mcap", real_time_factor=5.0)
    applied = observer.watch_typed(TABLE.applied_brake["slave_1"])
    jitter = observer.watch_typed(TABLE.radio["jitter"]["slave_1"])
    loss = observer.watch_typed(TABLE.radio["loss_probability"]["slave_1"])
    delay = observer.watch_typed(TABLE.radio["delay"]["slave_1"])
    events = observer.watch_typed(TABLE.events)
    observer.wait_until(lambda: all((applied, jitter, loss, delay)), "the latched topics")
    assert observer.set_parameter("radio.slave_1.loss_probability", 1.0).successful
    observer.send("slave_1", BRAKE, 0.9)
    observer.wait_until(lambda: any("telegram lost: brake 0.9" in e.msg for e in events), "the lost telegram")
    assert observer.set_parameter("radio.slave_1.loss_probability", 0.0).successful
    assert observer.set_parameter("radio.slave_1.jitter", 2.0).successful
    observer.send("slave_1", BRAKE, 0.3)
    observer.wait_until(lambda: applied[-1].data == 0.3, "the demand that gets through")
    assert [message.data for message in jitter] == [0.0, 2.0]
    assert [message.data for message in loss] == [0.0, 1.0, 0.0]
    assert [message.data for message in delay] == [0.0]
    assert observer.parameter("radio.slave_1.jitter").double_value == 2.0
    refused = observer.set_parameter("radio.slave_1.loss_probability", 1.5)
    assert not refused.successful
    assert node.end() == 0

    with Recording(node.folder / "run.mcap") as recording:
        changes = [t.request for t in recording.requests() if isinstance(t.request, RadioLinkChange)]
        (_, (sent_ns, _)) = recording.commands()
        times, values = recording.scalars("slave_1/applied_brake")
    assert changes == [
        RadioLinkChange("slave_1", loss_probability=1.0),
        RadioLinkChange("slave_1", loss_probability=0.0),
        RadioLinkChange("slave_1", jitter=2.0),
    ]
    assert values.tolist() == [0.0, 0.3]
    assert 0 < times[1] - sent_ns <= 2 * SECOND


@pytest.mark.measured
def test_parameters_that_cannot_be_set_keep_their_value_and_say_why(start_node: StartNode, observer: Observer) -> None:
    start_node(record_path="none", dt=0.0005, real_time_factor=0)
    assert observer.parameter("dt").double_value == 0.0005
    assert observer.parameter("publish_rate").double_value == 50.0
    assert observer.parameter("initial_speed").double_value == pytest.approx(80 / 3.6)
    assert observer.parameter("radio.slave_3.delay").double_value == 0.0
    assert "read-only" in observer.set_parameter("dt", 0.001).reason
    for value in (-1.0, math.nan, 1e9):
        refused = observer.set_parameter("radio.slave_3.delay", value)
        assert not refused.successful
        assert "radio.slave_3.delay" in refused.reason
    assert "must be 0 or 0.001 to 1000" in observer.set_parameter("real_time_factor", 1e-9).reason
    assert observer.parameter("radio.slave_3.delay").double_value == 0.0


def test_a_changed_real_time_factor_acts_at_once(start_node: StartNode, observer: Observer) -> None:
    start_node(record_path="none", real_time_factor=0.001, publish_rate=1)
    assert observer.pause().message == "paused at 0.000 s"
    assert observer.pause(False).success
    couplers = Couplers(observer)
    assert observer.set_parameter("real_time_factor", 100.0).successful
    couplers.wait_for_time(5 * SECOND)


@pytest.mark.measured
def test_pause_holds_the_time_step_advances_one_period_and_running_goes_on(
    start_node: StartNode, observer: Observer
) -> None:
    start_node(record_path="none")
    couplers = Couplers(observer)
    couplers.wait_for_time(PERIOD)
    refused = observer.step()
    assert not refused.success
    assert "only while paused" in refused.message
    paused = observer.pause()
    assert paused.success
    paused_at = float(paused.message.split()[2])
    stepped = [observer.step().message for _ in range(3)]
    assert stepped == [f"stepped at {paused_at + n * 0.02:.3f} s" for n in (1, 2, 3)]
    couplers.wait_for_time(seconds_to_ns(paused_at + 0.06))
    assert couplers.time_ns == seconds_to_ns(paused_at + 0.06)
    assert observer.pause(False).success
    couplers.wait_for_time(couplers.time_ns + 5 * PERIOD)


@pytest.mark.measured
def test_a_reset_starts_again_without_the_emergency_and_with_a_new_recording(
    start_node: StartNode, observer: Observer
) -> None:
    node = start_node(record_path="run.mcap", reset_interval=0.0)
    applied = observer.watch_typed(TABLE.applied_brake["master"])
    observer.send("master", EMERGENCY, True)
    observer.wait_until(lambda: bool(applied) and applied[-1].data == 1.0, "the emergency")
    assert observer.set_parameter("radio.slave_1.delay", 0.75).successful
    assert observer.set_parameter("radio.slave_1.jitter", 0.5).successful
    assert observer.pause().success
    answer = observer.reset()
    assert answer.success
    assert answer.message == "started again at 0.000 s"
    observer.wait_until(lambda: applied[-1].data == 0.0, "the release by the reset")
    assert observer.step().message == "stepped at 0.020 s"
    assert observer.reset().success
    assert node.end() == 0

    assert sorted(path.name for path in node.folder.iterdir()) == ["run.mcap", "run_2.mcap", "run_3.mcap"]
    with Recording(node.folder / "run_2.mcap") as recording:
        scenario = load_scenario_text(recording.scenario_document, "run_2")
        times, values = recording.scalars("master/applied_brake")
        couplers = recording.couplers()
        extremes = recording.last_extremes()
    assert (scenario.radio["slave_1"].delay, scenario.radio["slave_1"].jitter) == (0.75, 0.5)
    assert (times.tolist(), values.tolist()) == ([0], [0.0])
    assert couplers.time_ns.tolist() == [0, PERIOD]
    assert extremes.time_ns == PERIOD


def test_resets_cannot_fill_a_disk(start_node: StartNode, observer: Observer) -> None:
    node = start_node(record_path="run.mcap", reset_interval=3600.0, max_recordings=3)
    Couplers(observer).wait_for_time(PERIOD)
    assert observer.reset().success
    answer = observer.reset()
    assert not answer.success
    assert answer.message == "refused: at most one reset in 3600 s (parameter reset_interval)"
    assert observer.set_parameter("reset_interval", 0.0).successful
    assert observer.reset().success
    answer = observer.reset()
    assert not answer.success
    assert answer.message == "refused: 3 recordings were begun, which is all (parameter max_recordings)"
    assert node.end() == 0
    assert len(list(node.folder.iterdir())) == 3


@pytest.mark.measured
def test_a_second_node_of_the_same_name_is_told_of(start_node: StartNode, observer: Observer) -> None:
    often = "from haul_ros.ros import train_node; train_node._NAMESAKES_PERIOD = 0.5"
    nodes = [start_node(record_path="none", prelude=often) for _ in range(2)]
    observer.wait_until(
        lambda: any("another node /haul is running" in node.log for node in nodes), "a warning of a second node"
    )


@pytest.mark.measured
def test_commands_that_cannot_be_change_nothing_are_counted_and_logged(
    start_node: StartNode, observer: Observer
) -> None:
    node = start_node(record_path="run.mcap")
    reports = observer.watch_typed(TABLE.diagnostics)
    applied = observer.watch_typed(TABLE.applied_brake["slave_3"])
    for value in (math.nan, math.inf, -0.1, 1.01):
        observer.send("master", BRAKE, value)
    observer.send("slave_1", TRACTION, -1.0)
    observer.send("slave_3", EMERGENCY, True)
    observer.wait_until(lambda: bool(applied) and applied[-1].data == 1.0, "the emergency of slave_3")
    observer.send("slave_3", EMERGENCY, False)
    observer.wait_until(
        lambda: bool(reports) and value_of(diagnostics(reports)["commands"], "rejected") == "6", "six rejected commands"
    )
    commands = diagnostics(reports)["commands"]
    assert commands.level == b"\x01"
    assert value_of(commands, "accepted") == "1"
    assert node.end() == 0
    assert "/haul/master/brake_command: nan rejected" in node.log
    assert "/haul/slave_3/emergency_brake: 0.0 rejected" in node.log
    assert "/haul/slave_1/traction_command: -1.0 rejected" in node.log
    with Recording(node.folder / "run.mcap") as recording:
        ((_, command),) = recording.commands()
        assert command == Command("slave_3", EMERGENCY, 1.0)
        assert recording.scalars("slave_3/applied_brake").values.tolist() == [0.0, 1.0]
        for name in ("master", "slave_1", "slave_2"):
            assert recording.scalars(f"{name}/applied_brake").values.tolist() == [0.0]


def test_a_train_at_standstill_goes_on_publishing_and_may_end_its_emergency(
    start_node: StartNode, observer: Observer
) -> None:
    node = start_node(record_path="run.mcap", real_time_factor=0.0, initial_speed=1.0)
    applied = observer.watch_typed(TABLE.applied_brake["master"])
    observer.send("master", EMERGENCY, True)
    vehicles = observer.watch_typed(TABLE.vehicles)
    observer.wait_until(lambda: bool(vehicles) and not any(vehicles[-1].velocity), "standstill")
    stood = len(vehicles)
    observer.wait_until(lambda: len(vehicles) > stood + 10, "samples at standstill")
    observer.send("master", EMERGENCY, False)
    observer.wait_until(lambda: applied[-1].data == 0.0, "the end of the emergency")
    assert node.end() == 0
    with Recording(node.folder / "run.mcap") as recording:
        assert [command.value for _, command in recording.commands()] == [1.0, 0.0]
        assert recording.info().complete


def test_the_clock_is_published_with_every_sample_if_asked_for_and_never_recorded(
    start_node: StartNode, observer: Observer
) -> None:
    node = start_node(record_path="run.mcap", publish_clock=True)
    clock = observer.watch_typed(CLOCK_CHANNEL)
    couplers = observer.watch_typed(TABLE.couplers)
    observer.wait_until(lambda: len(clock) > 20 and len(couplers) > 20, "the clock")
    assert node.end() == 0
    times = [message.clock.sec * SECOND + message.clock.nanosec for message in clock]
    assert times == sorted(times)
    assert all(time % PERIOD == 0 for time in times)
    with Recording(node.folder / "run.mcap") as recording:
        assert "/clock" not in {info.topic for info in recording.info().topics}


def test_the_timed_commands_of_the_scenario_are_played_only_if_asked_for(
    start_node: StartNode, observer: Observer
) -> None:
    played = start_node(record_path="none", scenario_commands=True)
    applied = observer.watch_typed(TABLE.applied_brake["master"])
    observer.wait_until(lambda: bool(applied) and applied[-1].data == 1.0, "the scenario's emergency at 0 s")
    assert played.end() == 0
    start_node(record_path="none")
    couplers = Couplers(observer)
    couplers.wait_for_time(5 * PERIOD)
    observer.wait_until(lambda: applied[-1].data == 0.0, "the second node's brakes")


def test_diagnostics_are_about_pacing_solver_radio_commands_and_recorder(
    start_node: StartNode, observer: Observer
) -> None:
    start_node(record_path="run.mcap", radio__slave_3__connected=False)
    reports = observer.watch_typed(TABLE.diagnostics)
    factors = observer.watch_typed(TABLE.real_time_factor)
    observer.send("master", BRAKE, 0.4)
    observer.wait_until(
        lambda: bool(reports) and value_of(diagnostics(reports)["commands"], "accepted") == "1" and bool(factors),
        "a report after the command",
    )
    parts = diagnostics(reports)
    assert set(parts) == {"pacing", "solver", "radio", "commands", "recorder"}
    assert int(value_of(parts["solver"], "steps")) > 0
    assert value_of(parts["solver"], "unconverged steps") == "0"
    assert (parts["radio"].level, parts["radio"].message) == (b"\x01", "no link to slave_3")
    assert value_of(parts["radio"], "slave_1 sent") == "1"
    assert int(value_of(parts["recorder"], "written")) > 0
    assert value_of(parts["recorder"], "dropped") == "0"
    assert factors[-1].data > 0.0
