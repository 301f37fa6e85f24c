"""The loop over time steps: the one compiled function that Python calls."""

from __future__ import annotations

from haul_ros.physics.kernel import arrays as a
from haul_ros.physics.kernel._jit import entry, inner
from haul_ros.physics.kernel.arrays import Floats, Train
from haul_ros.physics.kernel.brake_force import fill_cylinders, interpolate_coefficients
from haul_ros.physics.kernel.brake_wave import advance_waves
from haul_ros.physics.kernel.drawbar import update_drawbars
from haul_ros.physics.kernel.newmark import balance_at_start, largest_residual, newmark_step

_SMALLEST = 256
"""A step that does not converge is halved, down to this part of the time step."""


@inner
def _step(t: Train) -> int:
    """One time step, whole or, where it does not converge, in smaller ones; returns Newton iterations."""
    counters = t.counters[0]
    time_step = t.settings[0].time_step
    iterations = newmark_step(t, time_step, False)
    if iterations >= 0:
        return iterations
    counters.fallback_steps += 1
    total = 0
    done = 0
    size = _SMALLEST // 2
    while done < _SMALLEST:
        size = min(size, _SMALLEST - done)
        interpolate_coefficients(t.vehicles, (done + size) / _SMALLEST)
        iterations = newmark_step(t, time_step * (size / _SMALLEST), size == 1)
        if iterations < 0 and size > 1:
            size //= 2
            continue
        if iterations < 0:
            counters.unconverged_steps += 1
            counters.worst_residual = max(counters.worst_residual, largest_residual(t.masses))
        total += max(iterations, 0)
        done += size
    return total


@inner
def _keep_largest(joints: Floats, quantity: int, sign: float, largest: int) -> None:
    for k in range(joints.shape[1]):
        joints[largest, k] = max(joints[largest, k], sign * joints[quantity, k])


@inner
def _keep_time_of_largest(joints: Floats, quantity: int, sign: float, largest: int, kept: int, time: float) -> None:
    for k in range(joints.shape[1]):
        joints[kept, k] = time if sign * joints[quantity, k] > joints[largest, k] else joints[kept, k]


@inner
def _update_extremes(joints: Floats, has_stops: int, time: float) -> None:
    """Largest forces and strokes of both signs, and when a draft gear first closed."""
    _keep_time_of_largest(joints, a.FORCE, 1.0, a.MAX_COMPRESSION, a.MAX_COMPRESSION_TIME, time)
    _keep_time_of_largest(joints, a.FORCE, -1.0, a.MAX_TENSION, a.MAX_TENSION_TIME, time)
    _keep_largest(joints, a.FORCE, 1.0, a.MAX_COMPRESSION)
    _keep_largest(joints, a.FORCE, -1.0, a.MAX_TENSION)
    _keep_largest(joints, a.STROKE, 1.0, a.MAX_COMPRESSION_STROKE)
    _keep_largest(joints, a.STROKE, -1.0, a.MAX_TENSION_STROKE)
    if has_stops:
        for k in range(joints.shape[1]):
            open_so_far = joints[a.BOTTOMED_TIME, k] != joints[a.BOTTOMED_TIME, k]
            if open_so_far and abs(joints[a.STROKE, k]) >= joints[a.FULL_STROKE, k]:
                joints[a.BOTTOMED_TIME, k] = time


@inner
def _in_motion(masses: Floats) -> bool:
    for m in range(masses.shape[1]):
        if masses[a.DIRECTION, m] != 0.0:
            return True
    return False


@entry
def advance(t: Train, n_steps: int) -> None:
    """Advance the train by ``n_steps`` time steps; the outcome does not depend on how steps are grouped.

    Counters tell how the steps went: Newton iterations, steps that had to be divided, parts of
    steps taken with a residual above the tolerance.
    """
    counters = t.counters[0]
    settings = t.settings[0]
    if counters.step == 0:
        balance_at_start(t)
    for _ in range(n_steps):
        start = counters.step * settings.time_step
        time = (counters.step + 1) * settings.time_step
        if counters.waves > 0:
            advance_waves(settings, counters, t.waves, t.masses, t.vehicles, t.places, start, time)
        fill_cylinders(settings, t.vehicles, start, time)
        iterations = _step(t)
        counters.newton_total += iterations
        counters.newton_max = max(counters.newton_max, iterations)
        counters.step += 1
        _update_extremes(t.connections, settings.has_stops, time)
        if settings.has_drawbars:
            update_drawbars(t.masses, t.connections, t.vehicles, t.members, time)
        if _in_motion(t.masses):
            counters.last_motion_step = counters.step
