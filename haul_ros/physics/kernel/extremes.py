"""Largest forces and strokes of the draft gears so far."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.blocks import (
    Blocks,
    gear_extremes_of,
    gear_parameters_of,
    gear_trial_of,
    gears_of,
    hinges_of,
)
from haul_ros.physics.kernel.coupler import force_at
from haul_ros.physics.kernel.data import Floats, GearExtremes, GearParameters
from haul_ros.physics.kernel.drawbar import keep_force


@inner
def _keep_largest(value: Floats, sign: float, largest: Floats) -> None:
    for k in range(value.shape[0]):
        largest[k] = max(largest[k], sign * value[k])


@inner
def _keep_time_of_largest(value: Floats, sign: float, largest: Floats, kept: Floats, time: float) -> None:
    for k in range(value.shape[0]):
        kept[k] = time if sign * value[k] > largest[k] else kept[k]


@inner
def _keep_closing(bottomed_time: Floats, k: int, stroke: float, parameters: GearParameters, time: float) -> None:
    open_so_far = bottomed_time[k] != bottomed_time[k]
    if open_so_far and (stroke >= parameters.full_stroke[k] or -stroke >= parameters.full_draft_stroke[k]):
        bottomed_time[k] = time


@inner
def _keep_stroke(extremes: GearExtremes, k: int, stroke: float, parameters: GearParameters, time: float) -> None:
    extremes.compression_stroke[k] = max(extremes.compression_stroke[k], stroke)
    extremes.tension_stroke[k] = max(extremes.tension_stroke[k], -stroke)
    _keep_closing(extremes.bottomed_time, k, stroke, parameters, time)


@inner
def _changing_branch(rate: Floats, new_rate: Floats, inverse_speed: Floats) -> int:
    """Number of gears that turn round or pass the transition speed."""
    count = 0
    for k in range(rate.shape[0]):
        g, new_g = rate[k] * inverse_speed[k], new_rate[k] * inverse_speed[k]
        passed = (g - 1.0) * (new_g - 1.0) < 0.0 or (g + 1.0) * (new_g + 1.0) < 0.0 or g * new_g < 0.0
        count += 1 if passed else 0
    return count


@inner
def keep_extremes_on_the_way(blocks: Blocks, start: float, h: float) -> None:
    """Extremes within the step solved last, from ``start`` on, before it is taken.

    On the way stroke rates change at a constant rate, as Newmark's formulas have it. The stroke is largest where a
    gear turns round; the force there, or where the rate comes below the transition speed.
    """
    gears, trial, extremes = gears_of(blocks.gears), gear_trial_of(blocks.gears), gear_extremes_of(blocks.gears)
    parameters, hinges = gear_parameters_of(blocks.gear_parameters), hinges_of(blocks.hinges)
    if _changing_branch(gears.stroke_rate, trial.stroke_rate, parameters.inverse_transition_speed) == 0:
        return
    for k in range(gears.stroke.shape[0]):
        rate, new_rate = gears.stroke_rate[k], trial.stroke_rate[k]
        inverse_speed = parameters.inverse_transition_speed[k]
        g, new_g = rate * inverse_speed, new_rate * inverse_speed
        if (g - 1.0) * (new_g - 1.0) >= 0.0 and (g + 1.0) * (new_g + 1.0) >= 0.0 and g * new_g >= 0.0:
            continue
        for at in (-1.0, 0.0, 1.0):
            if (g - at) * (new_g - at) < 0.0:
                part = (at - g) / (new_g - g)
                stroke = gears.stroke[k] + 0.5 * part * h * (rate + at / inverse_speed)
                time = start + part * h
                keep_force(extremes, k, force_at(hinges, k, stroke, at), time)
                if at == 0.0:
                    _keep_stroke(extremes, k, stroke, parameters, time)


@inner
def keep_extremes(blocks: Blocks, time: float) -> None:
    """Extremes at the end of a step, and when a draft gear first closed."""
    gears, extremes = gears_of(blocks.gears), gear_extremes_of(blocks.gears)
    force, stroke = gears.force, gears.stroke
    _keep_time_of_largest(force, 1.0, extremes.compression, extremes.compression_time, time)
    _keep_time_of_largest(force, -1.0, extremes.tension, extremes.tension_time, time)
    _keep_largest(force, 1.0, extremes.compression)
    _keep_largest(force, -1.0, extremes.tension)
    _keep_largest(stroke, 1.0, extremes.compression_stroke)
    _keep_largest(stroke, -1.0, extremes.tension_stroke)
    if blocks.settings[0].has_stops:
        parameters = gear_parameters_of(blocks.gear_parameters)
        for k in range(stroke.shape[0]):
            _keep_closing(extremes.bottomed_time, k, stroke[k], parameters, time)
