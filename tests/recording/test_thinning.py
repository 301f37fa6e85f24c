"""Recordings of every n-th sample, and of the last."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.event import Event, EventKind
from haul_ros.model.recording_plan import RecordingPlan
from haul_ros.model.sample import Sample
from haul_ros.model.scenario import Scenario
from haul_ros.recording.reader import Recording
from haul_ros.recording.writer import McapRecorder

PERIOD = 20_000_000
MakeSample = Callable[[int], Sample]


def record(path: Path, scenario: Scenario, encoder: TelemetryEncoder, samples: list[Sample]) -> list[Message]:
    """Record samples, each with an event; all their messages."""
    published: list[Message] = []
    with McapRecorder(path, scenario, encoder.channels, when_full="block") as recorder:
        for sample in samples:
            messages = [*encoder.entries([Event(sample.time_ns, EventKind.SLACK, "c: x")]), *encoder.sample(sample)]
            recorder.put(messages, sample.time_ns)
            published += messages
    return published


@pytest.mark.parametrize(("every", "count", "taken"), [(1, 4, [0, 1, 2, 3]), (3, 7, [0, 3, 6]), (3, 9, [0, 3, 6, 8])])
def test_every_nth_sample_is_recorded_and_the_last(
    tmp_path: Path,
    scenario: Scenario,
    encoder: TelemetryEncoder,
    make_sample: MakeSample,
    every: int,
    count: int,
    taken: list[int],
) -> None:
    scenario = replace(scenario, recording=RecordingPlan(every=every))
    published = record(tmp_path / "run.mcap", scenario, encoder, [make_sample(n) for n in range(count)])
    with Recording(tmp_path / "run.mcap") as recording:
        assert recording.couplers().time_ns.tolist() == [n * PERIOD for n in taken]
        recorded = list(recording.state_messages())
        assert len(recorded) == 3 * len(taken)
        assert set(recorded) <= set(published)  # byte for byte
        assert len(recording.events()) == count  # whatever is no sample is recorded
        info = recording.info()
    assert (info.record_rate, info.plan.every) == ((50.0 / every if every > 1 else None), every)
    assert info.complete
    assert info.written == 3 * len(taken) + count


def test_a_sample_out_of_time_is_recorded_only_if_it_is_the_last(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, make_sample: MakeSample
) -> None:
    scenario = replace(scenario, recording=RecordingPlan(every=2))
    odd = replace(make_sample(3), time_ns=2 * PERIOD + 7_000_000)
    for name, last, taken in (("amid", [make_sample(3)], [0, 2, 3]), ("end", [], [0, 2, 2.35])):
        samples = [*(make_sample(n) for n in range(3)), odd, *last]
        record(tmp_path / f"{name}.mcap", scenario, encoder, samples)
        with Recording(tmp_path / f"{name}.mcap") as recording:
            assert recording.couplers().time_ns.tolist() == [n * PERIOD for n in taken]
