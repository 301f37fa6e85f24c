"""Recordings of remapped topics: the file has the topics as they were, readers find them by their part."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.reader import make_reader

from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.consist import Consist
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.recording.description import check_form
from haul_ros.recording.reader import Recording
from haul_ros.recording.recovery import recover
from haul_ros.recording.run_file import description_of
from haul_ros.recording.writer import McapRecorder

TOPICS = {
    "/yard/haul/couplers": "/fleet/couplers",
    "/yard/haul/max_compression": "/yard/haul/max_tension",
    "/yard/haul/max_tension": "/yard/haul/max_compression",
    "/yard/haul/master/brake_command": "/desk/brake",
    "/yard/haul/real_time_factor": "/rtf",
}
COMMAND = Command("master", CommandKind.BRAKE, 0.5)


@pytest.fixture
def remapped(consist: Consist) -> TelemetryEncoder:
    return TelemetryEncoder(
        consist, "/yard/haul", adapt=lambda table: table.resolved(lambda name: TOPICS.get(name, name))
    )


@pytest.fixture
def run(
    tmp_path: Path,
    scenario: Scenario,
    remapped: TelemetryEncoder,
    make_sample: Callable[[int], Sample],
    extremes: CouplerExtremes,
) -> Path:
    messages = [
        *remapped.sample(make_sample(0)),
        *remapped.extremes(0, extremes),
        *remapped.entries([TimedRequest(1, COMMAND)]),
        remapped.real_time_factor(2, 0.75),
    ]
    with McapRecorder(tmp_path / "run.mcap", scenario, remapped.channels) as recorder:
        recorder.put(messages, 0)
    return tmp_path / "run.mcap"


def test_the_file_has_the_topics_as_they_were_and_readers_find_their_part(
    run: Path, tmp_path: Path, make_sample: Callable[[int], Sample], extremes: CouplerExtremes
) -> None:
    recovered = tmp_path / "recovered.mcap"
    recover(run, recovered)
    for path in (run, recovered):
        with path.open("rb") as stream:
            topics = {channel.topic for _, channel, _ in make_reader(stream).iter_messages()}
        assert {"/fleet/couplers", "/desk/brake", "/yard/haul/vehicles", "/rtf"} <= topics
        assert "/yard/haul/couplers" not in topics
        with Recording(path) as recording:
            assert recording.couplers().force.tolist() == [make_sample(0).coupler_force.tolist()]
            assert recording.last_extremes().extremes.compression.tolist() == extremes.compression.tolist()
            assert recording.last_extremes().extremes.tension.tolist() == extremes.tension.tolist()
            assert recording.commands() == ((1, COMMAND),)
            assert recording.scalars("real_time_factor").values.tolist() == [0.75]
            assert recording.scalars("/rtf").values.tolist() == [0.75]


@pytest.mark.parametrize(
    "text",
    ["", "[]", '{"/yard/haul/couplers": 1}', '{"/yard/haul/couplers": "couplers"}', '{"/yard/haul/couplers": "/a b"}',
     "[" * 100_000, '{"/yard/haul/couplers": "/yard/haul/vehicles"}', "{" + '"/a": "/b", ' * 50_000 + '"/a": "/b"}'],
    ids=["empty", "list", "number", "relative", "no topic", "deep", "two on one", "long"],
)  # fmt: skip
def test_what_are_no_topics_is_refused(scenario: Scenario, encoder: TelemetryEncoder, text: str) -> None:
    description = description_of(scenario, encoder.channels, "none") | {"topic_prefix": "/yard/haul"}
    check_form(description)
    with pytest.raises(ValueError, match=r"remapped_topics|remapped to"):
        check_form(description | {"remapped_topics": text})
