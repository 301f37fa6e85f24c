"""What tests of recordings share."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.event import Event, EventKind
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.recording import run_file, writer
from haul_ros.recording.writer import McapRecorder


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks that the few messages of a test fill several of."""
    monkeypatch.setattr(run_file, "CHUNK_SIZE", 100_000)


@pytest.fixture
def frequent_flushes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A test does not wait a second for each."""
    monkeypatch.setattr(writer, "FLUSH_INTERVAL", 0.05)


@pytest.fixture
def run(
    tmp_path: Path,
    scenario: Scenario,
    encoder: TelemetryEncoder,
    make_sample: Callable[[int], Sample],
    extremes: CouplerExtremes,
) -> Path:
    """A whole recording of twenty samples with a command, an event and the extremes."""
    path = tmp_path / "run.mcap"
    with McapRecorder(path, scenario, encoder.channels, when_full="block") as recorder:
        for step in range(20):
            recorder.put(encoder.sample(make_sample(step)), 1)
        recorder.put(encoder.entries([TimedRequest(5, Command("master", CommandKind.BRAKE, 0.5))]), 2)
        recorder.put(encoder.entries([Event(6, EventKind.RADIO, "lost")]), 2)
        recorder.put(encoder.extremes(1_000_000_000, extremes), 3)
    return path


@pytest.fixture
def wait_until() -> Callable[[Callable[[], bool]], None]:
    """Wait for a condition that another thread brings about."""

    def wait(condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + 30.0
        while not condition():
            assert time.monotonic() < deadline, "condition not reached"
            time.sleep(0.001)

    return wait


@pytest.fixture
def limited_file_size() -> Iterator[None]:
    """Writing a file beyond 100 kB fails, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
