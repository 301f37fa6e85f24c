"""A train by explicit Runge-Kutta steps of fourth order: the velocity method from its definition, point by point.

It shares neither code nor method with the kernel: tables instead of hinges, forces at instants instead of means over
a step, nothing implicit. It knows brakes of constant friction, no resistance, and trains that do not come to rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numba
import numpy as np
from numpy.typing import NDArray

from haul_ros.model.draft_gear import Curve, DraftGear
from tests.physics.physics_cases import side_force

Floats = NDArray[np.float64]

_FAR = 10.0
"""Stroke [m] up to which the last slope is tabulated."""


@dataclass(frozen=True)
class Brakes:
    """Brake force (n,) [N] of every mass, from (n,) [s] on, rising linearly in a time [s]."""

    force: Floats
    start: Floats
    build_up: float


def _table(gear: DraftGear, curve: Curve) -> list[tuple[float, float]]:
    """Points of a curve with slack, preload and stop: all knots of its definition."""
    knots = {x for x, _ in curve[:-1]}
    if np.isfinite(gear.maximum_stroke):
        knots.add(gear.maximum_stroke)
    if curve[0][1] > 0.0:
        # Where the solid slope meets the curve, by bisection.
        open_gear = replace(gear, maximum_stroke=np.inf)
        low, high = 0.0, curve[-1][0]
        for _ in range(200):
            middle = 0.5 * (low + high)
            solid = side_force(open_gear, curve, middle + gear.slack / 2.0) >= gear.solid_stiffness * middle * (
                1 - 1e-12
            )
            low, high = (middle, high) if solid else (low, middle)
        knots.add(high)
    strokes = sorted({0.0, _FAR, *(x + gear.slack / 2.0 for x in knots)})
    return [(x, side_force(gear, curve, x)) for x in strokes]


@numba.njit(error_model="numpy")
def _interpolated(x: Floats, f: Floats, at: float) -> float:
    i = 1
    while i < x.shape[0] - 1 and x[i] < at:
        i += 1
    value: float = f[i - 1] + (f[i] - f[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1])
    return value


@numba.njit(error_model="numpy")
def _accelerations(time, position, speed, mass, x, f, speeds, brakes, start, build_up, force, result):  # type: ignore[no-untyped-def]
    n = mass.shape[0]
    for k in range(n - 1):
        stroke, rate = position[k + 1] - position[k], speed[k + 1] - speed[k]
        sign = 1.0 if stroke >= 0.0 else -1.0
        side = 0 if stroke >= 0.0 else 2
        loading = _interpolated(x[k, side], f[k, side], abs(stroke))
        unloading = _interpolated(x[k, side + 1], f[k, side + 1], abs(stroke))
        w = sign * rate / speeds[k]
        if w >= 1.0:
            force[k] = sign * loading
        elif w <= -1.0:
            force[k] = sign * unloading
        else:
            force[k] = sign * (0.5 * (loading + unloading) + 0.5 * (loading - unloading) * w)
    for m in range(n):
        ahead = force[m - 1] if m > 0 else 0.0
        behind = force[m] if m < n - 1 else 0.0
        level = min(1.0, max(0.0, (time - start[m]) / build_up))
        result[m] = (behind - ahead - level * brakes[m]) / mass[m]


@numba.njit(error_model="numpy")
def _run(mass, x, f, speeds, brakes, start, build_up, speed, h, n_steps):  # type: ignore[no-untyped-def]
    n = mass.shape[0]
    position = np.zeros(n)
    force, a1, a2, a3, a4 = np.zeros(n - 1), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    buff, draft = np.zeros(n - 1), np.zeros(n - 1)
    for step in range(n_steps):
        t = step * h
        _accelerations(t, position, speed, mass, x, f, speeds, brakes, start, build_up, force, a1)
        for k in range(n - 1):
            buff[k] = max(buff[k], force[k])
            draft[k] = max(draft[k], -force[k])
        v2 = speed + 0.5 * h * a1
        _accelerations(
            t + 0.5 * h, position + 0.5 * h * speed, v2, mass, x, f, speeds, brakes, start, build_up, force, a2
        )
        v3 = speed + 0.5 * h * a2
        _accelerations(t + 0.5 * h, position + 0.5 * h * v2, v3, mass, x, f, speeds, brakes, start, build_up, force, a3)
        v4 = speed + h * a3
        _accelerations(t + h, position + h * v3, v4, mass, x, f, speeds, brakes, start, build_up, force, a4)
        position = position + h / 6.0 * (speed + 2.0 * v2 + 2.0 * v3 + v4)
        speed = speed + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return buff, draft


def explicit_run(
    mass: Floats, gears: Sequence[DraftGear], brakes: Brakes, speed: Floats, step: float, duration: float
) -> tuple[Floats, Floats]:
    """Largest buff and draft force of every coupler, each (n - 1,) [N].

    ``mass`` (n,) [kg], ``speed`` (n,) at the start [m/s], ``step`` and ``duration`` [s].
    """
    sides = [
        [_table(gear, curve) for side in (gear.compression, gear.tension) for curve in (side.loading, side.unloading)]
        for gear in gears
    ]
    longest = max(len(table) for of_gear in sides for table in of_gear)
    x, f = np.zeros((len(gears), 4, longest)), np.zeros((len(gears), 4, longest))
    for k, of_gear in enumerate(sides):
        for side, table in enumerate(of_gear):
            last = table[-1]
            slope = (last[1] - table[-2][1]) / (last[0] - table[-2][0])
            more = [(last[0] + n, last[1] + slope * n) for n in range(1, longest - len(table) + 1)]
            x[k, side], f[k, side] = np.array(table + more).T
    speeds = np.array([gear.transition_speed for gear in gears])
    n_steps = round(duration / step)
    buff, draft = _run(mass, x, f, speeds, brakes.force, brakes.start, brakes.build_up, speed.copy(), step, n_steps)
    return buff, draft
