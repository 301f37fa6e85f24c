"""Tractive effort: what power allows, and what ends it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from haul_ros.physics.energy import energy_balance
from haul_ros.physics.train_model import TrainModel, WaveKind
from tests.physics.physics_cases import linear_gear, model, slack_gear, train_of, vehicle

POWER, EFFORT, MASS = 6.4e6, 600e3, 184e3
LOCOMOTIVE = replace(vehicle(MASS, tractive_effort=EFFORT), max_power=POWER)


def _effort(train: TrainModel) -> float:
    return float(train.train.vehicles.traction[0])


@pytest.mark.interpreted
@pytest.mark.parametrize("speed", [5.0, 30.0, -30.0])
def test_effort_is_what_is_asked_for_or_what_power_gives_at_the_speed(speed: float) -> None:
    train = model(train_of([LOCOMOTIVE], None), speed)
    train.set_traction(0, EFFORT)
    assert _effort(train) == pytest.approx(min(EFFORT, POWER / abs(speed)), rel=1e-12)
    train.advance(100)
    assert _effort(train) == pytest.approx(min(EFFORT, POWER / abs(float(train.speed[0]))), rel=1e-6)


def test_at_full_power_kinetic_energy_grows_by_power_times_time() -> None:
    # Exact: m v^2 / 2 = m v0^2 / 2 + P t. Step by step work is power times time, too.
    train = model(train_of([LOCOMOTIVE], None), 20.0)
    train.set_traction(0, EFFORT)
    train.advance(60_000)
    assert float(train.speed[0]) == pytest.approx(np.sqrt(20.0**2 + 2.0 * POWER * 60.0 / MASS), rel=1e-7)
    balance = energy_balance(train)
    assert balance.traction_work == pytest.approx(POWER * 60.0, rel=1e-6)
    assert balance.fault is None


@pytest.mark.parametrize("mass", [20e3, MASS])
@pytest.mark.parametrize("time_step", [1e-3, 20e-3])
def test_a_locomotive_that_is_hit_from_behind_pulls_with_no_more_than_its_power(mass: float, time_step: float) -> None:
    locomotive = replace(vehicle(mass, tractive_effort=EFFORT), max_power=POWER)
    gear = slack_gear(linear_gear(3e7, 9e6), 0.02)
    train = model(train_of([locomotive, vehicle(), vehicle()], gear), [15.0, 17.0, 17.0], time_step=time_step)
    train.set_traction(0, EFFORT)
    limited = 0
    for _ in range(round(3.0 / time_step)):
        train.advance(1)
        assert _effort(train) * float(train.speed[0]) <= POWER * (1.0 + 1e-14)
        limited += 1 if _effort(train) < EFFORT else 0
    assert limited > 0
    balance = energy_balance(train)
    assert balance.fault is None
    assert abs(balance.relative_imbalance) < 1e-9


def test_the_outcome_does_not_depend_on_how_steps_are_grouped() -> None:
    found = []
    for group in (1, 7, 700):
        train = model(train_of([LOCOMOTIVE, vehicle(), vehicle()], linear_gear(3e7, 9e6)), 14.0)
        train.set_traction(0, EFFORT)
        for _ in range(2100 // group):
            train.advance(group)
        found.append(train.speed)
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])


@pytest.mark.parametrize("connected", [True, False])
@pytest.mark.parametrize("down_before", [True, False])
def test_an_application_in_the_pipe_ends_the_traction_of_a_locomotive_whose_link_is_down(
    connected: bool, down_before: bool
) -> None:
    train = model(train_of([vehicle(), *[vehicle()] * 10, LOCOMOTIVE], linear_gear()), 15.0)
    train.set_traction(11, 400e3)
    if down_before:
        train.set_radio_link(11, connected)
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.4)
    train.advance(500)  # 132 m at 200 m/s take 0.66 s
    assert train.train.vehicles.traction[11] == 400e3
    train.advance(500)
    if not down_before:
        assert train.train.vehicles.traction[11] == 400e3
        train.set_radio_link(11, connected)
    assert train.train.vehicles.traction[11] == (400e3 if connected else 0.0)
