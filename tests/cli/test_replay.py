"""``haul replay``: the same again, and the same driver with something changed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from mcap.reader import make_reader

from haul_ros.analysis.replay import session_with_changes
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.radio import TimedLink
from haul_ros.recording.reader import Recording
from haul_ros.recording.writer import McapRecorder
from haul_ros.ros.run import TrainRun
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session

if TYPE_CHECKING:
    from tests.cli.conftest import Haul

SECOND = 10**9


@pytest.fixture
def recorded(haul: Haul) -> Haul:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--quiet").status == 0
    return haul


@pytest.fixture
def live(haul: Haul) -> Haul:
    """A live run without its pacing: links and commands change between samples, at one time in this order."""
    scenario = load_scenario("short.yaml", {"commands": [], "radio.slave_1.jitter_s": 0.3})
    encoder = TelemetryEncoder(scenario.consist)
    recorder = McapRecorder("live.mcap", scenario, encoder.channels, when_full="block")
    run = TrainRun(Session(scenario), encoder, lambda _: None, recorder)
    run.tell_start()
    for period in range(150):
        run.advance()
        if period == 10:
            run.command(Command("master", CommandKind.BRAKE, 0.3))
            run.set_radio("slave_1", delay=0.2)
            run.command(Command("slave_1", CommandKind.BRAKE, 0.6))
        if period == 60:
            run.set_radio("slave_1", connected=False)
            run.command(Command("master", CommandKind.EMERGENCY, 1.0))
    run.close()
    return haul


def sample_messages(path: str) -> list[Message]:
    with Recording(path) as recording:
        return list(recording.sample_messages())


def test_a_batch_run_is_repeated_bit_for_bit(recorded: Haul) -> None:
    outcome = recorded("replay", "run.mcap")
    assert (outcome.status, outcome.err) == (0, "")
    count = len(sample_messages("run.mcap"))
    assert outcome.out == f"identical: {count} messages of couplers, vehicles and cylinder pressure, bit for bit\n"


def test_a_live_run_is_repeated_with_its_commands_and_links(live: Haul) -> None:
    with Recording("live.mcap") as recording:
        requests = recording.requests()
    assert [type(request).__name__ for request in requests] == [
        "TimedCommand",
        "TimedLink",
        "TimedCommand",
        "TimedLink",
        "TimedCommand",
    ]
    assert requests[1] == TimedLink(0.22, "slave_1", 0.2, True)
    assert requests[3] == TimedLink(1.22, "slave_1", 0.2, False)
    assert live("replay", "live.mcap").status == 0


def test_a_changed_number_is_found_with_its_time_and_coupler(recorded: Haul) -> None:
    scenario = load_scenario("short.yaml")
    encoder = TelemetryEncoder(scenario.consist)
    with McapRecorder("changed.mcap", scenario, encoder.channels, when_full="block") as recorder:
        for message in sample_messages("run.mcap"):
            if message.time_ns == SECOND and message.channel == encoder.channels.couplers:
                data = bytearray(message.data)
                data[-4 - 8 * 10] ^= 1  # within the eleventh force from the end
                message = message._replace(data=bytes(data))
            recorder.put([message], 0)
        with Recording("run.mcap") as recording:
            recorder.put([encoder.command(time_ns, command) for time_ns, command in recording.commands()], 0)
    outcome = recorded("replay", "changed.mcap")
    assert outcome.status == 1
    assert outcome.out.startswith("different: 1 of ")
    assert "first at 1.000 s in /haul/couplers: coupler_011 force [N]: recorded " in outcome.out
    found = json.loads(recorded("replay", "changed.mcap", "--json").out)
    assert (found["identical"], found["differing"], found["first"]["name"]) == (False, 1, "coupler_011")


def test_commands_of_the_scenario_are_given_once(recorded: Haul) -> None:
    with Recording("run.mcap") as recording:
        session = session_with_changes(recording, {})
    while not session.finished:
        session.advance()
    assert len(session.take_commands()) == 1


def test_the_same_driver_with_another_radio_delay_is_another_run_in_a_new_file(recorded: Haul) -> None:
    outcome = recorded("replay", "run.mcap", "--set", "radio.default.delay_s=3", "-o", "late.mcap")
    assert (outcome.status, outcome.err) == (0, "")
    assert "run.mcap, and again with radio.default.delay_s=3: late.mcap" in outcome.out
    with Recording("run.mcap") as first, Recording("late.mcap") as second:
        assert first.commands() == second.commands()
        assert second.scalars("slave_1/applied_brake").time_ns.tolist() == [0, SECOND * 7 // 2]
        peaks = [float(r.last_extremes().extremes.compression.max()) / 1e3 for r in (first, second)]
    (line,) = (line for line in outcome.out.splitlines() if line.startswith("  compression [kN]"))
    assert line.split()[2:] == [f"{peak:.3f}" for peak in peaks]
    assert recorded("replay", "late.mcap").status == 0
    expected = recorded("run", "short.yaml", "--set", "radio.default.delay_s=3", "-o", "direct.mcap", "--quiet")
    assert expected.status == 0
    with Recording("late.mcap") as late, Recording("direct.mcap") as direct:
        np.testing.assert_array_equal(late.couplers().force, direct.couplers().force)


def test_recorded_links_are_kept_unless_the_radio_is_changed(live: Haul) -> None:
    assert live("replay", "live.mcap", "--set", "initial_speed_kmh=25", "-o", "fast.mcap").status == 0
    with Recording("live.mcap") as first, Recording("fast.mcap") as second:
        assert second.requests() == first.requests()
    assert live("replay", "fast.mcap").status == 0
    assert live("replay", "live.mcap", "--set", "radio.slave_1.delay_s=2", "-o", "late.mcap").status == 0
    with Recording("late.mcap") as third:
        assert not [request for request in third.requests() if isinstance(request, TimedLink)]


def test_a_change_without_a_file_for_it_is_refused(recorded: Haul) -> None:
    outcome = recorded("replay", "run.mcap", "--set", "initial_speed_kmh=25")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "haul: --set changes the run: expected -o NEW.mcap, the file to record it to\n"


def test_a_file_that_is_there_is_kept(recorded: Haul) -> None:
    outcome = recorded("replay", "run.mcap", "-o", "run.mcap")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "haul: run.mcap: exists already and is not overwritten, expected a new name\n"


def test_a_recording_that_may_lack_commands_is_warned_of(recorded: Haul) -> None:
    Path("cut.mcap").write_bytes(Path("run.mcap").read_bytes()[:-1])
    outcome = recorded("info", "cut.mcap")
    assert outcome.status == 2
    assert outcome.err.endswith("to recover it: haul recover cut.mcap -o cut_recovered.mcap\n")
    outcome = recorded("recover", "cut.mcap", "-o", "cut_recovered.mcap")
    assert outcome.status == 0
    with Path("run.mcap").open("rb") as stream:
        count = sum(1 for _ in make_reader(stream).iter_messages())
    assert f"recovered          {count} messages up to " in outcome.out
    assert "lost               nothing of the file" in outcome.out
    outcome = recorded("replay", "cut_recovered.mcap")
    assert outcome.status == 0
    assert outcome.err == "haul: warning: the recorder did not end: a replay may differ\n"


def test_a_recording_of_nothing_is_not_called_identical(haul: Haul) -> None:
    scenario = load_scenario("short.yaml")
    McapRecorder("empty.mcap", scenario, TelemetryEncoder(scenario.consist).channels).close()
    outcome = haul("replay", "empty.mcap")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "haul: empty.mcap: holds no /haul/couplers: nothing was run\n"


@pytest.mark.parametrize("command", [("replay", "short.yaml"), ("recover", "short.yaml", "-o", "new.mcap")])
def test_a_file_that_is_no_recording_is_one_line(haul: Haul, command: tuple[str, ...]) -> None:
    outcome = haul(*command)
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "haul: short.yaml: not an MCAP file, expected a recording of haul_ros\n"
