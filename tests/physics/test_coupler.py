"""Coupler forces of running trains against the velocity method in plain Python, and what a gear may never do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.model.draft_gear import DraftGear, SideCurves
from haul_ros.model.sample import Sample
from haul_ros.physics.energy import energy_balance
from haul_ros.physics.kernel.coupler import step_forces
from haul_ros.physics.train_model import TrainModel
from tests.physics.physics_cases import (
    MT2,
    assert_converged,
    gear_forces,
    history,
    linear,
    linear_gear,
    model,
    train_of,
    vehicle,
)

STIFF = SideCurves(linear(3e7), linear(9e6))
SOFT = SideCurves(linear(1.2e7), linear(8e6))
PRELOADED = SideCurves(linear(2e7, preload=60e3), linear(5e6, preload=15e3))

GEARS = {
    "stiffnesses": linear_gear(3e7, 9e6),
    "slow transition": linear_gear(3e7, 9e6, transition_speed=0.1),
    "table": DraftGear("MT-2", MT2, MT2, 0.01),
    "asymmetric": DraftGear("asymmetric", STIFF, SOFT, 0.02),
    "slack": replace(linear_gear(3e7, 9e6), slack=0.02),
    "preload": DraftGear("preload", PRELOADED, PRELOADED, 0.02, solid_stiffness=2.5e8),
    "bottoming": DraftGear("MT-2", MT2, MT2, 0.02, maximum_stroke=0.03, bottoming_stiffness=2e8),
    "everything": DraftGear("everything", PRELOADED, MT2, 0.05, 0.01, 0.04, 1e8, 2.5e8),
}


def _shaken_train(gear: DraftGear, n: int = 5) -> TrainModel:
    """Free train whose ends run into and away from the others."""
    speeds = np.array([0.6, 0.0, -0.1, 0.3, 1.2])[:n] + 5.0
    return model(train_of([vehicle()] * n, gear), speeds, time_step=5e-4)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.interpreted) if name == "everything" else name for name in GEARS]
)
def test_every_force_is_that_of_the_velocity_method(name: str) -> None:
    train = _shaken_train(GEARS[name])
    seen: set[tuple[bool, str]] = set()
    for sample in history(train, 4000):
        np.testing.assert_allclose(sample.coupler_force, gear_forces(GEARS[name], sample), rtol=1e-9, atol=1e-3)
        for stroke, rate in zip(sample.stroke, sample.stroke_rate, strict=True):
            w = rate * np.sign(stroke) / GEARS[name].transition_speed
            branch = "blend" if abs(w) < 1.0 else "loading" if w > 0.0 else "unloading"
            seen.add((bool(stroke > 0.0), branch))
    # All six branches of the law have been visited, or the comparison would say nothing about them.
    assert seen == {(buff, branch) for buff in (True, False) for branch in ("loading", "unloading", "blend")}
    assert train.statistics().unconverged_steps == 0


@pytest.mark.interpreted
@pytest.mark.parametrize("name", GEARS)
def test_the_tangent_is_the_derivative_of_the_force_by_the_stroke_rate_at_the_end_of_the_step(name: str) -> None:
    time_step, change = 2e-3, 1e-7
    pair = train_of([vehicle()] * 2, GEARS[name])
    random = np.random.default_rng(1)
    compared = 0
    for _ in range(300):
        train = model(pair, 0.0, time_step=time_step).train
        train.gears.stroke[0] = random.uniform(-0.06, 0.06)
        train.gears.stroke_rate[0] = random.uniform(-0.2, 0.2)
        rate = random.choice([0.02, 0.2]) * random.uniform(-1.0, 1.0)
        forces, tangents = [], []
        for shift in (-change, 0.0, change):
            velocity = np.array([3.0, 3.0 + rate + shift])
            trial = train.gear_trial
            step_forces(velocity, train.gear_parameters, train.hinges, train.gears, trial, time_step)
            forces.append(float(trial.step_force[0]))
            tangents.append(float(trial.tangent[0]))
        if tangents[0] == pytest.approx(tangents[2], rel=1e-4, abs=1e-3):  # no kink of the law between
            assert tangents[1] == pytest.approx((forces[2] - forces[0]) / (2 * change), rel=1e-4, abs=1.0)
            compared += 1
    assert compared > 250


@settings(deadline=None, max_examples=25)
@given(
    speeds=st.lists(st.floats(-1.5, 1.5), min_size=2, max_size=5),
    name=st.sampled_from(sorted(GEARS)),
)
def test_over_any_closed_cycle_gears_never_give_back_more_than_was_put_in(speeds: list[float], name: str) -> None:
    # What gears store is never negative, and what they dissipate never falls: both come from their law, and the
    # balance shows that they are all the work that was done on the gears.
    gear = GEARS[name]
    train = model(train_of([vehicle()] * len(speeds), gear), np.array(speeds), time_step=5e-4)
    scale = max(train.kinetic_energy, 1.0)
    lost = 0.0
    for _ in range(100):
        train.advance(20)
        balance = energy_balance(train)
        assert balance.gear_stored >= 0.0
        assert balance.gear_dissipated >= lost
        # A Newton residual of 1 mN may act on every mass all the way.
        assert abs(balance.imbalance) <= 1e-3 * float(np.sum(np.abs(train.displacement))) + 1e-9 * scale
        lost = balance.gear_dissipated


@pytest.mark.interpreted
@pytest.mark.parametrize("name", GEARS)
@pytest.mark.parametrize("speed", [5e-324, 1e-310, 1.139e-305, 1e-300, 1e-290, 1e-160])
def test_a_motion_as_small_as_numbers_can_be_is_one_like_any_other(name: str, speed: float) -> None:
    train = model(train_of([vehicle()] * 2, GEARS[name]), np.array([0.0, speed]), time_step=5e-4)
    for _ in range(5):
        train.advance(1)
        balance = energy_balance(train)
        assert balance.fault is None
        assert abs(balance.gear_dissipated) + abs(balance.gear_stored) < 1e-150
        assert np.isfinite(train.sample().coupler_force).all()
    assert train.statistics().unconverged_steps == 0


def _half_swing(gear_stiffness: float, mass: float, n_steps: int) -> float:
    """Time step [s] of which Newmark's method needs exactly n for half an oscillation of two equal masses.

    The method turns an oscillation of angular frequency w by 2 atan(w h/2) a step.
    """
    omega = float(np.sqrt(2.0 * gear_stiffness / mass))
    return 2.0 / omega * float(np.tan(np.pi / (2 * n_steps)))


@pytest.mark.interpreted
def test_two_equal_masses_in_an_elastic_collision_swap_their_velocities_exactly() -> None:
    time_step = _half_swing(3e7, 100e3, 100)
    train = model(train_of([vehicle()] * 2, linear_gear(3e7, 3e7)), [1.0, 2.5], time_step=time_step)
    train.advance(100)
    np.testing.assert_allclose(train.speed, [2.5, 1.0], rtol=1e-9)
    assert train.sample().stroke[0] == pytest.approx(0.0, abs=1e-9)
    assert_converged(train)


@pytest.mark.interpreted
def test_two_unequal_masses_part_at_the_velocities_of_an_elastic_collision() -> None:
    m1, m2, v1, v2 = 184e3, 100e3, 0.5, 2.0
    omega = np.sqrt(3e7 * (1.0 / m1 + 1.0 / m2))
    time_step = 2.0 / omega * np.tan(np.pi / 200)
    train = model(train_of([vehicle(m1), vehicle(m2)], linear_gear(3e7, 3e7)), [v1, v2], time_step=float(time_step))
    train.advance(100)
    expected = [(v1 * (m1 - m2) + 2 * m2 * v2) / (m1 + m2), (v2 * (m2 - m1) + 2 * m1 * v1) / (m1 + m2)]
    np.testing.assert_allclose(train.speed, expected, rtol=1e-9)


def _restitution(gear: DraftGear, closing_speed: float = 1.0) -> float:
    train = model(train_of([vehicle()] * 2, gear), [0.0, closing_speed], time_step=2e-5)
    while train.sample().stroke[0] >= 0.0:
        train.advance(1)
    # Velocities change little in the step in which the stroke passes 0: the force is near 0 there.
    assert float(np.sum(train.speed)) == pytest.approx(closing_speed, rel=1e-9)
    return float(train.speed[0] - train.speed[1]) / closing_speed


@pytest.mark.parametrize("ratio", [0.2, 0.3, 0.9])
def test_a_fast_collision_has_the_restitution_root_of_k2_over_k1(ratio: float) -> None:
    # The gear takes 1/2 K1 x^2 and gives back 1/2 K2 x^2; the transition takes no part of the stroke to speak of.
    assert _restitution(linear_gear(3e7, ratio * 3e7, transition_speed=1e-3)) == pytest.approx(ratio**0.5, rel=2e-3)


def test_a_collision_far_below_the_transition_speed_is_elastic() -> None:
    gear = linear_gear(3e7, 9e6, transition_speed=1e4)
    assert _restitution(gear) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.interpreted
def test_in_its_slack_a_coupler_bears_nothing_and_the_masses_keep_their_velocities() -> None:
    gear = replace(linear_gear(3e7, 9e6), slack=0.05)
    train = model(train_of([vehicle()] * 2, gear), [1.0, 1.5])
    train.advance(49)  # 24.5 of 25 mm
    np.testing.assert_array_equal(train.speed, [1.0, 1.5])
    assert train.sample().coupler_force[0] == 0.0
    assert train.sample().stroke[0] == pytest.approx(24.5e-3)
    train.advance(10)
    assert train.sample().coupler_force[0] > 0.0


def _extremes_by_hand(samples: list[Sample]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    force = np.array([s.coupler_force for s in samples])
    stroke = np.array([s.stroke for s in samples])
    return force.max(axis=0), -force.min(axis=0), stroke.max(axis=0), -stroke.min(axis=0)


@pytest.mark.interpreted
def test_running_extremes_are_those_of_every_step_and_of_the_way_between_with_their_times() -> None:
    train = _shaken_train(GEARS["asymmetric"])
    samples = history(train, 2000)
    extremes = train.extremes()
    buff, draft, closed, stretched = _extremes_by_hand(samples)
    # Extremes within a step are the larger by what a step can miss, and lie in a step beside the largest sample.
    pairs = (
        (extremes.compression, buff),
        (extremes.tension, draft),
        (extremes.compression_stroke, closed),
        (extremes.tension_stroke, stretched),
    )
    for extreme, sampled in pairs:
        assert np.all(extreme >= np.maximum(sampled, 0.0))
        np.testing.assert_allclose(extreme, np.maximum(sampled, 0.0), rtol=5e-3)
    force = np.array([s.coupler_force for s in samples])
    times = np.array([s.time_ns for s in samples]) / 1e9
    np.testing.assert_allclose(extremes.compression_time, times[force.argmax(axis=0)], atol=5e-4)
    np.testing.assert_allclose(extremes.tension_time, times[force.argmin(axis=0)], atol=5e-4)


@pytest.mark.interpreted
def test_a_gear_that_closes_fully_is_reported_with_the_time_when_it_first_did() -> None:
    gear = replace(GEARS["bottoming"], slack=0.01)
    train = model(train_of([vehicle()] * 3, gear), [1.0, 1.0, 3.0])
    samples = history(train, 1000)
    closed = [s.time_ns / 1e9 for s in samples if abs(s.stroke[1]) >= 0.03 + 0.005]
    # To within a part of the step that ends with the first of these samples.
    assert closed[0] - 1e-3 < train.extremes().bottomed_time[1] <= closed[0]


@pytest.mark.interpreted
def test_a_gear_that_never_closes_has_no_time_of_it() -> None:
    train = model(train_of([vehicle()] * 3, GEARS["bottoming"]), [1.0, 1.0, 1.1])
    train.advance(2000)
    assert np.isnan(train.extremes().bottomed_time).all()


@pytest.mark.interpreted
def test_strokes_are_positive_in_buff_and_agree_with_chainages() -> None:
    train = _shaken_train(GEARS["stiffnesses"])
    for sample in history(train, 500, every=50):
        apart = -np.diff(sample.chainage)
        np.testing.assert_allclose(sample.stroke, 12.0 - apart, atol=1e-9)
        np.testing.assert_allclose(sample.stroke_rate, np.diff(sample.speed), atol=1e-12)
