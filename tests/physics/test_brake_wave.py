"""Brake waves: each vehicle's brake begins at distance over wave speed, to the digit, from the nearest locomotive."""

from __future__ import annotations

from collections.abc import Sequence
from time import thread_time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from haul_ros.physics import assembly
from haul_ros.physics.train_model import TrainModel, WaveKind
from tests.physics.physics_cases import brake_system, linear_gear, model, train_of, vehicle

N = 30
LENGTHS = [32.83, *[12.0] * 13, 32.83, 32.83, *[12.0] * 13, 32.83]
CENTRES = np.cumsum(LENGTHS) - np.array(LENGTHS) / 2.0
WAVE = 220.0
BUILD_UP = 2.0


def _train(release: float = 150.0) -> TrainModel:
    system = brake_system(wave=WAVE, full_time=BUILD_UP, release=release)
    consist = train_of([vehicle(length=length) for length in LENGTHS], linear_gear())
    return model(consist, 20.0, brakes=system)


def _fractions(train: TrainModel) -> NDArray[np.float64]:
    return train.sample().cylinder_pressure / 360e3


def _arrivals(starts: Sequence[tuple[float, int]], speed: float = WAVE) -> NDArray[np.float64]:
    """First arrival [s] at every vehicle: min over locomotives of start + distance/speed (physics.md section 4)."""
    arrivals = np.array([time + np.abs(CENTRES - CENTRES[origin]) / speed for time, origin in starts])
    return np.asarray(arrivals.min(axis=0))


@settings(deadline=None, max_examples=20)
@given(
    starts=st.lists(st.tuples(st.floats(0.0, 1.5), st.integers(0, N - 1)), min_size=1, max_size=4),
    n_steps=st.integers(1, 3200),
)
def test_every_brake_begins_exactly_when_the_first_wave_arrives_and_never_before(
    starts: list[tuple[float, int]], n_steps: int
) -> None:
    train = _train()
    for time, origin in sorted(starts):  # waves are started in the order of their times
        train.start_wave(time, origin, WaveKind.EMERGENCY)
    train.advance(n_steps)
    # Linear build-up: the pressure tells when the wave came, though no step ended there.
    expected = np.clip((train.time - _arrivals(starts)) / BUILD_UP, 0.0, 1.0)
    np.testing.assert_allclose(_fractions(train), expected, rtol=0.0, atol=1e-9)
    assert np.all(_fractions(train)[_arrivals(starts) > train.time] == 0.0)


@pytest.mark.parametrize("origin", [0, 14, N - 1])
def test_a_wave_runs_both_ways_from_its_locomotive(origin: int) -> None:
    train = _train()
    train.start_wave(0.0, origin, WaveKind.EMERGENCY)
    arrivals = _arrivals([(0.0, origin)])
    for i in np.argsort(arrivals)[1:]:
        before = int(arrivals[i] / train.time_step - 1e-9)
        train.advance(before - train.step)
        assert _fractions(train)[i] == 0.0
        train.advance(2)
        assert _fractions(train)[i] > 0.0


def test_each_kind_of_command_travels_at_its_own_speed() -> None:
    train = _train()
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.5)
    train.advance(1000)
    np.testing.assert_array_equal(_fractions(train) > 0.0, _arrivals([(0.0, 0)], 200.0) < train.time)
    train.advance(9000)
    np.testing.assert_allclose(_fractions(train), 0.5, rtol=1e-12)
    train.start_wave(10.0, 0, WaveKind.RELEASE, 0.2)
    train.advance(1000)
    np.testing.assert_array_equal(_fractions(train) < 0.5, _arrivals([(10.0, 0)], 150.0) < train.time)


def test_the_end_of_an_emergency_travels_as_a_release_and_a_release_alone_does_not_end_it() -> None:
    train = _train()
    train.start_wave(0.0, 0, WaveKind.EMERGENCY)
    train.advance(4000)
    train.start_wave(4.0, 0, WaveKind.RELEASE, 0.0)
    train.advance(4000)
    np.testing.assert_array_equal(_fractions(train), 1.0)
    train.start_wave(8.0, 0, WaveKind.EMERGENCY_RELEASE)
    train.advance(1000)
    np.testing.assert_array_equal(_fractions(train) < 1.0, _arrivals([(8.0, 0)], 150.0) < train.time)


def test_thousands_of_waves_at_once_leave_what_the_last_of_them_asks_for() -> None:
    train = _train()
    levels = np.linspace(0.05, 0.8, 3000)
    for n, level in enumerate(levels):
        train.start_wave(n * 1e-5, n % N, WaveKind.SERVICE, float(level))
    train.advance(12_000)
    np.testing.assert_allclose(_fractions(train), 0.8, rtol=1e-12)


@pytest.mark.interpreted
def test_of_two_waves_that_arrive_within_one_step_the_later_prevails() -> None:
    train = _train()
    # Both arrive within the step from 0 to 1 ms.
    train.start_wave(0.2e-3, 0, WaveKind.SERVICE, 0.5)
    train.start_wave(0.7e-3, 0, WaveKind.RELEASE, 0.0)
    train.advance(1)
    assert train.brake_target(0) == 0.0


def test_a_release_that_comes_from_afar_does_not_undo_an_application_that_was_made_after_it() -> None:
    train = _train(release=200.0)
    for locomotive in (0, N - 1):
        train.start_wave(0.0, locomotive, WaveKind.SERVICE, 0.5)
    train.advance(10_000)
    for locomotive in (0, N - 1):
        train.start_wave(10.0, locomotive, WaveKind.RELEASE, 0.0)
    # Half a second later the head applies again; the release of the rear is still on its way to it.
    train.start_wave(10.5, 0, WaveKind.SERVICE, 0.5)
    train.advance(10_000)
    np.testing.assert_array_equal([train.brake_target(i) for i in range(N)], 0.5)


def test_a_service_wave_that_overtakes_the_release_before_it_leaves_the_train_braked() -> None:
    # Service runs at 200 m/s, the release before it at 150 m/s: where it is overtaken it has nothing left to release,
    # for a brake pipe in which the pressure falls again does not release.
    train = _train()
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.5)
    train.advance(10_000)
    train.start_wave(10.0, 0, WaveKind.RELEASE, 0.0)
    train.start_wave(10.1, 0, WaveKind.SERVICE, 0.5)
    train.advance(10_000)
    np.testing.assert_array_equal([train.brake_target(i) for i in range(N)], 0.5)


def test_a_look_for_waves_that_are_spent_takes_little_of_a_sample_period() -> None:
    train = _train()
    for _ in range(4096):
        train.start_wave(0.0, 0, WaveKind.SERVICE, 0.5)
    assert len(train.train.waves) == 4096
    began = thread_time()
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.5)
    assert thread_time() - began < 0.02
    assert len(train.train.waves) == 8192


def test_where_few_waves_are_spent_there_is_more_room_made_and_not_looked_again_for_every_wave(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(assembly, "_ROOM_FOR_WAVES", 8)
    train = _train()
    train.start_wave(0.0, 0, WaveKind.RELEASE, 0.0)
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.5)
    train.advance(2500)
    assert train.waves_under_way == 1  # the release, which the faster application has overtaken
    for _ in range(8):
        train.start_wave(train.time, 0, WaveKind.SERVICE, 0.5)
    assert train.waves_under_way == 8
    assert len(train.train.waves) == 16
