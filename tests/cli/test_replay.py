"""``haul replay``: the same again, and the same driver with something changed."""

from __future__ import annotations

import json
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.records import Message as McapMessage
from mcap.writer import Writer

from haul_ros.analysis.replay import session_with_changes
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.event import EventKind
from haul_ros.model.fault import Fault, FaultKind
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import Request, TimedRequest
from haul_ros.recording import run_file
from haul_ros.recording.reader import Recording
from haul_ros.recording.writer import McapRecorder
from haul_ros.ros.run import TrainRun
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session
from tests.recorded import forge

if TYPE_CHECKING:
    from tests.cli.conftest import Haul

SECOND = 10**9
COMMAND = Command("master", CommandKind.BRAKE, 0.5)
LIVE_REQUESTS: tuple[Request, ...] = (
    RadioLinkChange("slave_1", delay=0.2, jitter=0.1),
    Command("master", CommandKind.BRAKE, 0.3),
    Command("slave_1", CommandKind.BRAKE, 0.6),
    RadioLinkChange("slave_1", loss_probability=1.0),
    Command("slave_1", CommandKind.EMERGENCY, 1.0),
    RadioLinkChange("slave_1", loss_probability=0.0),
    Command("slave_1", CommandKind.BRAKE, 0.2),
    RadioLinkChange("slave_1", connected=False),
    Command("master", CommandKind.EMERGENCY, 1.0),
)


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
    run.start()
    for period in range(150):
        run.advance()
        if period == 10:
            for request in LIVE_REQUESTS[:3]:
                run.request(request)
        if period == 60:
            for request in LIVE_REQUESTS[3:]:
                run.request(request)
    run.close()
    return haul


def sample_messages(path: str) -> list[Message]:
    with Recording(path) as recording:
        return [m for m in recording.state_messages() if m.channel in recording.channels.samples]


def test_a_batch_run_is_repeated_bit_for_bit(recorded: Haul) -> None:
    outcome = recorded("replay", "run.mcap")
    assert (outcome.status, outcome.err) == (0, "")
    with Recording("run.mcap") as recording:
        count = len(list(recording.state_messages()))
        samples = recording.count(recording.channels.couplers)
    assert count > 3 * samples
    assert outcome.out == (
        f"identical: {count} messages of couplers, vehicles, cylinder pressure and extremes, bit for bit\n"
    )


def test_a_live_run_is_repeated_with_its_commands_and_links(live: Haul) -> None:
    with Recording("live.mcap") as recording:
        requests = recording.requests()
    fields = (RadioLinkChange("slave_1", delay=0.2), RadioLinkChange("slave_1", jitter=0.1))
    before, after = 220_000_000, 1_220_000_000
    assert requests == (
        *(TimedRequest(before, request) for request in (*fields, *LIVE_REQUESTS[1:3])),
        *(TimedRequest(after, request) for request in LIVE_REQUESTS[3:]),
    )
    assert live("replay", "live.mcap").status == 0


@pytest.mark.parametrize("field", ["delay", "jitter", "loss_probability"])
def test_a_live_run_without_the_changes_of_one_field_is_another(live: Haul, field: str) -> None:
    with Recording("live.mcap") as recording:
        requests = recording.requests()
        whole = session_with_changes(recording, {})
    kept = [t for t in requests if not isinstance(t.request, RadioLinkChange) or field not in t.request.values()]
    other = Session(whole.scenario, requests=kept)
    for session in (whole, other):
        session.advance(3000)
    assert whole.sample().speed.tobytes() != other.sample().speed.tobytes()


def test_a_recording_from_before_jitter_and_loss_had_topics_is_repeated_bit_for_bit(haul: Haul) -> None:
    """Every change of a link was recorded as its delay and whether it is connected, changed or not."""
    scenario = load_scenario("short.yaml", {"commands": [], "radio.slave_1.jitter_s": 0.3})
    encoder = TelemetryEncoder(scenario.consist)
    channels = replace(
        encoder.channels, radio={field: encoder.channels.radio[field] for field in ("connected", "delay")}
    )
    session = Session(scenario)
    with McapRecorder("old.mcap", scenario, channels, when_full="block") as recorder:
        for period in range(150):
            if period in (0, 20, 60):
                change = RadioLinkChange("slave_1", delay=1.0 + period / 50, connected=period != 60)
                recorder.put(encoder.entries([TimedRequest(session.time_ns, change)]), 0)
                session.request(change)
            if period in (21, 61):
                command = Command("master", CommandKind.BRAKE, 0.3 + period / 100)
                recorder.put(encoder.entries([TimedRequest(session.time_ns, command)]), 0)
                session.request(command)
            recorder.put(encoder.sample(session.advance()), 0)
    with Recording("old.mcap") as recording:
        assert "/haul/slave_1/radio_jitter" not in {info.topic for info in recording.info().topics}
        assert [len(t.request.values()) for t in recording.requests() if isinstance(t.request, RadioLinkChange)] == [
            1
        ] * 4
    outcome = haul("replay", "old.mcap")
    assert outcome.out.startswith("identical: 450 messages")
    assert outcome.status == 0


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
            recorder.put(encoder.entries(recording.requests()), 0)
    outcome = recorded("replay", "changed.mcap")
    assert outcome.status == 1
    assert outcome.out.startswith("different: 1 of ")
    assert "first at 1.000 s in /haul/couplers: coupler_011 force [N]: recorded " in outcome.out
    found = json.loads(recorded("replay", "changed.mcap", "--json").out)
    assert (found["identical"], found["differing"], found["first"]["name"]) == (False, 1, "coupler_011")


def without(source: str, target: str, left_out: Callable[[str, int], bool]) -> None:
    """Copy a recording as other people's tools do, without some messages: all checksums are right."""
    with Path(source).open("rb") as stream, Path(target).open("wb") as copy:
        reader, writer = make_reader(stream), Writer(copy)
        summary = reader.get_summary()
        assert summary is not None
        writer.start("ros2", "another tool")
        metadata = list(reader.iter_metadata())
        for record in metadata[:2]:
            writer.add_metadata(record.name, record.metadata)
        for attachment in reader.iter_attachments():
            writer.add_attachment(
                attachment.create_time, attachment.log_time, attachment.name, attachment.media_type, attachment.data
            )
        schemas = {n: writer.register_schema(s.name, s.encoding, s.data) for n, s in summary.schemas.items()}
        channels = {}
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            if left_out(channel.topic, message.log_time):
                continue
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, schemas[schema.id], dict(channel.metadata)
                )
            writer.add_message(
                channels[channel.id], message.log_time, message.data, message.publish_time, message.sequence
            )
        for record in metadata[2:]:
            writer.add_metadata(record.name, record.metadata)
        writer.finish()


@pytest.mark.no_cover
@pytest.mark.parametrize(
    ("left_out", "told"),
    [
        (lambda topic, _: topic == "/haul/couplers", "of /haul/couplers\n"),
        (lambda topic, _: topic == "/haul/vehicles", "of /haul/vehicles\n"),
        (lambda topic, time: topic == "/haul/couplers" and time == SECOND, "missing: 1 messages of /haul/couplers\n"),
        (lambda _, time: time == SECOND, "missing: 1 messages of /haul/vehicles\n"),
        (lambda topic, _: topic == "/haul/max_tension", "of other topics\n"),
        (lambda _, time: time > 2 * SECOND, "of other topics\n"),
        (lambda topic, _: topic == "/haul/slave_1/radio_delay", "missing: 1 messages of other topics\n"),
    ],
)
def test_a_file_that_lacks_messages_is_not_called_identical(
    recorded: Haul, left_out: Callable[[str, int], bool], told: str
) -> None:
    without("run.mcap", "all.mcap", lambda *_: False)
    assert recorded("replay", "all.mcap").status == 0
    without("run.mcap", "less.mcap", left_out)
    outcome = recorded("replay", "less.mcap")
    assert outcome.status == 1
    assert outcome.out.startswith("incomplete: ")
    assert told in outcome.out
    found = json.loads(recorded("replay", "less.mcap", "--json").out)
    assert not found["identical"]
    assert found["missing"]


def test_a_recording_with_the_times_of_extremes_in_velocity_is_repeated_bit_for_bit(haul: Haul) -> None:
    scenario = load_scenario("short.yaml", {"commands": []})
    encoder = TelemetryEncoder(scenario.consist)
    session = Session(scenario)
    with McapRecorder("old.mcap", scenario, encoder.channels, when_full="block") as recorder:
        session.request(COMMAND)
        recorder.put(encoder.entries([TimedRequest(0, COMMAND)]), 0)
        for _ in range(100):
            recorder.put(encoder.sample(session.advance()), 0)
            recorder.put(encoder.extremes(session.time_ns, session.extremes(), time_in_velocity=True), 0)
    with Recording("old.mcap") as recording:
        assert recording.last_extremes().extremes.compression_time.max() > 0.0
    outcome = haul("replay", "old.mcap")
    assert outcome.out.startswith("identical: 500 messages"), outcome.out


def test_a_changed_extreme_is_found(recorded: Haul) -> None:
    scenario = load_scenario("short.yaml")
    encoder = TelemetryEncoder(scenario.consist)
    with (
        McapRecorder("changed.mcap", scenario, encoder.channels, when_full="block") as recorder,
        Recording("run.mcap") as recording,
    ):
        for message in recording.state_messages():
            data = bytearray(message.data)
            data[-4 - 8 * 10] ^= message.channel == recording.channels.max_tension and message.time_ns == 2 * SECOND
            recorder.put([message._replace(data=bytes(data))], 0)
        recorder.put(encoder.entries(recording.requests()), 0)
    outcome = recorded("replay", "changed.mcap")
    assert outcome.status == 1
    assert "first at 2.000 s in /haul/max_tension: coupler_011 force [N]: recorded " in outcome.out


@pytest.mark.no_cover
@pytest.mark.parametrize("time_ns", [2**63 + 40_000_000, 2**61, 2**59, 1_000_000 * SECOND])
@pytest.mark.parametrize("arguments", [(), ("--set", "initial_speed_kmh=20", "-o", "new.mcap")])
def test_a_forged_time_is_refused_and_not_simulated_up_to(
    recorded: Haul, time_ns: int, arguments: tuple[str, ...]
) -> None:
    scenario = load_scenario("short.yaml")
    encoder = TelemetryEncoder(scenario.consist)
    with McapRecorder("forged.mcap", scenario, encoder.channels, when_full="block") as recorder:
        for message in sample_messages("run.mcap")[:30]:
            recorder.put([message], 0)
        recorder.put([sample_messages("run.mcap")[30]._replace(time_ns=time_ns)], 0)
    outcome = recorded("replay", "forged.mcap", *arguments)
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith("haul: forged.mcap: ")
    assert outcome.err.count("\n") == 1
    assert not Path("new.mcap").exists()


def test_commands_of_the_scenario_are_given_once(recorded: Haul) -> None:
    with Recording("run.mcap") as recording:
        session = session_with_changes(recording, {})
    while not session.finished:
        session.advance()
    given = [entry for entry in session.take_log().entries if isinstance(entry, TimedRequest)]
    assert [entry.request for entry in given if isinstance(entry.request, Command)] == [
        Command("master", CommandKind.EMERGENCY, 1.0)
    ]


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
        assert not [timed for timed in third.requests() if isinstance(timed.request, RadioLinkChange)]


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
    assert recorded("replay", "cut_recovered.mcap").err == ""
    data = Path("run.mcap").read_bytes()
    Path("killed.mcap").write_bytes(data[: data.index(b"messages_written") - 500])
    outcome = recorded("recover", "killed.mcap", "-o", "killed_recovered.mcap")
    assert f"recovered          {count} messages up to " in outcome.out
    outcome = recorded("replay", "killed_recovered.mcap")
    assert outcome.status == 0
    assert outcome.err == "haul: warning: the recorder did not end: a replay may differ\n"


def test_a_recording_of_nothing_is_not_called_identical(haul: Haul) -> None:
    scenario = load_scenario("short.yaml")
    McapRecorder("empty.mcap", scenario, TelemetryEncoder(scenario.consist).channels).close()
    outcome = haul("replay", "empty.mcap")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "haul: empty.mcap: holds no /haul/couplers: nothing was run\n"


def test_what_a_recovered_recording_lacks_is_told_by_every_command(haul: Haul, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_file, "CHUNK_SIZE", 50_000)
    assert haul("run", "short.yaml", "-o", "run.mcap", "--quiet").status == 0
    data = Path("run.mcap").read_bytes()
    with Path("run.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    last = summary.chunk_indexes[-1]
    end = last.chunk_start_offset + last.chunk_length + last.message_index_length
    Path("less.mcap").write_bytes(data[: last.chunk_start_offset] + data[end:])
    outcome = haul("recover", "less.mcap", "-o", "recovered.mcap")
    count = int(outcome.out.split("recovered          ")[1].split()[0])
    missing = summary.statistics.message_count - count
    assert count > 0
    assert f"lost               {missing} messages, dropped while recording or taken out" in outcome.out
    outcome = haul("info", "recovered.mcap")
    assert f"{count}, {missing} more were written and are missing, none dropped" in outcome.out
    outcome = haul("replay", "recovered.mcap")
    assert outcome.status == 1
    assert outcome.out.startswith("incomplete: the same are ")


@pytest.mark.parametrize("command", [("replay", "short.yaml"), ("recover", "short.yaml", "-o", "new.mcap")])
def test_a_file_that_is_no_recording_is_one_line(haul: Haul, command: tuple[str, ...]) -> None:
    outcome = haul(*command)
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "haul: short.yaml: not an MCAP file, expected a recording of haul_ros\n"


def test_an_event_years_after_the_last_sample_costs_no_memory(recorded: Haul) -> None:
    def late(found: list[tuple[str, McapMessage]]) -> list[tuple[str, McapMessage]]:
        (*others, (topic, last)) = [*found, next(pair for pair in found if pair[0].endswith("/applied_brake"))]
        return [*others, (topic, replace(last, log_time=10 * 365 * 86400 * SECOND))]

    forge(Path("run.mcap"), Path("late.mcap"), messages=late)
    tracemalloc.start()
    outcome = recorded("replay", "late.mcap")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert outcome.status == 1
    samples = 10 * 365 * 86400 * 50 + 1
    with Recording("run.mcap") as recording:
        missing = samples - recording.count(recording.channels.couplers)
    assert f"missing: {missing} messages of /haul/couplers" in outcome.out
    assert peak < 100_000_000


def test_faults_of_the_scenario_are_repeated_once_and_replaced_by_others_when_asked(haul: Haul) -> None:
    faults = "faults={leakage_kPa_per_min: 20, events: [{at_s: 0.5, leak: 2, bore_mm: 6}, {at_m: 20, uncouple: 2}]}"
    settings = ("--set", "brakes=pneumatic", "--set", "commands=[]", "--set", faults, "--set", "max_duration_s=12")
    assert haul("run", "short.yaml", *settings, "-o", "run.mcap", "--quiet").status == 0
    with Recording("run.mcap") as recording:
        recorded_faults = [t.request for t in recording.requests() if isinstance(t.request, Fault)]
        told = [event.text for event in recording.events() if event.kind is EventKind.SEPARATION]
        later = session_with_changes(recording, {"faults.events.1.at_m": 60})
    assert recorded_faults == [Fault(FaultKind.LEAK, 2, 0.006), Fault(FaultKind.UNCOUPLE, 2)]
    assert "uncoupled" in told[0]
    assert haul("replay", "run.mcap").status == 0
    later.advance(12_000)
    entries = [entry for entry in later.take_log().entries if isinstance(entry, TimedRequest)]
    asked = [entry for entry in entries if isinstance(entry.request, Fault)]
    assert [entry.request for entry in asked] == recorded_faults
    assert asked[1].time_ns > 2_000_000_000
