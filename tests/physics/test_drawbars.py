"""Rigid drawbars: vehicles that are one mass, and the force between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from haul_ros.model.draft_gear import DraftGear
from haul_ros.model.track import Track
from haul_ros.model.vehicle import VehicleType
from haul_ros.physics.energy import energy_balance
from haul_ros.physics.train_model import TrainModel, WaveKind
from tests.physics.physics_cases import (
    WAGON_RESISTANCE,
    G,
    brake_system,
    history,
    linear_gear,
    model,
    slack_gear,
    train_of,
    vehicle,
    wagon_resistance,
)

GEAR = linear_gear(3e7, 2.7e7)
HEAVY = vehicle(184e3, length=32.83, shoes=16, shoe_force=30e3, resistance=WAGON_RESISTANCE, tractive_effort=600e3)
LIGHT = vehicle(60e3, resistance=WAGON_RESISTANCE, shoe_force=20e3)
WAGON = vehicle(resistance=WAGON_RESISTANCE)
VEHICLES: list[VehicleType] = [HEAVY, LIGHT, WAGON, LIGHT, WAGON, WAGON, HEAVY]
RIGID = [False, True, True, False, True, False]  # 1 + 3 + 2 + 1
TRACK = Track(0.0, ((-1e4, 0.003), (40.0, -0.004), (70.0, 0.0)), ((-100.0, 1 / 500.0), (50.0, 0.0)))


def _train(bar: DraftGear | None, time_step: float = 1e-3) -> TrainModel:
    couplers = [bar if rigid else GEAR for rigid in RIGID]
    train = model(train_of(VEHICLES, couplers), 15.0, brakes=brake_system(wave=100.0), track=TRACK, time_step=time_step)
    train.start_wave(0.5, 0, WaveKind.EMERGENCY)
    return train


def test_vehicles_on_drawbars_move_as_one() -> None:
    train = _train(None)
    for sample in history(train, 6000, every=100):
        for j in np.flatnonzero(RIGID):
            assert sample.speed[j] == sample.speed[j + 1]
            assert sample.stroke[j] == sample.stroke_rate[j] == 0.0
        centres = sample.chainage - train.sample().chainage
        assert np.ptp(centres[1:4]) == pytest.approx(0.0, abs=1e-9)
    assert len(np.unique(train.speed)) == 4


@pytest.mark.interpreted
def test_each_member_of_a_lump_brakes_when_the_wave_reaches_itself() -> None:
    train = _train(None)
    offsets = np.cumsum([v.length for v in VEHICLES]) - np.array([v.length for v in VEHICLES]) / 2.0
    arrivals = 0.5 + (offsets - offsets[0]) / 100.0
    train.advance(900)
    assert 0 < np.count_nonzero(arrivals[1:4] < 0.9) < 3
    np.testing.assert_array_equal(train.sample().cylinder_pressure > 0.0, arrivals < 0.9)


def _at(steps: tuple[tuple[float, float], ...], chainage: float) -> float:
    return next((value for start, value in reversed(steps) if chainage >= start), 0.0)


def _net_outer_force(train: TrainModel, i: int) -> float:
    """Brake, resistance, grade and curve on one vehicle in motion [N], forward positive."""
    sample, weight = train.sample(), VEHICLES[i].mass * G
    chainage = float(sample.chainage[i])
    drag = wagon_resistance(float(sample.speed[i])) + 0.6 * _at(TRACK.curves, chainage)
    return -float(sample.brake_force[i]) - weight * (drag + _at(TRACK.grades, chainage))


def test_bar_forces_hold_the_members_behind_them_in_equilibrium() -> None:
    train = _train(None)
    for _ in range(20):
        train.advance(250)
        force = np.append(train.sample().coupler_force, 0.0)
        for bar, rear in ((1, 3), (2, 3), (4, 5)):  # a bar and the last vehicle of its lump
            behind = range(bar + 1, rear + 1)
            outer = sum(_net_outer_force(train, i) for i in behind)
            inertia = sum(VEHICLES[i].mass for i in behind) * float(train.acceleration[rear])
            # m a = F_behind - F_bar + outer forces, compression positive
            assert force[bar] == pytest.approx(force[rear] + outer - inertia, abs=1e-2)


def test_a_rigid_bar_bears_the_limit_of_a_very_stiff_coupler() -> None:
    rigid, stiff = _train(None), _train(linear_gear(3e9, 1e9, transition_speed=1e-3), time_step=2.5e-4)
    largest = 0.0
    for _ in range(25):
        rigid.advance(200)
        stiff.advance(800)
        difference = rigid.sample().coupler_force - stiff.sample().coupler_force
        largest = max(largest, float(np.max(np.abs(rigid.sample().coupler_force[RIGID]))))
        assert np.max(np.abs(difference)) < 2e3
    assert largest > 40e3
    np.testing.assert_allclose(rigid.displacement, stiff.displacement, atol=1e-3)


def test_a_train_of_drawbars_alone_is_one_mass() -> None:
    train = model(train_of([WAGON] * 4, None), 10.0)
    train.start_wave(0.0, 0, WaveKind.EMERGENCY)
    while not train.at_standstill:
        train.advance(1)
    assert np.ptp(train.displacement) == 0.0
    assert abs(energy_balance(train).relative_imbalance) < 1e-9


@pytest.mark.interpreted
def test_bars_of_a_standing_lump_pass_on_what_pulls_at_it() -> None:
    # 20 kN of traction on the first of three: each member holds a third of it, the bars pass on the rest.
    lump = [vehicle(resistance=WAGON_RESISTANCE, tractive_effort=600e3), WAGON, WAGON]
    train = model(train_of(lump, None), 0.0)
    train.set_traction(0, 9e3)
    train.advance(10)
    assert train.at_standstill
    np.testing.assert_allclose(train.sample().coupler_force, [-6e3, -3e3], rtol=1e-9)


def test_the_bars_of_a_train_in_motion_bear_their_force_from_the_start() -> None:
    # The first has 2 N/kN more resistance than the second, which pushes it with half of that.
    dragging = vehicle(resistance=replace(WAGON_RESISTANCE, constant=WAGON_RESISTANCE.constant + 2e-3))
    train = model(train_of([dragging, WAGON], None), 15.0)
    assert train.sample().coupler_force[0] == pytest.approx(100e3 * G * 1e-3, rel=1e-9)


def test_a_bar_extreme_is_the_largest_of_every_step() -> None:
    train = _train(None)
    forces = np.array([sample.coupler_force for sample in history(train, 4000)])
    extremes = train.extremes()
    for extreme, sampled in ((extremes.compression, forces.max(axis=0)), (extremes.tension, -forces.min(axis=0))):
        np.testing.assert_allclose(extreme[RIGID], np.maximum(sampled, 0.0)[RIGID], rtol=1e-12)
        # Draft gears may bear a little more between two steps.
        geared = np.logical_not(RIGID)
        assert np.all(extreme[geared] >= sampled[geared])
        np.testing.assert_allclose(extreme[geared], np.maximum(sampled, 0.0)[geared], rtol=1e-4)
    np.testing.assert_array_equal(extremes.compression_stroke[RIGID], 0.0)


@pytest.mark.interpreted
def test_the_bars_of_a_lump_bear_the_traction_of_all_locomotives_of_an_instant_whatever_their_order() -> None:
    found = []
    for order in ((0, 3), (3, 0)):
        train = model(train_of([vehicle(tractive_effort=500e3)] * 4, None), 0.0)
        for locomotive in order:
            train.set_traction(locomotive, 300e3)
        train.advance(2)
        found.append(train.extremes())
    # Free wagons of equal mass: 600 kN on four of them are 150 kN each, so the bars bear 150, 0 and 150 kN.
    for extremes in found:
        np.testing.assert_allclose(extremes.tension, [150e3, 0.0, 0.0], atol=1e-6)
        np.testing.assert_allclose(extremes.compression, [0.0, 0.0, 150e3], atol=1e-6)


@pytest.mark.parametrize("slack", [29e-3, 30e-3, 31e-3])
def test_a_bar_bears_most_at_the_instant_within_a_step_at_which_the_gear_behind_takes_up_its_slack(
    slack: float,
) -> None:
    # Two wagons on a bar run into a heavier one, and the last stays behind until the slack is used up. Until then
    # s = v/omega sin(omega t) in the gear ahead and the bar pushes the rear wagon with half of its force; then what
    # pulls behind takes more off it than what comes ahead.
    ahead, pair, v, stiffness = 100e3, 40e3, 0.5, 1e7
    omega = np.sqrt(stiffness * (1.0 / ahead + 1.0 / pair))

    def travelled(t: float) -> float:
        return float((v * pair * t + ahead * v / omega * np.sin(omega * t)) / (ahead + pair))

    low, high = 0.0, 0.5 * np.pi / omega
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if travelled(middle) < 0.5 * slack else (low, middle)
    gears = [linear_gear(stiffness, stiffness), None, slack_gear(linear_gear(6e7, 6e7), slack)]
    vehicles = [vehicle(ahead), vehicle(20e3), vehicle(20e3), vehicle(100e3)]
    train = model(train_of(vehicles, gears), [20.0, 20.0 + v, 20.0])
    train.advance(int(low * 1e3) + 4)
    extremes = train.extremes()
    assert extremes.compression[1] == pytest.approx(0.5 * stiffness * v / omega * np.sin(omega * low), rel=2e-4)
    assert extremes.compression_time[1] == pytest.approx(low, abs=1e-5)


def test_bars_beside_gears_with_hysteresis_bear_as_much_as_at_short_steps() -> None:
    # Where the stroke rate comes below the transition speed a gear's force has a corner too, and may turn at once.
    speed = 20.0 + 0.1 * np.random.default_rng(24).standard_normal(10)
    gears = [*[linear_gear(3e7, 9e6), None, None] * 8, linear_gear(3e7, 9e6), None]
    found = []
    for step in (1e-3, 2e-5):
        train = model(train_of([vehicle(20e3)] * 27, gears), speed, time_step=step)
        train.advance(round(0.3 / step))
        extremes = train.extremes()
        bars = np.array([gear is None for gear in gears])
        found.append(np.concatenate((extremes.compression[bars], extremes.tension[bars])))
    floor = 0.1 * np.max(found[1])
    assert np.max(np.abs(found[0] - found[1]) / np.maximum(found[1], floor)) < 2.5e-3
