from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

from haul_ros.errors import RecordingError
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.consist import Consist
from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import AppliedBrake
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.recording.info import TopicInfo
from haul_ros.recording.reader import Recording
from haul_ros.recording.series import CouplerSeries, PressureSeries, Samples, VehicleSeries
from haul_ros.recording.writer import McapRecorder

COMMANDS = (
    (0, Command("master", CommandKind.TRACTION, 300e3)),
    (1_000_000_000, Command("slave_1", CommandKind.BRAKE, 0.5)),
    (1_000_000_000, Command("master", CommandKind.BRAKE, 0.8)),
    (1_500_000_000, Command("master", CommandKind.EMERGENCY, 1.0)),
    (9_000_000_000, Command("master", CommandKind.EMERGENCY, 0.0)),
)
LINK_CHANGES = (
    TimedRequest(0, RadioLinkChange("slave_1", delay=2.0, connected=True)),
    TimedRequest(3_000_000_000, RadioLinkChange("slave_1", delay=2.5, connected=False)),
)


@pytest.fixture
def samples(make_sample: Callable[[int], Sample]) -> list[Sample]:
    return [make_sample(step) for step in range(400)]


@pytest.fixture
def run(
    small_chunks: None,
    tmp_path: Path,
    scenario: Scenario,
    encoder: TelemetryEncoder,
    samples: list[Sample],
    extremes: CouplerExtremes,
) -> Path:
    """A run of 400 samples in several chunks, with commands, extremes and the state of the radio."""
    path = tmp_path / "run.mcap"
    with McapRecorder(path, scenario, encoder.channels, when_full="block") as recorder:
        for sample in samples:
            recorder.put(encoder.sample(sample), 1)
        recorder.put(encoder.entries(TimedRequest(time_ns, command) for time_ns, command in COMMANDS), 2)
        recorder.put(encoder.extremes(5_000_000_000, extremes), 3)
        recorder.put(encoder.extremes(6_000_000_000, larger(extremes)), 3)
        recorder.put(encoder.entries(LINK_CHANGES[:1]), 4)
        recorder.put(encoder.entries(LINK_CHANGES[1:]), 5)
    return path


def larger(extremes: CouplerExtremes) -> CouplerExtremes:
    return replace(extremes, compression=extremes.compression * 2.0, tension_time=extremes.tension_time + 1.0)


def series_of(samples: Samples) -> tuple[CouplerSeries | VehicleSeries | PressureSeries, ...]:
    return samples.couplers, samples.vehicles, samples.pressure


def stacked(samples: list[Sample], name: str) -> np.ndarray:
    return np.array([getattr(sample, name) for sample in samples])


def test_samples_are_read_as_they_were(run: Path, consist: Consist, samples: list[Sample]) -> None:
    with Recording(run) as recording:
        couplers, vehicles, pressure = recording.couplers(), recording.vehicles(), recording.pressure()
    for series in (couplers, vehicles, pressure):
        np.testing.assert_array_equal(series.time_ns, [sample.time_ns for sample in samples])
    assert couplers.names == consist.coupler_names
    assert vehicles.names == pressure.names == consist.vehicle_names
    np.testing.assert_array_equal(couplers.stroke, stacked(samples, "stroke"))
    np.testing.assert_array_equal(couplers.stroke_rate, stacked(samples, "stroke_rate"))
    np.testing.assert_array_equal(couplers.force, stacked(samples, "coupler_force"))
    np.testing.assert_array_equal(vehicles.chainage, stacked(samples, "chainage"))
    np.testing.assert_array_equal(vehicles.speed, stacked(samples, "speed"))
    np.testing.assert_array_equal(vehicles.brake_force, stacked(samples, "brake_force"))
    np.testing.assert_array_equal(pressure.pressure, stacked(samples, "cylinder_pressure"))


def test_all_samples_in_one_go_are_the_same_as_one_by_one(run: Path) -> None:
    with Recording(run) as recording:
        together = series_of(recording.samples())
        one_by_one = Samples(recording.couplers(), recording.vehicles(), recording.pressure())
        for series, alone in zip(together, series_of(one_by_one), strict=True):
            assert series.names == alone.names
            for field in fields(series):
                np.testing.assert_array_equal(getattr(series, field.name), getattr(alone, field.name))


def test_pieces_are_of_bounded_size_and_give_the_whole(run: Path) -> None:
    with Recording(run) as recording:
        whole, blocks = series_of(recording.samples()), [series_of(block) for block in recording.blocks()]
    assert len(blocks) > 2
    assert max(len(couplers.time_ns) for couplers, *_ in blocks) < len(whole[0].time_ns) / 2
    for number, series in enumerate(whole):
        pieces = [block[number] for block in blocks]
        for field in fields(series):
            if field.name != "names":
                joined = np.concatenate([getattr(piece, field.name) for piece in pieces])
                np.testing.assert_array_equal(joined, getattr(series, field.name))


def test_pieces_are_not_changed_by_the_next(run: Path) -> None:
    with Recording(run) as recording:
        blocks = recording.blocks()
        first = next(blocks)
        kept = first.couplers.force.copy()
        next(blocks)
        np.testing.assert_array_equal(first.couplers.force, kept)


def test_messages_at_uneven_distances_are_read_the_same(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, samples: list[Sample]
) -> None:
    random = np.random.default_rng(1)
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels, when_full="block") as recorder:
        for sample in samples:
            for _ in range(int(random.integers(0, 4))):
                recorder.put([encoder.real_time_factor(sample.time_ns, 1.0)], 0)
            recorder.put(encoder.sample(sample), 0)
    with Recording(tmp_path / "run.mcap") as recording:
        np.testing.assert_array_equal(recording.couplers().force, stacked(samples, "coupler_force"))
        np.testing.assert_array_equal(recording.pressure().pressure, stacked(samples, "cylinder_pressure"))


def test_messages_that_are_not_in_order_of_time_are_reported(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, samples: list[Sample]
) -> None:
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder:
        recorder.put(encoder.sample(samples[1]), 0)
        recorder.put(encoder.sample(samples[0]), 0)
    with (
        Recording(tmp_path / "run.mcap") as recording,
        pytest.raises(RecordingError, match=r"run\.mcap: damaged recording: .* not in order of time"),
    ):
        recording.couplers()


@pytest.mark.parametrize("node", ["/haul", "/yard/train_a"])
def test_events_are_read_as_they_were(tmp_path: Path, scenario: Scenario, node: str) -> None:
    encoder = TelemetryEncoder(scenario.consist, node)
    events = (Event(5, EventKind.EMERGENCY, "master: emergency latched"), Event(7, EventKind.RADIO, "größer"))
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder:
        recorder.put(encoder.entries(events), 0)
    with Recording(tmp_path / "run.mcap") as recording:
        assert recording.events() == events


def test_events_of_a_version_whose_loggers_were_the_same_in_every_namespace_are_read(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    channels = TelemetryEncoder(scenario.consist, "/yard/train_a").channels
    event = Event(5, EventKind.EMERGENCY, "master: emergency latched")
    (message,) = encoder.entries([event])  # by the logger haul.emergency
    with McapRecorder(tmp_path / "run.mcap", scenario, channels) as recorder:
        recorder.put([message._replace(channel=channels.events)], 0)
    with Recording(tmp_path / "run.mcap") as recording:
        assert recording.events() == (event,)


def test_commands_are_read_in_the_order_in_which_they_came(run: Path) -> None:
    with Recording(run) as recording:
        assert recording.commands() == COMMANDS


def test_changes_of_links_are_read_field_by_field_among_the_commands_but_not_how_the_links_began(run: Path) -> None:
    with Recording(run) as recording:
        requests = recording.requests()
    assert requests == (
        *(TimedRequest(time_ns, command) for time_ns, command in COMMANDS[:-1]),
        TimedRequest(3_000_000_000, RadioLinkChange("slave_1", delay=2.5)),
        TimedRequest(3_000_000_000, RadioLinkChange("slave_1", connected=False)),
        TimedRequest(*COMMANDS[-1]),
    )


def test_extremes_are_read_as_they_were_recorded(run: Path, extremes: CouplerExtremes) -> None:
    with Recording(run) as recording:
        found, last = list(recording.extremes()), recording.last_extremes()
    assert [recorded.time_ns for recorded in found] == [5_000_000_000, 6_000_000_000]
    assert last.time_ns == 6_000_000_000
    for recorded, expected in ((found[0], extremes), (found[1], larger(extremes)), (last, larger(extremes))):
        for field in fields(expected):  # bottomed_time is NaN in both
            np.testing.assert_array_equal(getattr(recorded.extremes, field.name), getattr(expected, field.name))
        assert not np.signbit([recorded.extremes.tension, recorded.extremes.tension_stroke]).any()


def test_extremes_of_a_version_that_had_their_times_in_velocity_are_read(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, extremes: CouplerExtremes
) -> None:
    messages = encoder.extremes(5, extremes, time_in_velocity=True)
    assert [message.channel.topic for message in messages] == ["/haul/max_compression", "/haul/max_tension"]
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder:
        recorder.put(messages, 0)
    with Recording(tmp_path / "run.mcap") as recording:
        found = recording.last_extremes().extremes
    for field in fields(extremes):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(extremes, field.name))


@pytest.mark.parametrize("there", [1, 2, 3])
def test_extremes_that_are_cut_off_between_compression_and_tension_are_left_out(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, extremes: CouplerExtremes, there: int
) -> None:
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder:
        recorder.put(encoder.extremes(5, extremes), 0)
        recorder.put(encoder.extremes(6, extremes)[:there], 0)
    with Recording(tmp_path / "run.mcap") as recording:
        assert recording.last_extremes().time_ns == 5


def test_a_recording_without_extremes_is_refused(tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder) -> None:
    McapRecorder(tmp_path / "empty.mcap", scenario, encoder.channels).close()
    with (
        Recording(tmp_path / "empty.mcap") as recording,
        pytest.raises(RecordingError, match=r"empty\.mcap: holds no /haul/max_compression: nothing was run"),
    ):
        recording.last_extremes()


def test_single_values_are_read_by_relative_or_full_name(run: Path) -> None:
    with Recording(run) as recording:
        times, delays = recording.scalars("slave_1/radio_delay")
        connected = recording.scalars("/haul/slave_1/radio_connected")
        assert recording.scalars("real_time_factor").values.shape == (0,)
    assert (times.tolist(), delays.tolist()) == ([0, 3_000_000_000], [2.0, 2.5])
    assert connected.values.tolist() == [1.0, 0.0]


def test_a_topic_that_is_not_there_or_no_number_is_reported(run: Path) -> None:
    with Recording(run) as recording:
        with pytest.raises(RecordingError, match=r"no topic /haul/slave_2/radio_delay; it has /diagnostics, .*"):
            recording.scalars("slave_2/radio_delay")
        with pytest.raises(RecordingError, match="/haul/couplers is sensor_msgs/msg/JointState, expected std_msgs"):
            recording.scalars("couplers")


def test_information_says_what_is_in_the_file(run: Path, scenario: Scenario) -> None:
    with Recording(run) as recording:
        info = recording.info()
        assert recording.scenario_document == scenario.document
    assert (info.path, info.size) == (run, run.stat().st_size)
    assert (info.scenario, info.description) == (scenario.name, scenario.description)
    assert (info.vehicles, info.couplers, info.locomotives) == (5, 4, ("master", "slave_1"))
    assert (info.time_step, info.compression) == (0.001, "zstd")
    assert (info.start_ns, info.end_ns, info.duration) == (0, 9_000_000_000, 9.0)
    assert (info.messages, info.dropped, info.complete) == (1217, 0, True)
    assert TopicInfo("/haul/couplers", "sensor_msgs/msg/JointState", 400) in info.topics
    assert TopicInfo("/haul/real_time_factor", "std_msgs/msg/Float64", 0) in info.topics
    assert sum(topic.count for topic in info.topics) == info.messages


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_every_compression_is_read_and_reported(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, compression: str
) -> None:
    path = tmp_path / "run.mcap"
    with McapRecorder(path, scenario, encoder.channels, compression=compression) as recorder:
        recorder.put([encoder.real_time_factor(0, 1.5)], 0)
    with Recording(path) as recording:
        assert recording.info().compression == compression
        assert recording.scalars("real_time_factor").values.tolist() == [1.5]


def test_a_recording_of_nothing_is_read(tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder) -> None:
    McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels).close()
    with Recording(tmp_path / "run.mcap") as recording:
        info = recording.info()
        assert (info.messages, info.duration, info.complete) == (0, 0.0, True)
        assert recording.couplers().force.shape == (0, 0)
        assert recording.pressure().pressure.shape == (0, 0)
        assert recording.commands() == ()


def test_private_topics_of_another_node_are_found(tmp_path: Path, scenario: Scenario, consist: Consist) -> None:
    encoder = TelemetryEncoder(consist, "/yard/train_7")
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder:
        recorder.put(encoder.entries([TimedRequest(5, Command("master", CommandKind.BRAKE, 1.0))]), 0)
        recorder.put(encoder.entries([AppliedBrake(6, "master", 1.0)]), 0)
    with Recording(tmp_path / "run.mcap") as recording:
        assert recording.commands() == ((5, Command("master", CommandKind.BRAKE, 1.0)),)
        assert recording.scalars("master/applied_brake").time_ns.tolist() == [6]


def test_a_message_that_does_not_fit_its_topic_is_reported(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, make_sample: Callable[[int], Sample]
) -> None:
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder:
        couplers, vehicles, _ = encoder.sample(make_sample(0))
        recorder.put([couplers, Message(couplers.channel, 1, vehicles.data)], 0)
    with (
        Recording(tmp_path / "run.mcap") as recording,
        pytest.raises(RecordingError, match=r"run\.mcap: damaged recording: .* has not the expected layout"),
    ):
        recording.couplers()


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"run\.mcap: no such file$"):
        Recording(tmp_path / "run.mcap")


def test_a_folder_is_reported(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="cannot be read: Is a directory"):
        Recording(tmp_path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty, expected a recording of haul_ros"),
        (b"\x89MC", "not an MCAP file, expected a recording of haul_ros"),
        (b"name: daqin_1_2_1\n", "not an MCAP file, expected a recording of haul_ros"),
    ],
)
def test_a_file_of_another_kind_is_reported(tmp_path: Path, content: bytes, message: str) -> None:
    (tmp_path / "run.mcap").write_bytes(content)
    with pytest.raises(RecordingError, match=rf"run\.mcap: {message}$"):
        Recording(tmp_path / "run.mcap")


@pytest.mark.parametrize(
    ("profile", "message"), [("ros1", "MCAP profile 'ros1', expected 'ros2'"), ("ros2", "no recording of haul_ros")]
)
def test_an_mcap_file_of_somebody_else_is_reported(tmp_path: Path, profile: str, message: str) -> None:
    with (tmp_path / "run.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile=profile)
        writer.finish()
    with pytest.raises(RecordingError, match=message):
        Recording(tmp_path / "run.mcap")


def read_all(path: Path) -> None:
    with Recording(path) as recording:
        recording.info()
        recording.scenario_document  # noqa: B018
        recording.couplers()
        recording.vehicles()
        recording.pressure()
        recording.commands()
        recording.scalars("slave_1/radio_connected")


def test_a_file_cut_off_anywhere_is_reported(run: Path, tmp_path: Path) -> None:
    content = run.read_bytes()
    cut = tmp_path / "cut.mcap"
    for length in {8, 9, 100, *range(1000, len(content), len(content) // 50), len(content) - 1}:
        cut.write_bytes(content[:length])
        with pytest.raises(
            RecordingError, match=r"cut\.mcap: unfinished or cut off: does not end as an MCAP file does"
        ):
            Recording(cut)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_file_raises_nothing_but_a_recording_error(run: Path, data: st.DataObject) -> None:
    content = bytearray(run.read_bytes())
    # most of a file is in chunks, which a checksum protects: look for trouble at both ends rather
    near_start = st.integers(8, 5000)
    near_end = st.integers(len(content) - 12_000, len(content) - 9)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(near_start | near_end | st.integers(8, len(content) - 9))
        content[at] = data.draw(st.integers(0, 255))
    damaged = run.with_name("damaged.mcap")
    damaged.write_bytes(content)
    try:
        read_all(damaged)
    except RecordingError as err:
        assert str(damaged) in str(err)


def test_a_changed_byte_in_a_chunk_is_noticed(run: Path, tmp_path: Path) -> None:
    content = bytearray(run.read_bytes())
    content[len(content) // 2] ^= 0xFF
    (tmp_path / "damaged.mcap").write_bytes(content)
    with pytest.raises(RecordingError, match=r"damaged\.mcap: damaged recording: "):
        read_all(tmp_path / "damaged.mcap")
