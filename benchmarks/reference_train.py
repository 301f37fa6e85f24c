"""The train of the paper once more, in plain numpy and scipy: the yardstick for the compiled kernel.

Built from the same scenario but from none of the kernel's code, so equal peak forces are an
independent check of the kernel, and the ratio of the costs is what compiling it has gained.
Covered is what an emergency stop of the paper needs while every vehicle still moves: draft gears
with one stiffness each way (velocity method), linear build-up behind the brake wave, friction at
the full shoe force, running resistance, level line. `ReferenceTrain` refuses anything else.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp  # type: ignore[import-untyped]
from scipy.linalg import solveh_banded  # type: ignore[import-untyped]

from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.consist import Consist
from haul_ros.model.draft_gear import DraftGear, SideCurves
from haul_ros.model.scenario import Scenario
from haul_ros.units import GRAVITY

Floats = NDArray[np.float64]

MAX_ITERATIONS = 25


def _wave_brakes(scenario: Scenario) -> BrakeSystem:
    assert isinstance(scenario.brakes, BrakeSystem), "the reference has the empirical brake alone"
    return scenario.brakes


class CouplerForce(NamedTuple):
    """Force [N] and its slopes over stroke [N/m] and stroke rate [N s/m], each (couplers,)."""

    force: Floats
    by_stroke: Floats
    by_rate: Floats


class ReferenceTrain:
    """Forces on every vehicle of a moving train; arrays are (vehicles,) or (couplers,), compression positive.

    Every locomotive starts an emergency application at t = 0.

    Raises
    ------
    ValueError
        The scenario needs more than the paper's law.
    """

    def __init__(self, scenario: Scenario) -> None:
        consist, brakes = scenario.consist, _wave_brakes(scenario)
        _require_paper_law(scenario)
        self.initial_speed = scenario.initial_speed
        self.mass = _column(consist, "mass")
        self._loading = np.array([_stiffness(gear.compression.loading) for gear in consist.couplers if gear])
        self._unloading = np.array([_stiffness(gear.compression.unloading) for gear in consist.couplers if gear])
        self._transition_speed = np.array([gear.transition_speed for gear in consist.couplers if gear])
        self._arrival = _arrival_times(consist, brakes.wave_speeds.emergency)
        self._build_up_time = brakes.build_up.full_time

        weight = self.mass * GRAVITY
        self._constant, self._linear, self._quadratic = (
            weight * _column(consist, "resistance", name) for name in ("constant", "linear", "quadratic")
        )
        self._lowest_speed = _column(consist, "resistance", "minimum_speed")

        shoe_force = _column(consist, "shoe_force")
        friction = {name: _column(consist, "friction", name) for name in ("scale", "k_offset", "k_gain")}
        by_force = (shoe_force + friction["k_offset"]) / (friction["k_gain"] * shoe_force + friction["k_offset"])
        self._full_brake = _column(consist, "shoes") * shoe_force * friction["scale"] * by_force
        self._n_slope, self._n_offset, self._d_slope, self._d_offset = (
            _column(consist, "friction", name) for name in ("n_slope", "n_offset", "d_slope", "d_offset")
        )

    def coupler(self, stroke: Floats, rate: Floats) -> CouplerForce:
        """Velocity method (paper eq. 5): the mean of both curves, and half their gap as far as the rate goes."""
        sign = np.where(stroke >= 0.0, 1.0, -1.0)
        share = sign * rate / self._transition_speed
        inside = np.abs(share) < 1.0
        share = np.clip(share, -1.0, 1.0)
        mean, half_gap = (self._loading + self._unloading) / 2.0, (self._loading - self._unloading) / 2.0
        by_stroke = mean + half_gap * share
        by_rate = np.where(inside, half_gap * np.abs(stroke) / self._transition_speed, 0.0)
        return CouplerForce(by_stroke * stroke, by_stroke, by_rate)

    def brake_share(self, time: float) -> Floats:
        """Brake force over that of a full application, linear behind the wave."""
        return np.clip((time - self._arrival) / self._build_up_time, 0.0, 1.0)

    def retarding(self, brake_share: Floats, speed: Floats) -> tuple[Floats, Floats]:
        """Brake force and running resistance against forward motion [N], and their slope over the speed [N s/m]."""
        below = self._d_slope * speed + self._d_offset
        factor = (self._n_slope * speed + self._n_offset) / below
        full = brake_share * self._full_brake
        at = np.maximum(speed, self._lowest_speed)
        force = full * factor + self._constant + (self._linear + self._quadratic * at) * at
        slope = full * (self._n_slope - self._d_slope * factor) / below
        slope += np.where(speed > self._lowest_speed, self._linear + 2.0 * self._quadratic * at, 0.0)
        return force, slope


def on_vehicles(coupler_force: Floats) -> Floats:
    """Net force of the couplers on every vehicle, (couplers,) to (vehicles,), forward positive [N]."""
    return np.diff(coupler_force, prepend=0.0, append=0.0)


@dataclass(slots=True)
class Motion:
    """Stroke (couplers,), speed and acceleration (vehicles,) at one time."""

    time: float
    stroke: Floats
    speed: Floats
    acceleration: Floats


class NumpyNewmark:
    """Newmark steps (gamma = 1/2, beta = 1/4), each iterated by Newton's method until converged.

    ``tolerance`` [N] is the largest force residual of a converged step.
    """

    def __init__(self, train: ReferenceTrain, time_step: float, tolerance: float) -> None:
        self._train = train
        self._time_step = time_step
        self._tolerance = tolerance
        self._steps = 0
        self.iterations = 0
        """Newton iterations of all steps so far."""
        speed = np.full(train.mass.shape, train.initial_speed)
        stroke = np.zeros(len(train.mass) - 1)
        retarding, _ = train.retarding(train.brake_share(0.0), speed)
        self._motion = Motion(0.0, stroke, speed, -retarding / train.mass)
        self.largest_forces = np.zeros((2, len(stroke)))
        """Largest compression and largest tension of every coupler so far [N], (2, couplers)."""

    def advance(self, n_steps: int) -> None:
        """Take so many steps.

        Raises
        ------
        ArithmeticError
            A step does not converge, or a vehicle has come to rest.
        """
        for _ in range(n_steps):
            force = self._step()
            np.maximum(self.largest_forces, (force, -force), out=self.largest_forces)

    def _step(self) -> Floats:
        """One step; returns the coupler forces at its end."""
        train, h, old = self._train, self._time_step, self._motion
        self._steps += 1
        time = self._steps * h
        brake_share = train.brake_share(time)
        old_rate = np.diff(old.speed)
        speed = old.speed + h * old.acceleration
        for _ in range(MAX_ITERATIONS):
            rate = np.diff(speed)
            stroke = old.stroke + 0.5 * h * (old_rate + rate)
            acceleration = 2.0 / h * (speed - old.speed) - old.acceleration
            coupler = train.coupler(stroke, rate)
            retarding, slope = train.retarding(brake_share, speed)
            residual = on_vehicles(coupler.force) - retarding - train.mass * acceleration
            if np.abs(residual).max() <= self._tolerance:
                break
            tangent = 0.5 * h * coupler.by_stroke + coupler.by_rate
            speed = speed + solveh_banded(_bands(2.0 / h * train.mass + slope, tangent), residual, check_finite=False)
            self.iterations += 1
        else:
            raise ArithmeticError(f"no convergence at {time:g} s")
        if speed.min() <= 0.0:
            raise ArithmeticError(f"a vehicle has come to rest before {time:g} s, which this model does not cover")
        self._motion = Motion(time, stroke, speed, acceleration)
        return coupler.force


def _bands(diagonal: Floats, tangent: Floats) -> Floats:
    """Symmetric tridiagonal matrix of a chain as `solveh_banded` takes it, (2, vehicles)."""
    bands = np.zeros((2, len(diagonal)))
    bands[0, 1:] = -tangent
    bands[1] = diagonal
    bands[1, :-1] += tangent
    bands[1, 1:] += tangent
    return bands


@dataclass(frozen=True, slots=True)
class LsodaRun:
    """States at the instants that the solver chose: lag and speed (instants, vehicles), and what it took."""

    lag: Floats
    speed: Floats
    evaluations: int

    @property
    def steps(self) -> int:
        """Steps that the solver took."""
        return len(self.lag) - 1

    def largest_forces(self, train: ReferenceTrain) -> Floats:
        """Largest compression and largest tension of every coupler at these instants [N], (2, couplers)."""
        force = train.coupler(np.diff(self.lag), np.diff(self.speed)).force
        return np.array([force.max(axis=0), -force.min(axis=0)])


def lsoda(train: ReferenceTrain, duration: float, rtol: float, atol: float) -> LsodaRun:
    """Integrate the same equations with `scipy.integrate.solve_ivp`, method LSODA, banded Jacobian.

    The state is the lag of the first vehicle behind a train that does not brake and its speed, then
    those of the second and so on: a rate depends on values at most 3 places before and 2 after it.
    ``atol`` is in m and m/s.

    Raises
    ------
    ArithmeticError
        The solver gave up.
    """

    def rates(time: float, state: Floats) -> Floats:
        lag, speed = state[0::2], state[1::2]
        force = train.coupler(np.diff(lag), np.diff(speed)).force
        retarding, _ = train.retarding(train.brake_share(time), speed)
        out = np.empty_like(state)
        out[0::2] = speed - train.initial_speed
        out[1::2] = (on_vehicles(force) - retarding) / train.mass
        return out

    start = np.zeros(2 * len(train.mass))
    start[1::2] = train.initial_speed
    solution = solve_ivp(rates, (0.0, duration), start, method="LSODA", rtol=rtol, atol=atol, lband=3, uband=2)
    if not solution.success:
        raise ArithmeticError(solution.message)
    return LsodaRun(solution.y[0::2].T, solution.y[1::2].T, solution.nfev)


def _column(consist: Consist, *path: str) -> Floats:
    """One quantity of every vehicle (vehicles,)."""
    values: list[object] = list(consist.vehicles)
    for name in path:
        values = [getattr(value, name) for value in values]
    return np.array(values, dtype=np.float64)


def _stiffness(curve: tuple[tuple[float, float], ...]) -> float:
    return curve[1][1] / curve[1][0]


def _arrival_times(consist: Consist, wave_speed: float) -> Floats:
    """Time [s] at which the first of the waves from all locomotives reaches each vehicle."""
    offsets = np.array(consist.centre_offsets)
    origins = offsets[[locomotive.vehicle for locomotive in consist.locomotives]]
    return np.asarray(np.abs(offsets[:, None] - origins).min(axis=1) / wave_speed)


def _require_paper_law(scenario: Scenario) -> None:
    consist, build_up, track = scenario.consist, _wave_brakes(scenario).build_up, scenario.track
    covered = {
        "draft gears with one stiffness each way": all(map(_is_linear, consist.couplers)),
        "linear build-up": build_up.knee == 1.0 and build_up.knee_time == build_up.full_time,
        "friction at the full shoe force": not build_up.friction_follows_pressure,
        "friction that does not depend on the initial speed": not _column(consist, "friction", "v0_slope").any(),
        "a level, straight line": not (track.grades or track.curves),
    }
    if missing := [what for what, holds in covered.items() if not holds]:
        raise ValueError(f"{scenario.name}: the reference model covers only {' and '.join(missing)}")


def _is_linear(gear: DraftGear | None) -> bool:
    if gear is None or gear.slack > 0.0 or np.isfinite(gear.maximum_stroke):
        return False
    return gear.compression == gear.tension and _is_straight(gear.compression)


def _is_straight(side: SideCurves) -> bool:
    return all(len(curve) == 2 and curve[0] == (0.0, 0.0) for curve in (side.loading, side.unloading))
