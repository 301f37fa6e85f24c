from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from haul_ros.analysis.recorded import recorded_scenario, summarize_recording
from haul_ros.analysis.summary import peak, summarize_session
from haul_ros.errors import RecordingError
from haul_ros.model.consist import Consist
from haul_ros.model.scenario import Scenario
from haul_ros.recording.reader import Recording
from haul_ros.simulation.session import Session

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun


def test_a_peak_names_the_coupler_its_vehicles_and_its_position(scenario: Scenario) -> None:
    values, times = np.zeros(21), np.zeros(21)
    values[10], times[10] = 5e5, 3.25
    found = peak(scenario.consist, values, times)
    assert found is not None
    assert (found.value, found.time) == (5e5, 3.25)
    assert found.coupler == "coupler_011"
    assert found.between == ("vehicle_011_C80", "vehicle_012_C80")
    assert found.position == 0.5


def test_of_equal_peaks_the_first_is_reported(scenario: Scenario) -> None:
    values = np.zeros(21)
    values[[4, 9]] = 1.0
    found = peak(scenario.consist, values)
    assert found is not None
    assert (found.coupler, found.time) == ("coupler_005", None)


def test_there_is_no_peak_where_no_coupler_bore_any(scenario: Scenario) -> None:
    assert peak(scenario.consist, np.zeros(21)) is None
    single = Consist(scenario.consist.vehicles[:1], (), scenario.consist.locomotives[:1])
    assert peak(single, np.zeros(0)) is None


def test_the_summary_of_a_session_is_what_the_session_says(run: RecordedRun) -> None:
    session = run.session
    summary = summarize_session(session, wall_time=2.0)
    extremes = session.extremes()
    assert summary.stop_time == session.stop_time
    assert summary.distance == session.travelled
    assert summary.real_time_factor == session.time / 2.0
    assert (summary.vehicles, summary.couplers) == (22, 21)
    assert summary.mass == pytest.approx(2 * 184e3 + 20 * 100e3)
    assert summary.length == pytest.approx(2 * 32.83 + 20 * 12.0)
    assert summary.compression is not None
    assert summary.tension is not None
    assert summary.compression.value == extremes.compression.max()
    assert summary.tension.value == extremes.tension.max()
    assert summary.stroke is not None
    assert summary.stroke.value == max(extremes.compression_stroke.max(), extremes.tension_stroke.max())
    assert summary.energy is not None
    assert abs(summary.energy.relative_imbalance) < 1e-6
    assert summary.solver == session.status().solver
    assert summary.caveats == session.scenario.caveats


def test_a_recording_gives_the_same_but_for_the_resolution_of_the_stop_and_what_is_not_recorded(
    run: RecordedRun,
) -> None:
    expected = summarize_session(run.session, wall_time=1.0)
    with Recording(run.path) as recording:
        scenario = recorded_scenario(recording)
        found = summarize_recording(recording, scenario)
    assert scenario.consist == run.session.consist
    assert found.stop_time is not None
    assert expected.stop_time is not None
    assert 0.0 <= found.stop_time - expected.stop_time < found.stop_time_resolution == 0.02
    assert found.distance == pytest.approx(expected.distance)
    for name in ("compression", "tension", "compression_stroke", "tension_stroke", "mass", "caveats", "description"):
        assert getattr(found, name) == getattr(expected, name)
    assert found.duration == pytest.approx(expected.duration)
    assert (found.energy, found.solver, found.real_time_factor, found.radio) == (None, None, None, None)


def test_a_train_that_moves_at_the_end_has_no_stop_time_but_a_speed(scenario: Scenario) -> None:
    session = Session(replace(scenario, max_duration=1.0), play_commands=True)
    while not session.finished:
        session.advance()
    summary = summarize_session(session, wall_time=1.0)
    assert summary.stop_time is None
    assert summary.duration == 1.0
    assert 4.0 < summary.final_speed < scenario.initial_speed
    assert math.isclose(summary.distance, scenario.initial_speed, rel_tol=0.1)


def test_a_recording_without_samples_is_refused(empty_recording: Path, scenario: Scenario) -> None:
    with (
        Recording(empty_recording) as recording,
        pytest.raises(RecordingError, match=r"empty\.mcap: holds no /haul/vehicles: nothing was run"),
    ):
        summarize_recording(recording, scenario)
