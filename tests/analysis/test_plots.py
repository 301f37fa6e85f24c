from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from haul_ros.analysis.plots import HISTORY_COLUMNS, BrakeEvent, brake_events, history_figure, profile_figure
from haul_ros.analysis.plotting import save_png
from haul_ros.analysis.train_layout import TrainLayout
from haul_ros.model.scenario import Scenario
from haul_ros.recording.reader import Recording
from haul_ros.recording.series import ScalarSeries
from haul_ros.scenario import load_scenario
from tests.analysis.conftest import history_of

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun

SECOND = 10**9


@pytest.fixture
def profile(scenario: Scenario, run: RecordedRun) -> Figure:
    return profile_figure(TrainLayout.of(scenario.consist), run.session.extremes(), "short train")


@pytest.fixture
def history(scenario: Scenario, run: RecordedRun) -> Figure:
    shown = history_of(run.path, HISTORY_COLUMNS)
    events = [BrakeEvent(0.5, 0, True), BrakeEvent(1.5, 21, True), BrakeEvent(3.0, 21, False)]
    return history_figure(TrainLayout.of(scenario.consist), shown, events, "short train")


def test_every_change_of_an_applied_brake_is_an_event() -> None:
    series = ScalarSeries(SECOND * np.array([0, 2, 5, 7]), np.array([0.0, 0.5, 1.0, 0.0]))
    assert brake_events(4, series) == [BrakeEvent(2.0, 4, True), BrakeEvent(5.0, 4, True), BrakeEvent(7.0, 4, False)]
    assert brake_events(4, ScalarSeries(np.zeros(1, np.int64), np.zeros(1))) == []


def test_the_profile_shows_peaks_in_kilonewton_over_the_coupler_numbers(profile: Figure, run: RecordedRun) -> None:
    force, stroke = profile.axes[:2]
    extremes = run.session.extremes()
    lines = {str(line.get_label()): line for line in force.get_lines()}
    compression, tension = lines["compression (buff)"], lines["tension (draft)"]
    np.testing.assert_array_equal(compression.get_xdata(), np.arange(1, 22))
    np.testing.assert_allclose(np.asarray(compression.get_ydata(), dtype=float), extremes.compression / 1e3)
    np.testing.assert_allclose(np.asarray(tension.get_ydata(), dtype=float), extremes.tension / 1e3)
    np.testing.assert_allclose(
        np.asarray(stroke.get_lines()[0].get_ydata(), dtype=float), extremes.compression_stroke * 1e3
    )
    assert force.get_ylabel().endswith("[kN]")
    assert stroke.get_ylabel().endswith("[mm]")


def test_the_profile_names_the_locomotives_where_they_are_and_neighbours_once(run: RecordedRun) -> None:
    scenario = load_scenario("daqin_1_2_1")
    extremes = run.session.extremes()
    wide = {name: np.resize(getattr(extremes, name), 207) for name in extremes.__slots__}
    force = profile_figure(TrainLayout.of(scenario.consist), type(extremes)(**wide), "train").axes[0]
    (top,) = force.child_axes
    assert [tick.get_text() for tick in top.get_xticklabels()] == ["master", "slave 1, slave 2", "slave 3"]
    assert top.get_xticks().tolist() == [0.5, 104.0, 207.5]


def test_the_profile_shows_strokes_of_draft_gears_only(scenario: Scenario, run: RecordedRun) -> None:
    couplers = list(scenario.consist.couplers)
    couplers[3] = couplers[8] = None
    stroke = profile_figure(
        TrainLayout.of(replace(scenario.consist, couplers=tuple(couplers))), run.session.extremes(), "train"
    ).axes[1]
    for line in stroke.get_lines()[:2]:
        assert np.asarray(line.get_xdata()).tolist() == [j for j in range(1, 22) if j not in (4, 9)]


def test_the_history_has_symmetric_colours_and_the_head_on_top(history: Figure, run: RecordedRun) -> None:
    force = history.axes[0]
    (mesh,) = (artist for artist in force.collections if isinstance(artist, QuadMesh))
    low, high = mesh.get_clim()
    assert low == -high
    with Recording(run.path) as recording:
        assert high == pytest.approx(np.abs(recording.couplers().force).max() / 1e3)
    assert force.get_ylim() == (22.0, 0.0)


def test_the_history_marks_brake_events_at_their_time_and_locomotive(history: Figure) -> None:
    marks = {str(artist.get_label()): artist for artist in history.axes[0].collections}
    assert np.asarray(marks["brake applied by a locomotive"].get_offsets()).tolist() == [[0.5, 0.5], [1.5, 21.5]]
    assert np.asarray(marks["brake released by a locomotive"].get_offsets()).tolist() == [[3.0, 21.5]]


def test_the_history_shows_the_speed_of_head_and_tail_in_kilometres_per_hour(history: Figure) -> None:
    speed = history.axes[1]
    assert [line.get_label() for line in speed.get_lines()] == ["head", "tail"]
    for line in speed.get_lines():
        assert np.asarray(line.get_ydata())[0] == pytest.approx(20.0)
        assert np.asarray(line.get_ydata())[-1] == 0.0


@pytest.mark.parametrize("name", ["profile", "history"])
def test_no_legend_lies_over_data(name: str, request: pytest.FixtureRequest) -> None:
    figure: Figure = request.getfixturevalue(name)
    figure.canvas.draw()
    for axes in figure.axes:
        if legend := axes.get_legend():
            assert not any(legend.get_window_extent().overlaps(other.bbox) for other in figure.axes)


def test_figures_are_saved_as_png(profile: Figure, tmp_path: Path) -> None:
    save_png(profile, tmp_path / "profile.png")
    assert (tmp_path / "profile.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
