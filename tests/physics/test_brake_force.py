"""Brake cylinder and shoes of running trains against the formulas in the units of TB/T 1407-1998."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

from haul_ros.model.vehicle import ShoeFriction
from haul_ros.physics.kernel.brake_force import follow_target
from haul_ros.physics.train_model import TrainModel, WaveKind
from tests.physics.physics_cases import (
    WAGON_RESISTANCE,
    G,
    brake_system,
    history,
    linear_gear,
    model,
    train_of,
    vehicle,
    wagon_resistance,
)

Coefficient = Callable[[float, float, float], float]

# TB/T 1407-1998 as in physics.md section 4: K [kN], v and v0 [km/h].
FORMULAS: dict[str, Coefficient] = {
    "high-friction composite": lambda k, v, v0: 0.41 * (k + 200) / (4 * k + 200) * (v + 150) / (2 * v + 150),
    "low-friction composite": lambda k, v, v0: (
        0.25 * (k + 500) / (6 * k + 500) * (4 * v + 150) / (10 * v + 150) + 0.0006 * (100 - v0)
    ),
    "medium-phosphorus iron": lambda k, v, v0: (
        0.64 * (k + 100) / (5 * k + 100) * (3.6 * v + 100) / (14 * v + 100) + 0.0007 * (110 - v0)
    ),
    "high-phosphorus iron": lambda k, v, v0: (
        0.82 * (k + 100) / (7 * k + 100) * (17 * v + 100) / (60 * v + 100) + 0.0012 * (120 - v0)
    ),
}


def _shoe(numbers: tuple[float, ...], v0_slope_per_kmh: float = 0.0, v0_kmh: float = 0.0) -> ShoeFriction:
    scale, k_offset_kn, k_gain, n_slope, n_offset, d_slope, d_offset = numbers
    return ShoeFriction(
        scale, k_offset_kn * 1e3, k_gain, n_slope * 3.6, n_offset, d_slope * 3.6, d_offset,
        v0_slope_per_kmh * 3.6, v0_kmh / 3.6,
    )  # fmt: skip


SHOES = {
    "high-friction composite": _shoe((0.41, 200, 4, 1, 150, 2, 150)),
    "low-friction composite": _shoe((0.25, 500, 6, 4, 150, 10, 150), 0.0006, 100),
    "medium-phosphorus iron": _shoe((0.64, 100, 5, 3.6, 100, 14, 100), 0.0007, 110),
    "high-phosphorus iron": _shoe((0.82, 100, 7, 17, 100, 60, 100), 0.0012, 120),
}

PRESSURE = 360e3  # of every wagon in emergency [Pa]


def _wagon(shoe: str, initial_speed: float, follows_pressure: bool) -> TrainModel:
    brakes = brake_system(full_time=2.0, follows_pressure=follows_pressure)
    wagon = vehicle(shoe_force=24.4e3, friction=SHOES[shoe])
    return model(train_of([wagon], linear_gear()), initial_speed, brakes=brakes)


@pytest.mark.parametrize("follows_pressure", [False, True])
@pytest.mark.parametrize("shoe", SHOES)
def test_brake_force_is_shoes_times_pressure_times_friction_coefficient(shoe: str, follows_pressure: bool) -> None:
    train = _wagon(shoe, 80 / 3.6, follows_pressure)
    train.start_wave(0.5, 0, WaveKind.EMERGENCY)
    compared = 0
    for sample in history(train, 20_000, every=250)[:-1]:
        fraction = sample.cylinder_pressure[0] / PRESSURE
        k = 24.4 * fraction if follows_pressure else 24.4
        phi = FORMULAS[shoe](k, float(sample.speed[0]) * 3.6, 80.0)
        if sample.speed[0] > 0.0:
            assert sample.brake_force[0] == pytest.approx(8 * 24.4e3 * fraction * phi, rel=1e-9, abs=1e-6)
            compared += 1
    assert compared > 30


@pytest.mark.parametrize("level", [0.2, 0.5, 0.8])
def test_a_service_application_has_the_friction_coefficient_of_its_momentary_pressure(level: float) -> None:
    shoe = "high-friction composite"
    train = _wagon(shoe, 80 / 3.6, follows_pressure=False)
    train.start_wave(0.0, 0, WaveKind.SERVICE, level)
    for sample in history(train, 10_000, every=500)[1:]:
        fraction = sample.cylinder_pressure[0] / PRESSURE
        phi = FORMULAS[shoe](24.4 * fraction, float(sample.speed[0]) * 3.6, 80.0)
        assert sample.brake_force[0] == pytest.approx(8 * 24.4e3 * fraction * phi, rel=1e-9)
    assert fraction == pytest.approx(level)


def test_the_initial_speed_of_the_formula_is_that_at_which_this_application_began() -> None:
    shoe = "high-phosphorus iron"
    train = _wagon(shoe, 100 / 3.6, follows_pressure=False)
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.8)
    train.advance(12_000)
    train.start_wave(12.0, 0, WaveKind.RELEASE, 0.0)
    train.advance(9000)
    assert train.sample().brake_force[0] == 0.0
    second = float(train.speed[0]) * 3.6
    assert 20.0 < second < 95.0
    train.start_wave(21.0, 0, WaveKind.EMERGENCY)
    train.advance(3000)
    sample = train.sample()
    expected = 8 * 24.4e3 * FORMULAS[shoe](24.4, float(sample.speed[0]) * 3.6, second)
    assert sample.brake_force[0] == pytest.approx(expected, rel=1e-9)


def test_a_stronger_application_does_not_change_the_initial_speed_of_the_formula() -> None:
    shoe = "high-phosphorus iron"
    train = _wagon(shoe, 100 / 3.6, follows_pressure=False)
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.3)
    train.advance(4000)
    train.start_wave(4.0, 0, WaveKind.EMERGENCY)
    train.advance(3000)
    sample = train.sample()
    expected = 8 * 24.4e3 * FORMULAS[shoe](24.4, float(sample.speed[0]) * 3.6, 100.0)
    assert sample.brake_force[0] == pytest.approx(expected, rel=1e-9)


RATES = SimpleNamespace(
    knee=0.36, rate_to_knee=0.36 / 1.0, rate_from_knee=0.64 / 9.0, rate_service=0.1, rate_release=0.05
)


@pytest.mark.interpreted
@pytest.mark.parametrize(
    ("fraction", "target", "latched", "elapsed", "expected"),
    [
        (0.0, 1.0, 1, 0.5, 0.18),  # emergency, first stage
        (0.0, 1.0, 1, 1.0, 0.36),
        (0.0, 1.0, 1, 5.5, 0.36 + 0.64 / 2),  # across the knee
        (0.2, 1.0, 1, (0.36 - 0.2) / 0.36 + 1.0, 0.36 + 0.64 / 9),  # from a service application
        (0.5, 1.0, 1, 1.0, 0.5 + 0.64 / 9),
        (0.0, 1.0, 1, 60.0, 1.0),
        (0.0, 0.5, 0, 2.0, 0.2),  # service
        (0.4, 0.5, 0, 60.0, 0.5),
        (0.8, 0.3, 0, 4.0, 0.6),  # release
        (0.8, 0.3, 0, 60.0, 0.3),
        (0.4, 0.4, 0, 7.0, 0.4),
        (0.4, 0.9, 0, 0.0, 0.4),
    ],
)
def test_a_cylinder_follows_its_target(
    fraction: float, target: float, latched: int, elapsed: float, expected: float
) -> None:
    plain = getattr(follow_target, "py_func", follow_target)
    assert plain(RATES, fraction, target, latched, elapsed) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("time_step", [1e-3, 7e-3])
def test_the_two_stage_build_up_of_a_train_has_its_knee_whatever_the_time_step(time_step: float) -> None:
    brakes = brake_system(knee=0.36, knee_time=1.0, full_time=10.0)
    train = model(train_of([vehicle()], linear_gear()), 30.0, brakes=brakes, time_step=time_step)
    start = 0.0123
    train.start_wave(start, 0, WaveKind.EMERGENCY)
    for sample in history(train, round(12.0 / time_step), every=20):
        elapsed = sample.time_ns / 1e9 - start
        expected = np.interp(elapsed, [0.0, 1.0, 10.0], [0.0, 0.36, 1.0])
        assert sample.cylinder_pressure[0] / PRESSURE == pytest.approx(expected, abs=1e-7)


def test_service_and_release_go_at_their_own_rates_to_partial_targets() -> None:
    # Full service is 0.8 of emergency in 8 s; release empties from emergency in 10 s: 0.1 per second both.
    train = model(train_of([vehicle()], linear_gear()), 30.0, brakes=brake_system())
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.48)
    train.advance(3000)
    assert train.sample().cylinder_pressure[0] / PRESSURE == pytest.approx(0.3)
    train.advance(3000)
    assert train.sample().cylinder_pressure[0] / PRESSURE == pytest.approx(0.48)
    train.start_wave(6.0, 0, WaveKind.RELEASE, 0.16)
    train.advance(2000)
    assert train.sample().cylinder_pressure[0] / PRESSURE == pytest.approx(0.28)
    train.advance(5000)
    assert train.sample().cylinder_pressure[0] / PRESSURE == pytest.approx(0.16)


def test_a_known_constant_brake_force_gives_a_uniform_deceleration() -> None:
    # 8 shoes x 25 kN x 0.3 = 60 kN on 100 t: 0.6 m/s^2, after a build-up of 2 s worth 1 s of it.
    n = 6
    brakes = brake_system(wave=1e12, full_time=2.0)
    train = model(train_of([vehicle()] * n, linear_gear(3e7, 9e6)), 20.0, brakes=brakes)
    train.start_wave(0.0, 0, WaveKind.EMERGENCY)
    train.advance(12_000)
    np.testing.assert_allclose(train.speed, 20.0 - 0.6 * (12.0 - 1.0), rtol=1e-8)
    np.testing.assert_allclose(train.acceleration, -0.6, rtol=1e-6)
    np.testing.assert_allclose(train.sample().coupler_force, 0.0, atol=1.0)
    while not train.at_standstill:
        train.advance(1)
    way = 20.0 * 2.0 - 0.6 * 2.0**2 / 6.0 + (20.0 - 0.6) ** 2 / 1.2
    assert train.stop_time == pytest.approx(1.0 + 20.0 / 0.6, abs=1.1e-3)
    np.testing.assert_allclose(train.displacement, way, atol=1e-4)


def test_a_braked_wagon_stops_where_its_resistance_and_brake_integrated_over_speed_say() -> None:
    # s = integral of m v dv / (brake + resistance) from where the brake is full, by the trapezoidal rule.
    shoe = "medium-phosphorus iron"
    wagon = vehicle(shoe_force=24.4e3, friction=SHOES[shoe], resistance=WAGON_RESISTANCE)
    train = model(train_of([wagon], linear_gear()), 25.0, brakes=brake_system(full_time=2.0))
    train.start_wave(0.0, 0, WaveKind.EMERGENCY)
    train.advance(3000)
    v1, s1 = float(train.speed[0]), float(train.displacement[0])
    while not train.at_standstill:
        train.advance(10)
    v = np.concatenate((np.linspace(0.0, 10 / 3.6, 4001), np.linspace(10 / 3.6, v1, 16001)))
    brake = np.array([8 * 24.4e3 * FORMULAS[shoe](24.4, x * 3.6, 90.0) for x in v])
    resistance = np.array([100e3 * G * wagon_resistance(x) for x in v])
    integrand = 100e3 * v / (brake + resistance)
    way = float(np.sum(0.5 * (integrand[1:] + integrand[:-1]) * np.diff(v)))
    assert float(train.displacement[0]) - s1 == pytest.approx(way, rel=1e-6)
