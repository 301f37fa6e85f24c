"""Recordings from before some topic was recorded are read and recovered all the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from pathlib import Path

import pytest

from haul_ros.messages.channels import BOOL, FLOAT64, Channel, ChannelTable, channel_table
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.event import Event, EventKind
from haul_ros.model.radio import RadioLink, RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.recording.reader import Recording
from haul_ros.recording.recovery import recover
from haul_ros.recording.writer import McapRecorder

COMMAND = Command("master", CommandKind.BRAKE, 0.5)
EVENT = Event(2, EventKind.RADIO, "slave_1: telegram lost")
TABLE = channel_table(["master", "slave_1"])
SAMPLES = {TABLE.couplers.topic, TABLE.vehicles.topic, TABLE.brake_cylinder_pressure.topic}
LACKING = {
    "links": {channel.topic for channel in TABLE if "/radio_" in channel.topic},
    "all but samples": {channel.topic for channel in TABLE} - SAMPLES,
}


@dataclass(frozen=True)
class OlderTable(ChannelTable):
    """Some channels are not recorded yet."""

    lacking: frozenset[str]

    def __iter__(self) -> Iterator[Channel]:
        return (channel for channel in super().__iter__() if channel.topic not in self.lacking)


@pytest.fixture(params=list(LACKING.values()), ids=list(LACKING))
def lacking(request: pytest.FixtureRequest) -> frozenset[str]:
    """Topics that a recording does not have."""
    return frozenset(request.param)


@pytest.fixture
def messages(
    lacking: frozenset[str],
    encoder: TelemetryEncoder,
    make_sample: Callable[[int], Sample],
    extremes: CouplerExtremes,
) -> list[Message]:
    """Some of every kind, but for those topics."""
    found = [
        *encoder.sample(make_sample(0)),
        *encoder.extremes(0, extremes),
        *encoder.entries([TimedRequest(0, RadioLinkChange.to("slave_1", RadioLink(delay=2.0)))]),
        *encoder.entries([TimedRequest(1, COMMAND), EVENT]),
        encoder.real_time_factor(3, 1.0),
    ]
    return [message for message in found if message.channel.topic not in lacking]


@pytest.fixture
def older(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, lacking: frozenset[str], messages: list[Message]
) -> Path:
    """A recording by a version that did not know those topics."""
    known = {field.name: getattr(encoder.channels, field.name) for field in fields(ChannelTable)}
    with McapRecorder(tmp_path / "older.mcap", scenario, OlderTable(**known, lacking=lacking)) as recorder:
        recorder.put(messages, 0)
    return tmp_path / "older.mcap"


def test_what_an_older_recording_lacks_there_is_none_of(
    older: Path, lacking: frozenset[str], messages: list[Message]
) -> None:
    with Recording(older) as recording:
        assert {topic.topic for topic in recording.info().topics} == {channel.topic for channel in TABLE} - lacking
        assert [len(series.time_ns) for series in recording.samples()] == [1, 1, 1]
        state = {channel.topic for channel in TABLE.state} - lacking
        assert [message for message in messages if message.channel.topic in state] == list(recording.state_messages())
        for channel in recording.channels:
            times = [message.time_ns for message in messages if message.channel == channel]
            assert recording.count(channel) == len(times)
            if channel.msgtype in (BOOL, FLOAT64):
                assert recording.scalars(channel.topic).time_ns.tolist() == times
        has_all_but_links = lacking == LACKING["links"]
        assert recording.commands() == (((1, COMMAND),) if has_all_but_links else ())
        assert len(recording.requests()) == has_all_but_links
        assert recording.events() == ((EVENT,) if has_all_but_links else ())
        assert len(list(recording.extremes())) == has_all_but_links


def test_an_older_recording_that_was_cut_off_is_recovered(older: Path, tmp_path: Path, messages: list[Message]) -> None:
    unfinished = tmp_path / "killed.mcap.active"
    unfinished.write_bytes(older.read_bytes()[:-20])
    result = recover(unfinished, tmp_path / "killed.mcap")
    assert (result.messages, result.missing) == (len(messages), 0)
    with Recording(older) as first, Recording(tmp_path / "killed.mcap") as second:
        assert list(second.state_messages()) == list(first.state_messages())
        assert second.requests() == first.requests()
        assert second.events() == first.events()
