"""Long recordings shown in few columns, read piece by piece."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from haul_ros.analysis.history import Thinning
from haul_ros.errors import RecordingError
from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.sample import FloatArray
from haul_ros.model.scenario import Scenario
from haul_ros.recording.reader import Recording
from haul_ros.recording.writer import McapRecorder
from haul_ros.simulation.session import Session
from tests.analysis.conftest import history_of

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun

SECOND = 10**9


def thinned(values: FloatArray, columns: int, size: int, period_ns: int = SECOND) -> Thinning:
    """Of one sample a period, added in pieces of a size."""
    thinning = Thinning(len(values), columns)
    time_ns = period_ns * np.arange(len(values))
    for start in range(0, len(values), size):
        thinning.add(time_ns[start : start + size], values[start : start + size])
    return thinning


@pytest.mark.parametrize("size", [1, 2])
def test_few_samples_are_shown_as_they_are(size: int) -> None:
    found = thinned(np.array([[1.0, -2.0], [3.0, 0.0]]), 10, size)
    assert found.time.tolist() == [0.0, 1.0]
    assert found.values.tolist() == [[1.0, -2.0], [3.0, 0.0]]


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_many_samples_share_columns_that_keep_the_largest_magnitude_with_its_sign(size: int) -> None:
    values = np.array([[1.0, 5.0], [-4.0, 1.0], [2.0, 0.0], [3.0, -1.0]])
    found = thinned(values, 2, size, SECOND // 2)
    assert found.time.tolist() == [0.0, 1.0]
    assert found.values.tolist() == [[-4.0, 5.0], [3.0, -1.0]]


@pytest.mark.parametrize("columns", [1, 7, 100, 500])
def test_a_series_in_pieces_is_thinned_as_the_whole_is_and_loses_no_peak(columns: int) -> None:
    values = np.random.default_rng(1).normal(size=(100, 3))
    whole = thinned(values, columns, 100)
    assert whole.values.shape == (min(columns, 100), 3)
    np.testing.assert_array_equal(np.abs(whole.values).max(axis=0), np.abs(values).max(axis=0))
    for size in (1, 13):
        pieces = thinned(values, columns, size)
        np.testing.assert_array_equal(pieces.values, whole.values)
        np.testing.assert_array_equal(pieces.time, whole.time)


def test_an_empty_piece_changes_nothing() -> None:
    thinning = Thinning(1, 5)
    for time_ns in (np.zeros(0, np.int64), np.array([7 * SECOND]), np.zeros(0, np.int64)):
        thinning.add(time_ns, np.full((len(time_ns), 1), -1.0))
    assert (thinning.time.tolist(), thinning.values.tolist()) == ([7.0], [[-1.0]])


def test_the_history_of_a_recording_keeps_its_peaks_and_the_speed_of_head_and_tail(run: RecordedRun) -> None:
    with Recording(run.path) as recording:
        couplers, vehicles = recording.couplers(), recording.vehicles()
    few, all_samples = history_of(run.path, 20), history_of(run.path, 10**6)
    assert few.force.shape == (20, 21)
    assert len(few.force_edges) == 21
    np.testing.assert_array_equal(np.abs(few.force).max(axis=0), np.abs(couplers.force).max(axis=0))
    np.testing.assert_array_equal(all_samples.force, couplers.force)
    np.testing.assert_array_equal(all_samples.force_edges[:-1], couplers.time_ns / 1e9)
    assert np.diff(all_samples.force_edges)[-1] == pytest.approx(0.02)
    np.testing.assert_array_equal(all_samples.speed_time, vehicles.time_ns / 1e9)
    np.testing.assert_array_equal(all_samples.head_speed, vehicles.speed[:, 0])
    np.testing.assert_array_equal(all_samples.tail_speed, vehicles.speed[:, -1])
    assert few.head_speed[0] == vehicles.speed[0, 0]


def test_a_single_sample_has_a_column_of_a_second(scenario: Scenario, tmp_path: Path) -> None:
    encoder = TelemetryEncoder(scenario.consist)
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder:
        recorder.put(encoder.sample(Session(scenario).sample()), 0)
    assert history_of(tmp_path / "run.mcap", 5).force_edges.tolist() == [0.0, 1.0]


def test_a_recording_that_lacks_couplers_is_refused(scenario: Scenario, tmp_path: Path) -> None:
    encoder = TelemetryEncoder(scenario.consist)
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder:
        recorder.put(list(encoder.sample(Session(scenario).sample()))[1:3], 0)
    with pytest.raises(RecordingError, match=r"run\.mcap: holds no /haul/couplers: nothing was run"):
        history_of(tmp_path / "run.mcap", 5)


def test_of_a_recording_that_lacks_vehicles_there_are_forces_and_no_speeds(scenario: Scenario, tmp_path: Path) -> None:
    encoder = TelemetryEncoder(scenario.consist)
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder:
        recorder.put(list(encoder.sample(Session(scenario).sample()))[:1], 0)
    found = history_of(tmp_path / "run.mcap", 5)
    assert (found.force.shape, len(found.head_speed)) == ((1, 21), 0)
