"""Running resistance, grades and curves, each at the vehicle's own chainage."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.model.track import Track
from haul_ros.physics.energy import energy_balance
from haul_ros.physics.train_model import TrainModel
from tests.physics.physics_cases import WAGON_RESISTANCE, G, linear_gear, model, train_of, vehicle, wagon_resistance

WAGON = vehicle(resistance=WAGON_RESISTANCE)

RESIDUAL = 2e-6
"""What a Newton residual of 1 mN leaves open of a wagon's resistance of about 1 kN."""


def _single(speed: float, track: Track | None = None) -> TrainModel:
    return model(train_of([WAGON], linear_gear()), speed, track=track)


@pytest.mark.interpreted
@pytest.mark.parametrize("kmh", [0.5, 5.0, 9.99, 10.01, 40.0, 80.0, 100.0])
def test_a_coasting_wagon_decelerates_by_its_specific_resistance(kmh: float) -> None:
    train = _single(kmh / 3.6)
    assert train.acceleration[0] == pytest.approx(-G * wagon_resistance(kmh / 3.6), rel=1e-12)
    train.advance(1)
    assert train.acceleration[0] == pytest.approx(-G * wagon_resistance(float(train.speed[0])), rel=RESIDUAL)


@pytest.mark.interpreted
def test_resistance_opposes_a_train_that_runs_backwards() -> None:
    train = _single(-10.0)
    train.advance(1000)
    assert train.acceleration[0] == pytest.approx(G * wagon_resistance(float(train.speed[0])), rel=RESIDUAL)
    balance = energy_balance(train)
    assert balance.resistance_work > 0.0
    assert abs(balance.relative_imbalance) < 1e-9


def test_below_10_kmh_the_deceleration_is_that_at_10_kmh_down_to_rest() -> None:
    train = _single(9.0 / 3.6)
    deceleration = G * wagon_resistance(10 / 3.6)
    while not train.at_standstill:
        train.advance(1)
    # The last tenth of a millimetre per second is left to the higher starting resistance.
    assert train.stop_time == pytest.approx(9.0 / 3.6 / deceleration, abs=1e-4 / deceleration + 2e-3)
    assert train.displacement[0] == pytest.approx((9.0 / 3.6) ** 2 / 2.0 / deceleration, rel=1e-5)


# Vehicles' centres stand at 494, 482, 470, ... m.
START = 500.0
GRADES = ((440.0, 0.004), (470.0, -0.010), (476.0, 0.0), (490.0, 0.006))
CURVES = ((455.0, 1 / 400.0), (480.0, 0.0), (485.0, 1 / 800.0))


def _value(steps: tuple[tuple[float, float], ...], chainage: float) -> float:
    return next((value for start, value in reversed(steps) if chainage >= start), 0.0)


@pytest.mark.interpreted
def test_each_vehicle_takes_the_grade_and_the_curve_at_its_own_chainage() -> None:
    n = 8
    train = model(train_of([WAGON] * n, linear_gear()), 12.0, track=Track(START, GRADES, CURVES))
    sample = train.sample()
    np.testing.assert_allclose(sample.chainage, START - 6.0 - 12.0 * np.arange(n))
    # Couplers are free at the start, so the first acceleration is that of the outer forces alone.
    expected = [
        -G * (_value(GRADES, c) + 0.6 * _value(CURVES, c) + wagon_resistance(12.0)) for c in map(float, sample.chainage)
    ]
    assert len({round(value, 9) for value in expected}) > 4
    np.testing.assert_allclose(train.acceleration, expected, rtol=1e-12)


@settings(deadline=None, max_examples=15)
@given(
    breaks=st.lists(st.floats(300.0, 700.0), min_size=1, max_size=5, unique=True),
    speed=st.sampled_from([-15.0, 15.0]),
    data=st.data(),
)
def test_gravity_work_is_weight_times_the_height_that_each_vehicle_went_down(
    breaks: list[float], speed: float, data: st.DataObject
) -> None:
    values = data.draw(st.lists(st.floats(-0.02, 0.02), min_size=len(breaks), max_size=len(breaks)))
    grades = tuple(zip(sorted(breaks), values, strict=True))
    train = model(train_of([WAGON] * 5, linear_gear(3e7, 9e6)), speed, track=Track(START, grades))
    before = train.sample().chainage
    train.advance(8000)

    def height(chainage: float) -> float:
        ends = [start for start, _ in grades[1:]] + [np.inf]
        return sum(g * max(0.0, min(chainage, end) - s) for (s, g), end in zip(grades, ends, strict=True))

    after = train.sample().chainage
    fallen = sum(height(float(a)) - height(float(b)) for a, b in zip(before, after, strict=True))
    # A change of grade within a step acts from the end of it or from its middle on: half a step's way of error.
    slack = 100e3 * G * 5 * len(breaks) * 0.04 * 0.02
    assert energy_balance(train).gravity_work == pytest.approx(100e3 * G * fallen, abs=slack)
    # At most a residual of 1 mN on 5 wagons over their way of 120 m.
    assert abs(energy_balance(train).imbalance) < 1e-3 * 5 * 120.0


def test_a_curve_resistance_is_600_over_radius_newtons_per_kilonewton() -> None:
    train = model(train_of([vehicle()], linear_gear()), 10.0, track=Track(0.0, (), ((-1e3, 1 / 300.0),)))
    assert train.acceleration[0] == pytest.approx(-G * 600 / 300 / 1000, rel=1e-12)
