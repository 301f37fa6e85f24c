"""Other people's readers on our files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.rosbag2.metadata import parse_qos
from ruamel.yaml import YAML

from haul_ros.messages.encoder import DiagnosticStatus, Message, TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import Sample
from haul_ros.model.scenario import Scenario
from haul_ros.recording.writer import McapRecorder


@pytest.fixture
def messages(encoder: TelemetryEncoder, make_sample: Callable[[int], Sample]) -> list[Message]:
    """Some of every type."""
    return [
        *(message for step in range(100) for message in encoder.sample(make_sample(step))),
        *encoder.entries(
            [
                TimedRequest(2_000_000_000, Command("slave_1", CommandKind.BRAKE, 0.5)),
                TimedRequest(2_000_000_001, Command("master", CommandKind.EMERGENCY, 1.0)),
            ]
        ),
        encoder.diagnostics(2_000_000_002, [DiagnosticStatus(1, "loop", "late", "train", {"overruns": "3"})]),
    ]


EVERY_COMPRESSION = pytest.mark.parametrize("run", ["zstd", "lz4", "none"], indirect=True)


@pytest.fixture
def run(
    request: pytest.FixtureRequest,
    tmp_path: Path,
    scenario: Scenario,
    encoder: TelemetryEncoder,
    messages: list[Message],
) -> Path:
    path = tmp_path / "run.mcap"
    with McapRecorder(path, scenario, encoder.channels, compression=getattr(request, "param", "zstd")) as recorder:
        for message in messages:
            recorder.put([message], 1_700_000_000_000_000_000)
    return path


@EVERY_COMPRESSION
def test_rosbags_reads_every_message(run: Path, messages: list[Message], encoder: TelemetryEncoder) -> None:
    with AnyReader([run]) as reader:
        qos = {c.topic: c.ext.offered_qos_profiles for c in reader.connections}  # type: ignore[union-attr]
        read = [(c.topic, c.msgtype, time_ns, bytes(data)) for c, time_ns, data in reader.messages()]
        decoded = [reader.deserialize(data, c.msgtype) for c, _, data in reader.messages()]
    assert qos == {channel.topic: [channel.qos] for channel in encoder.channels}
    assert read == [(m.channel.topic, m.channel.msgtype, m.time_ns, m.data) for m in messages]
    assert len(decoded) == len(messages)


@EVERY_COMPRESSION
def test_the_mcap_library_decodes_every_message(
    run: Path, messages: list[Message], make_sample: Callable[[int], Sample]
) -> None:
    decoder = pytest.importorskip("mcap_ros2.decoder")
    with run.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[decoder.DecoderFactory()])
        decoded = list(reader.iter_decoded_messages())
    assert [(d.channel.topic, d.message.data) for d in decoded] == [(m.channel.topic, m.data) for m in messages]
    couplers = [d.decoded_message for d in decoded if d.channel.topic == "/haul/couplers"]
    np.testing.assert_array_equal(couplers[7].effort, make_sample(7).coupler_force)
    assert (couplers[99].header.stamp.sec, couplers[99].header.stamp.nanosec) == (1, 980_000_000)
    assert decoded[-1].decoded_message.status[0].values[0].value == "3"
    assert decoded[-2].decoded_message.data is True


def test_a_file_has_what_the_profile_of_ros2_asks_for(
    run: Path, messages: list[Message], encoder: TelemetryEncoder
) -> None:
    with run.open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        assert reader.get_header().library.startswith("haul_ros ")
        summary = reader.get_summary()
        records = list(reader.iter_metadata())
    assert summary is not None
    assert {channel.topic for channel in summary.channels.values()} == {channel.topic for channel in encoder.channels}
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        assert (channel.message_encoding, schema.encoding) == ("cdr", "ros2msg")
        assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
        assert len(parse_qos(channel.metadata["offered_qos_profiles"])) == 1
    assert [record.name for record in records] == ["rosbag2", "haul_ros"] * 2
    opened, closed = (YAML(typ="safe").load(r.metadata["serialized_metadata"]) for r in records if r.name == "rosbag2")
    assert (opened["message_count"], closed["message_count"]) == (0, len(messages))
    assert closed["duration"] == {"nanoseconds": 2_000_000_002}
    assert closed["starting_time"] == {"nanoseconds_since_epoch": 0}
