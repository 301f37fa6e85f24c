"""Largest forces in rigid drawbars within a time step: at the corners of the forces of the draft gears beside them.

Where a draft gear comes to a knot of its curves, or its stroke rate to the transition speed, its force goes on with
another slope. So does that in a drawbar beside it, which may be largest there: the gear at one end of the mass begins
to bear while that at the other has begun to give way.
"""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.blocks import (
    Blocks,
    drawbar_extremes_of,
    gear_parameters_of,
    gear_trial_of,
    gears_of,
    hinges_of,
    mass_parameters_of,
    mass_trial_of,
    masses_of,
    members_of,
    vehicle_parameters_of,
    vehicle_trial_of,
    vehicles_of,
)
from haul_ros.physics.kernel.coupler import force_at
from haul_ros.physics.kernel.data import Floats, GearState, GearTrial, Hinges
from haul_ros.physics.kernel.drawbar import keep_force


@inner
def _gear_force(blocks: Blocks, k: int, part: float, h: float) -> float:
    """Force of a draft gear after a part of the step; 0 beyond the ends of the train.

    On the way stroke rates change at a constant rate, as Newmark's formulas have it.
    """
    gears, trial = gears_of(blocks.gears), gear_trial_of(blocks.gears)
    if k < 0 or k >= gears.stroke.shape[0]:
        return 0.0
    change = part * (trial.stroke_rate[k] - gears.stroke_rate[k])
    stroke = gears.stroke[k] + part * h * (gears.stroke_rate[k] + 0.5 * change)
    g = (gears.stroke_rate[k] + change) * gear_parameters_of(blocks.gear_parameters).inverse_transition_speed[k]
    return force_at(hinges_of(blocks.hinges), k, stroke, min(1.0, max(-1.0, g)))


@inner
def _outer_force(blocks: Blocks, i: int, direction: float, part: float) -> float:
    """All forces but those of couplers on a vehicle that slides, after a part of the step, forward positive."""
    vehicles, trial = vehicles_of(blocks.vehicles), vehicle_trial_of(blocks.vehicles)
    start = vehicles.traction[i] + vehicles.gravity[i] - vehicles.brake_force[i] - vehicles.resistance_force[i]
    friction = trial.brake_force[i] + trial.resistance_force[i]
    end = trial.traction[i] + trial.gravity[i] - direction * friction
    return start + part * (end - start)


@inner
def _keep_bars(blocks: Blocks, m: int, part: float, start: float, h: float) -> None:
    """Extremes of the drawbars of a mass that slides all the way, from their forces after a part of the step."""
    first, end = members_of(blocks.members).first[m], members_of(blocks.members).end[m]
    direction = mass_trial_of(blocks.masses).direction
    if end - first < 2 or direction[m] == 0.0 or direction[m] != masses_of(blocks.masses).direction[m]:
        return
    force, outer = _gear_force(blocks, m - 1, part, h), 0.0
    for i in range(first, end):
        outer += _outer_force(blocks, i, direction[m], part)
    pushed = _gear_force(blocks, m, part, h) - force + outer
    acceleration = pushed / mass_parameters_of(blocks.mass_parameters).mass[m]
    mass, extremes = vehicle_parameters_of(blocks.vehicle_parameters).mass, drawbar_extremes_of(blocks.vehicles)
    for i in range(first, end - 1):
        force += mass[i] * acceleration - _outer_force(blocks, i, direction[m], part)
        keep_force(extremes, i, force, start + part * h)


@inner
def _keep_bars_at_corner(blocks: Blocks, k: int, before: float, after: float, start: float, h: float) -> None:
    """Extremes of the drawbars on both sides of a gear where what is ``before`` and ``after`` the step passes zero.

    The instant is that of a straight line between both. A stroke bends a little, by h^2/8 times its acceleration.
    """
    if before * after < 0.0:
        part = before / (before - after)
        _keep_bars(blocks, k, part, start, h)
        _keep_bars(blocks, k + 1, part, start, h)


@inner
def _find_corners(gears: GearState, trial: GearTrial, inverse_speed: Floats, hinges: Hinges, passed: Floats) -> int:
    """Make ``passed`` negative for gears that come to a corner within the step; number of these gears."""
    stroke, rate, new_stroke, new_rate = gears.stroke, gears.stroke_rate, trial.stroke, trial.stroke_rate
    for k in range(passed.shape[0]):
        g, new_g = rate[k] * inverse_speed[k], new_rate[k] * inverse_speed[k]
        passed[k] = min((g - 1.0) * (new_g - 1.0), (g + 1.0) * (new_g + 1.0))
    for i in range(hinges.compression_knot.shape[0]):
        buff, draft = hinges.compression_knot[i], hinges.tension_knot[i]
        for k in range(passed.shape[0]):
            in_buff = (stroke[k] - buff[k]) * (new_stroke[k] - buff[k])
            in_draft = (stroke[k] + draft[k]) * (new_stroke[k] + draft[k])
            passed[k] = min(passed[k], min(in_buff, in_draft))
    count = 0
    for k in range(passed.shape[0]):
        count += 1 if passed[k] < 0.0 else 0
    return count


@inner
def keep_drawbars_on_the_way(blocks: Blocks, start: float, h: float) -> None:
    """Extremes of drawbars within the step solved last, from ``start`` on, before it is taken."""
    gears, trial, hinges = gears_of(blocks.gears), gear_trial_of(blocks.gears), hinges_of(blocks.hinges)
    inverse_speed = gear_parameters_of(blocks.gear_parameters).inverse_transition_speed
    passed = trial.low  # of no more use once the step is solved
    if _find_corners(gears, trial, inverse_speed, hinges, passed) == 0:
        return
    for k in range(passed.shape[0]):
        if passed[k] >= 0.0:
            continue
        g, new_g = gears.stroke_rate[k] * inverse_speed[k], trial.stroke_rate[k] * inverse_speed[k]
        _keep_bars_at_corner(blocks, k, g - 1.0, new_g - 1.0, start, h)
        _keep_bars_at_corner(blocks, k, g + 1.0, new_g + 1.0, start, h)
        stroke, new_stroke = gears.stroke[k], trial.stroke[k]
        for i in range(hinges.compression_knot.shape[0]):
            buff, draft = hinges.compression_knot[i, k], -hinges.tension_knot[i, k]
            _keep_bars_at_corner(blocks, k, stroke - buff, new_stroke - buff, start, h)
            _keep_bars_at_corner(blocks, k, stroke - draft, new_stroke - draft, start, h)
