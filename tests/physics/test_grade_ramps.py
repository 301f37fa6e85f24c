"""Changes of grade as linear ramps: the grade under each vehicle, and the work of gravity over the height."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.model.track import Steps, Track
from haul_ros.physics.energy import energy_balance
from tests.physics.physics_cases import G, linear_gear, model, train_of, vehicle

START = 500.0
"""The centres of wagons of 12 m stand at 494, 482, 470 ... m."""


def height(chainage: float, grades: Steps, ramp: float) -> float:
    """Height of a line [m]: each change of grade adds a parabola over its ramp, and a straight line behind it."""
    total, before = 0.0, 0.0
    for at, grade in grades:
        past = chainage - at
        if past >= ramp / 2.0:
            rise = past
        elif past > -ramp / 2.0:
            rise = (past + ramp / 2.0) ** 2 / (2.0 * ramp)
        else:
            rise = 0.0
        total += (grade - before) * rise
        before = grade
    return total


@pytest.mark.interpreted
def test_each_vehicle_takes_the_grade_of_the_ramp_at_its_own_chainage() -> None:
    # Ramps from 460 to 480 m, level to +8, and from 480 to 500 m, +8 to -4 per mille: they touch.
    track = Track(START, ((470.0, 0.008), (490.0, -0.004)), grade_ramp=20.0)
    train = model(train_of([vehicle()] * 4, linear_gear()), 12.0, track=track)
    by_chainage = {
        494.0: 0.008 - 0.012 * 14.0 / 20.0,
        482.0: 0.008 - 0.012 * 2.0 / 20.0,
        470.0: 0.008 * 10.0 / 20.0,
        458.0: 0.0,
    }
    assert train.sample().chainage.tolist() == list(by_chainage)
    np.testing.assert_allclose(train.acceleration, [-G * grade for grade in by_chainage.values()], rtol=1e-12)


@pytest.mark.interpreted
def test_before_and_behind_a_ramp_the_grades_are_those_of_steps() -> None:
    grades = ((400.0, 0.004), (470.0, -0.006))
    steps, ramps = (
        model(train_of([vehicle()] * 4, linear_gear()), 12.0, track=Track(START, grades, grade_ramp=length))
        for length in (0.0, 23.0)
    )
    # Centres at 494, 482 | 470 | 458 m, the ramp from 458.5 to 481.5 m: only the third lies on it.
    same = steps.acceleration == ramps.acceleration
    assert same.tolist() == [True, True, False, True]
    assert ramps.acceleration[2] == pytest.approx(-G * (0.004 - 0.006) / 2.0, rel=1e-12)


@settings(deadline=None, max_examples=15)
@given(
    gaps=st.lists(st.floats(0.0, 80.0), min_size=1, max_size=5),
    ramp=st.floats(20.0, 100.0),
    speed=st.sampled_from([-15.0, 15.0]),
    data=st.data(),
)
def test_gravity_work_is_weight_times_the_height_of_the_vertical_curves(
    gaps: list[float], ramp: float, speed: float, data: st.DataObject
) -> None:
    values = data.draw(st.lists(st.floats(-0.02, 0.02), min_size=len(gaps), max_size=len(gaps)))
    chainages = 400.0 + np.cumsum(np.array(gaps) + ramp * (1.0 + 1e-9))
    grades = tuple(zip(map(float, chainages), values, strict=True))
    train = model(train_of([vehicle()] * 5, linear_gear(3e7, 9e6)), speed, track=Track(START, grades, grade_ramp=ramp))
    high = sum(height(float(chainage), grades, ramp) for chainage in train.sample().chainage)
    train.advance(8000)
    low = sum(height(float(chainage), grades, ramp) for chainage in train.sample().chainage)
    # The trapezoidal rule is exact but in the step of 17 mm that holds an end of a ramp: there the grade bends by up to
    # 0.04 over the ramp's length, which is worth at most bend way^2 / 8 of height.
    bend = 0.04 / ramp * 0.017**2 / 8.0
    allowed = 100e3 * G * 5 * 2 * len(gaps) * bend + 1e-3
    assert energy_balance(train).gravity_work == pytest.approx(100e3 * G * (high - low), abs=allowed)
    assert abs(energy_balance(train).imbalance) < 1e-3 * 5 * 120.0
    assert energy_balance(train).fault is None


def test_a_free_wagon_loses_the_speed_that_the_height_takes() -> None:
    track = Track(0.0, ((100.0, 0.02), (400.0, 0.0)), grade_ramp=150.0)
    train = model(train_of([vehicle()], None), 20.0, track=track)
    train.advance(30_000)
    # Ramps and grade of 300 m at 20 per mille, wherever they begin and end: 6 m.
    assert train.sample().chainage[0] > 475.0
    assert train.speed[0] == pytest.approx((20.0**2 - 2.0 * G * 6.0) ** 0.5, rel=1e-9)
