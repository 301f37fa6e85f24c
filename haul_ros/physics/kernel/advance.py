"""The loop over time steps: the one compiled function that Python calls."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import entry, inner
from haul_ros.physics.kernel.blocks import (
    Blocks,
    brakes_of,
    gear_extremes_of,
    gear_parameters_of,
    gears_of,
    mass_trial_of,
    masses_of,
    vehicle_parameters_of,
    vehicles_of,
)
from haul_ros.physics.kernel.brake_force import fill_cylinders, interpolate_coefficients
from haul_ros.physics.kernel.brake_wave import advance_waves
from haul_ros.physics.kernel.commit import drawbars_at_end
from haul_ros.physics.kernel.data import Floats, GearExtremes
from haul_ros.physics.kernel.newmark import balance_at_start, largest_residual, newmark_step
from haul_ros.physics.kernel.traction import take_up_traction

_SMALLEST = 256
"""A step that does not converge is halved, down to this part of the time step."""


@inner
def _step(blocks: Blocks) -> int:
    """One time step, whole or, where it does not converge, in smaller ones; returns Newton iterations."""
    counters = blocks.counters[0]
    time_step = blocks.settings[0].time_step
    total = 0
    done = 0
    size = _SMALLEST
    while done < _SMALLEST:
        size = min(size, _SMALLEST - done)
        if size < _SMALLEST:
            interpolate_coefficients(brakes_of(blocks.vehicles), (done + size) / _SMALLEST)
        iterations = newmark_step(blocks, time_step * (size / _SMALLEST), size == 1)
        if iterations < 0 and size > 1:
            counters.fallback_steps += 1 if size == _SMALLEST else 0
            size //= 2
            continue
        if iterations < 0:
            counters.unconverged_steps += 1
            counters.worst_residual = max(
                counters.worst_residual, largest_residual(mass_trial_of(blocks.masses).residual)
            )
        total += max(iterations, 0)
        done += size
    return total


@inner
def _keep_largest(value: Floats, sign: float, largest: Floats) -> None:
    for k in range(value.shape[0]):
        largest[k] = max(largest[k], sign * value[k])


@inner
def _keep_time_of_largest(value: Floats, sign: float, largest: Floats, kept: Floats, time: float) -> None:
    for k in range(value.shape[0]):
        kept[k] = time if sign * value[k] > largest[k] else kept[k]


@inner
def _update_extremes(
    force: Floats, stroke: Floats, extremes: GearExtremes, full_stroke: Floats, has_stops: int, time: float
) -> None:
    """Largest forces and strokes of both signs, and when a draft gear first closed."""
    _keep_time_of_largest(force, 1.0, extremes.compression, extremes.compression_time, time)
    _keep_time_of_largest(force, -1.0, extremes.tension, extremes.tension_time, time)
    _keep_largest(force, 1.0, extremes.compression)
    _keep_largest(force, -1.0, extremes.tension)
    _keep_largest(stroke, 1.0, extremes.compression_stroke)
    _keep_largest(stroke, -1.0, extremes.tension_stroke)
    if has_stops:
        bottomed_time = extremes.bottomed_time
        for k in range(stroke.shape[0]):
            open_so_far = bottomed_time[k] != bottomed_time[k]
            if open_so_far and abs(stroke[k]) >= full_stroke[k]:
                bottomed_time[k] = time


@inner
def _in_motion(direction: Floats) -> bool:
    for m in range(direction.shape[0]):
        if direction[m] != 0.0:
            return True
    return False


@entry
def advance(blocks: Blocks, n_steps: int) -> None:
    """Advance the train by ``n_steps`` time steps; the outcome does not depend on how steps are grouped.

    Counters tell how the steps went: Newton iterations, steps that had to be divided, parts of
    steps taken with a residual above the tolerance.
    """
    counters = blocks.counters[0]
    settings = blocks.settings[0]
    parameters, brakes = vehicle_parameters_of(blocks.vehicle_parameters), brakes_of(blocks.vehicles)
    gears, masses = gears_of(blocks.gears), masses_of(blocks.masses)
    take_up_traction(blocks)
    # Once more before the first step, with all the traction of that instant: what lies between one locomotive's
    # and the next one's is no state of the train.
    if counters.step == 0 and (n_steps > 0 or counters.balanced == 0):
        balance_at_start(blocks)
        counters.balanced = 1
    for _ in range(n_steps):
        start = counters.step * settings.time_step
        time = (counters.step + 1) * settings.time_step
        if counters.waves > 0:
            advance_waves(
                settings,
                counters,
                blocks.waves,
                masses.velocity,
                blocks.mass_index,
                parameters.centre_offset,
                brakes,
                vehicles_of(blocks.vehicles).traction_demand,
                start,
                time,
            )
        fill_cylinders(settings, parameters, brakes, start, time)
        iterations = _step(blocks)
        counters.newton_total += iterations
        counters.newton_max = max(counters.newton_max, iterations)
        counters.step += 1
        full_stroke = gear_parameters_of(blocks.gear_parameters).full_stroke
        _update_extremes(
            gears.force, gears.stroke, gear_extremes_of(blocks.gears), full_stroke, settings.has_stops, time
        )
        if settings.has_drawbars:
            drawbars_at_end(blocks, time)
        if _in_motion(masses.direction):
            counters.last_motion_step = counters.step
