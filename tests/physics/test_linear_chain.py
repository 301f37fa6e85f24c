"""Newmark's method on trains without friction against exact solutions and an independent integrator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp  # type: ignore[import-untyped]

from haul_ros.physics.energy import energy_balance
from haul_ros.physics.train_model import TrainModel, WaveKind
from tests.physics.physics_cases import (
    WAGON_RESISTANCE,
    G,
    assert_converged,
    brake_system,
    gear_force,
    linear_gear,
    model,
    train_of,
    vehicle,
    wagon_resistance,
)

Floats = NDArray[np.float64]

MASSES = np.array([184e3, 100e3, 100e3, 84e3, 138e3, 100e3, 100e3, 100e3, 100e3, 184e3])
SPEEDS = np.array([1.0, 0.4, -0.3, 0.2, 0.0, 0.7, -0.5, 0.1, 0.9, -0.2]) + 3.0
STIFFNESS = 3e7
END = 2.0


def _chain(time_step: float) -> TrainModel:
    vehicles = [vehicle(float(m)) for m in MASSES]
    return model(train_of(vehicles, linear_gear(STIFFNESS, STIFFNESS)), SPEEDS, time_step=time_step)


def _modes() -> tuple[Floats, Floats]:
    """Angular frequencies [rad/s] and mass-normalised mode shapes in x = M^-1/2 y."""
    n = len(MASSES)
    stiffness = np.zeros((n, n))
    for k in range(n - 1):
        stiffness[k : k + 2, k : k + 2] += STIFFNESS * np.array([[1.0, -1.0], [-1.0, 1.0]])
    root = np.sqrt(MASSES)
    squares, shapes = np.linalg.eigh(stiffness / np.outer(root, root))
    return np.sqrt(np.maximum(squares, 0.0)), shapes / root[:, None]


def _modal_velocities(time: float, time_step: float = 0.0) -> Floats:
    """Exact velocities [m/s], or with a time step those that Newmark's method has when it is solved exactly:
    it turns each mode by 2 atan(w h/2) a step and leaves its amplitude."""
    omega, shapes = _modes()
    if time_step > 0.0:
        omega = 2.0 / time_step * np.arctan(omega * time_step / 2.0)
    return np.asarray(shapes @ (np.cos(omega * time) * (shapes.T @ (MASSES * SPEEDS))))


def _modal_displacements(time: float) -> Floats:
    omega, shapes = _modes()
    # sin(w t)/w, which is t for the train as a whole
    return np.asarray(shapes @ (time * np.sinc(omega * time / np.pi) * (shapes.T @ (MASSES * SPEEDS))))


@pytest.mark.interpreted
@pytest.mark.parametrize("time_step", [1e-3, 10e-3])
def test_a_linear_chain_follows_the_exact_solution_of_newmark_s_equations(time_step: float) -> None:
    train = _chain(time_step)
    train.advance(round(END / time_step))
    np.testing.assert_allclose(train.speed, _modal_velocities(END, time_step), rtol=0.0, atol=1e-8)
    assert_converged(train)


def test_a_linear_chain_converges_to_its_modal_solution_with_order_2() -> None:
    errors = []
    for time_step in (2e-3, 1e-3, 5e-4):
        train = _chain(time_step)
        train.advance(round(END / time_step))
        velocity = np.max(np.abs(train.speed - _modal_velocities(END)))
        way = np.max(np.abs(train.displacement - _modal_displacements(END)))
        errors.append((velocity, way))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.1)
    assert errors[-1][0] < 2e-3


def test_a_linear_chain_keeps_its_energy() -> None:
    train = _chain(1e-3)
    train.advance(10_000)
    balance = energy_balance(train)
    assert balance.gear_dissipated == pytest.approx(0.0, abs=1e-9 * balance.kinetic_start)
    assert balance.kinetic + balance.gear_stored == pytest.approx(balance.kinetic_start, rel=1e-11)


@pytest.mark.parametrize("slack", [0.0, 0.03])
def test_a_free_train_keeps_its_momentum(slack: float) -> None:
    gear = replace(linear_gear(3e7, 9e6), slack=slack)
    train = model(train_of([vehicle(float(m)) for m in MASSES], gear), SPEEDS)
    momentum = float(MASSES @ SPEEDS)
    for _ in range(10):
        train.advance(500)
        assert float(MASSES @ train.speed) == pytest.approx(momentum, rel=1e-12)
    centre = float(MASSES @ train.displacement)
    assert centre == pytest.approx(momentum * train.time, rel=1e-11)
    assert train.statistics().unconverged_steps == 0


V0, WAVE, BUILD_UP = 20.0, 250.0, 2.0
N_WAGONS = 6


def _brake_share(time: float) -> Floats:
    arrival = np.arange(N_WAGONS) * 12.0 / WAVE
    return np.clip((time - arrival) / BUILD_UP, 0.0, 1.0)


def _reference(end: float) -> Floats:
    """Velocities of a braked train of six wagons, the last one running into the others, by scipy.

    Positions, resistance, brake wave, build-up and couplers are written out anew.
    """
    gear = linear_gear(3e7, 9e6, transition_speed=0.2)
    mass = 100e3
    full_brake = 8 * 25e3 * 0.3

    def rates(time: float, state: Floats) -> Floats:
        x, v = state[:N_WAGONS], state[N_WAGONS:]
        couplers = [gear_force(gear, x[k + 1] - x[k], v[k + 1] - v[k]) for k in range(N_WAGONS - 1)]
        force = np.array([*couplers, 0.0]) - np.array([0.0, *couplers])
        force -= full_brake * _brake_share(time)
        force -= [mass * G * wagon_resistance(speed) for speed in v]
        return np.concatenate((v, force / mass))

    start = np.concatenate((np.zeros(N_WAGONS), np.full(N_WAGONS, V0)))
    start[-1] += 0.3
    solution = solve_ivp(rates, (0.0, end), start, method="RK45", rtol=1e-9, atol=1e-10, max_step=5e-3)
    return np.asarray(solution.y[N_WAGONS:, -1])


def _braked_train(time_step: float) -> TrainModel:
    gear = linear_gear(3e7, 9e6, transition_speed=0.2)
    wagons = [vehicle(resistance=WAGON_RESISTANCE)] * N_WAGONS
    speeds = np.full(N_WAGONS, V0)
    speeds[-1] += 0.3
    brakes = brake_system(wave=WAVE, full_time=BUILD_UP)
    train = model(train_of(wagons, gear), speeds, brakes=brakes, time_step=time_step)
    train.start_wave(0.0, 0, WaveKind.EMERGENCY)
    return train


def test_a_braked_train_with_hysteresis_agrees_with_an_independent_model_under_solve_ivp() -> None:
    end = 1.5
    train = _braked_train(2e-4)
    train.advance(round(end / 2e-4))
    np.testing.assert_allclose(train.speed, _reference(end), rtol=0.0, atol=2e-6)


def test_a_braked_train_with_hysteresis_converges_with_order_2() -> None:
    end, finest = 0.5, 1e-3 / 64
    reference = _braked_train(finest)
    reference.advance(round(end / finest))
    errors = []
    for time_step in (2e-3, 1e-3, 5e-4):
        train = _braked_train(time_step)
        train.advance(round(end / time_step))
        errors.append(float(np.sqrt(np.mean((train.speed - reference.speed) ** 2))))
    # Kinks of the couplers' law fall anywhere within steps, so single halvings scatter about the order.
    assert np.log2(errors[0] / errors[2]) / 2.0 == pytest.approx(2.0, abs=0.3)
