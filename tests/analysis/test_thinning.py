"""Long recordings shown in few columns, read piece by piece."""

from __future__ import annotations

import tracemalloc
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from haul_ros.analysis.bundle import analyze
from haul_ros.analysis.envelopes import Thinning, force_history
from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.scenario import Scenario
from haul_ros.recording import run_file
from haul_ros.recording.reader import JointSeries, Recording
from haul_ros.recording.writer import McapRecorder
from haul_ros.simulation.session import Session

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun


def series(values: np.ndarray) -> JointSeries:
    names = tuple(f"coupler_{j:03d}" for j in range(values.shape[1]))
    return JointSeries(10**9 * np.arange(len(values)), names, values, -values, 2.0 * values)


@pytest.mark.parametrize("columns", [1, 7, 100, 500])
@pytest.mark.parametrize("size", [1, 13, 100])
def test_a_series_in_pieces_is_thinned_as_the_picture_of_the_whole_is(columns: int, size: int) -> None:
    whole = series(np.random.default_rng(1).normal(size=(100, 3)))
    thinning = Thinning(100, columns)
    for start in range(0, 100, size):
        part = slice(start, start + size)
        thinning.add(
            JointSeries(
                whole.time_ns[part], whole.names, whole.position[part], whole.velocity[part], whole.effort[part]
            )
        )
    thinned = thinning.result()
    edges, force = force_history(whole, columns)
    np.testing.assert_array_equal(thinned.effort, force)
    np.testing.assert_array_equal(thinned.time_ns / 1e9, edges[:-1])
    np.testing.assert_array_equal(thinned.position * 2.0, force)
    np.testing.assert_array_equal(force_history(thinned, columns)[1], force)


def test_a_recording_thinned_piece_by_piece_keeps_its_peaks(run: RecordedRun) -> None:
    with Recording(run.path) as recording:
        couplers = recording.couplers()
        thinning = Thinning(len(couplers.time_ns), 20)
        for block in recording.blocks():
            thinning.add(block.couplers)
    np.testing.assert_array_equal(np.abs(thinning.result().effort).max(axis=0), np.abs(couplers.effort).max(axis=0))


def test_an_analysis_needs_no_more_memory_for_a_longer_recording(
    scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_file, "CHUNK_SIZE", 100_000)
    monkeypatch.setattr("haul_ros.analysis.bundle.HISTORY_COLUMNS", 50)
    monkeypatch.setattr("haul_ros.analysis.bundle.save_png", lambda *_: None)
    peaks = []
    for number, samples in enumerate((500, 500, 3000)):  # the first one pays for what is made once
        path = tmp_path / f"{number}.mcap"
        session, encoder = Session(scenario), TelemetryEncoder(scenario.consist)
        with McapRecorder(path, scenario, encoder.channels, when_full="block") as recorder:
            for _ in range(samples):
                recorder.put(encoder.sample(session.advance(5)), 0)
            recorder.put(encoder.extremes(session.time_ns, session.extremes()), 0)
        tracemalloc.start()
        analyze(path, tmp_path / "analysis")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    more_data = 2500 * 8 * (3 * 21 + 4 * 22)
    assert peaks[2] - peaks[1] < more_data / 5
