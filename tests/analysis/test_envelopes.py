from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from haul_ros.analysis.envelopes import bottomed_couplers, force_history, largest_force, recorded_extremes
from haul_ros.errors import RecordingError
from haul_ros.model.scenario import Scenario
from haul_ros.recording.reader import JointSeries, Recording

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun

SECOND = 10**9


def force_series(force: list[list[float]], period_ns: int = SECOND) -> JointSeries:
    effort = np.array(force)
    names = tuple(f"coupler_{j:03d}" for j in range(1, effort.shape[1] + 1))
    return JointSeries(period_ns * np.arange(len(effort)), names, effort * 0, effort * 0, effort)


def test_recorded_extremes_are_those_of_the_session_bit_for_bit(run: RecordedRun) -> None:
    with Recording(run.path) as recording:
        found = recorded_extremes(recording)
    expected = run.session.extremes()
    for field in fields(expected):
        if field.name != "bottomed_time":
            np.testing.assert_array_equal(getattr(found, field.name), getattr(expected, field.name), field.name)
    assert expected.compression.max() > 0.0
    assert expected.tension.max() > 0.0


def test_a_recording_without_extremes_is_refused(empty_recording: Path) -> None:
    with (
        Recording(empty_recording) as recording,
        pytest.raises(RecordingError, match=r"empty\.mcap: holds no /haul/max_compression"),
    ):
        recorded_extremes(recording)


def test_the_envelope_is_the_larger_of_compression_and_tension(run: RecordedRun) -> None:
    extremes = run.session.extremes()
    envelope = largest_force(extremes)
    assert (envelope >= extremes.compression).all()
    assert (envelope >= extremes.tension).all()
    assert ((envelope == extremes.compression) | (envelope == extremes.tension)).all()


def test_a_gear_is_closed_when_stroke_reaches_its_maximum_and_half_the_slack_in_either_direction(
    scenario: Scenario, run: RecordedRun
) -> None:
    gear = scenario.consist.couplers[0]
    assert gear is not None
    limited = replace(gear, maximum_stroke=0.08, slack=0.01)
    consist = replace(scenario.consist, couplers=(limited,) * 20 + (None,))
    strokes = np.zeros(21)
    extremes = replace(run.session.extremes(), compression_stroke=strokes.copy(), tension_stroke=strokes.copy())
    assert bottomed_couplers(consist, extremes) == ()
    extremes.compression_stroke[3] = 0.0851
    extremes.compression_stroke[4] = 0.0849
    extremes.tension_stroke[7] = 0.0851
    assert bottomed_couplers(consist, extremes) == (3, 7)


def test_few_samples_are_shown_as_they_are() -> None:
    edges, force = force_history(force_series([[1.0, -2.0], [3.0, 0.0]]), 10)
    assert edges.tolist() == [0.0, 1.0, 2.0]
    assert force.tolist() == [[1.0, -2.0], [3.0, 0.0]]


def test_many_samples_share_columns_that_keep_the_largest_magnitude_with_its_sign() -> None:
    series = force_series([[1.0, 5.0], [-4.0, 1.0], [2.0, 0.0], [3.0, -1.0]], SECOND // 2)
    edges, force = force_history(series, 2)
    assert edges.tolist() == [0.0, 1.0, 2.0]
    assert force.tolist() == [[-4.0, 5.0], [3.0, -1.0]]


@pytest.mark.parametrize("columns", [1, 7, 100])
def test_no_peak_is_lost_however_few_the_columns(columns: int) -> None:
    values = np.random.default_rng(1).normal(size=(100, 3))
    edges, force = force_history(force_series(values.tolist()), columns)
    assert force.shape == (columns, 3)
    assert len(edges) == columns + 1
    np.testing.assert_array_equal(np.abs(force).max(axis=0), np.abs(values).max(axis=0))


def test_a_single_sample_has_a_column() -> None:
    edges, force = force_history(force_series([[1.0]]), 5)
    assert edges.tolist() == [0.0, 1.0]
    assert force.tolist() == [[1.0]]
