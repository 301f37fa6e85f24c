"""A short train's emergency stop, once run, once recorded."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from haul_ros.analysis.history import History, HistoryBuilder
from haul_ros.analysis.numbers import numbers_of
from haul_ros.analysis.scenarios import scenario_of
from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.scenario import Scenario
from haul_ros.recording.trains import open_train
from haul_ros.recording.writer import McapRecorder
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.batch import periods
from haul_ros.simulation.session import Session


@dataclass(frozen=True)
class RecordedRun:
    """A session at its end and the recording of it."""

    session: Session
    path: Path


@pytest.fixture(scope="session")
def scenario(short_train: str) -> Scenario:
    return load_scenario_text(short_train, "short_train")


@pytest.fixture(scope="session")
def run(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> RecordedRun:
    path = tmp_path_factory.mktemp("run") / "short.mcap"
    session, encoder = Session(scenario, play_commands=True), TelemetryEncoder(scenario.consist)
    with McapRecorder(path, scenario, encoder.channels, when_full="block") as recorder:
        for log in periods(session):
            recorder.put(encoder.messages(log), time.time_ns())
    return RecordedRun(session, path)


def history_of(path: Path, columns: int) -> History:
    """As an analysis gathers it."""
    with open_train(path) as source:
        builder = HistoryBuilder(source.samples, columns)
        numbers_of(source, scenario_of(source), also=lambda block, _: builder.add(block))
    return builder.history()


@pytest.fixture
def empty_recording(scenario: Scenario, tmp_path: Path) -> Path:
    """A recording that was closed before the first sample."""
    path = tmp_path / "empty.mcap"
    McapRecorder(path, scenario, TelemetryEncoder(scenario.consist).channels).close()
    return path
