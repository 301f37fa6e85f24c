"""One step of the Newmark method, gamma = 1/2, beta = 1/4 (paper eqs. 6, 7), iterated to convergence.

Unknown are the velocities v' at the end of the step. With these gamma and beta

    m (v' - v)/h = mean force over the step,    x' = x + h/2 (v + v')

and the mean is that of the values at both ends; for draft gears, whose curves have knots, it is taken along the way
between both (`coupler`), so that a contact creates no energy. Newton's method solves the first equation with a
symmetric tridiagonal tangent. Draft gear forces rise with the stroke rate at the end of the step, so its corrections
always lead towards the solution, if not with their full length: where full ones do not converge they are shortened.
Accelerations are those of the forces at the end.

Brake and resistance are dry friction: they oppose motion while a mass slides, and hold it at
v' = 0 as long as the force needed to do so stays below what they can give. A mass that comes to
rest within the step needs the mean friction force f - m (v' - v)/h over the step, f the mean applied force,
so the kinetic energy that is lost equals the work done in that step too. A standing mass has a = 0, unless its
friction no longer holds it at the end of the step: then it will slide in the next.
"""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.blocks import (
    Blocks,
    brakes_of,
    curves_of,
    gear_parameters_of,
    gear_trial_of,
    gears_of,
    grades_of,
    hinges_of,
    line_index_of,
    mass_parameters_of,
    mass_trial_of,
    masses_of,
    members_of,
    vehicle_parameters_of,
    vehicle_trial_of,
    vehicles_of,
)
from haul_ros.physics.kernel.brake_force import brake_forces
from haul_ros.physics.kernel.commit import (
    applied_forces,
    commit_forces,
    commit_gears,
    commit_motion,
    drawbars_at_end,
    holding_force,
)
from haul_ros.physics.kernel.coupler import forces_at_end, step_forces
from haul_ros.physics.kernel.data import (
    BrakeState,
    Floats,
    Ints,
    MassState,
    MassTrial,
    Members,
    VehicleParameters,
    VehicleTrial,
)
from haul_ros.physics.kernel.drawbar import collect, collect_both, spread
from haul_ros.physics.kernel.effort import tractive_efforts
from haul_ros.physics.kernel.resistance import line_forces, running_resistance
from haul_ros.physics.kernel.tridiagonal import solve_tridiagonal

MAX_ITERATIONS = 50
"""After which a step is divided. Where a fast transition or a stiff stop is met, one iteration often brings no more
than one draft gear into its right part of its curves."""

PLAIN_ITERATIONS = 6
"""Full corrections, before each is only taken as far as it leads downhill. Where Newton's method converges by itself
it needs fewer."""

FLAT = 0.1
"""Slope along a correction, over that at its start, from which on it has been taken far enough [-]."""

MAX_TRIES = 30
"""Lengths of a correction that are tried; each halves at worst what is left of it."""

CAPTURE_SPEED = 1e-4
"""Speed [m/s] below which a mass that becomes no faster stands if friction can hold it.

Without it a mass that a coupler eases into balance would creep on for ever, ever more slowly. One that has just broken
loose is as slow, for as many steps as they are short, and goes on: it has more than the friction of sliding against it.
"""

ROUNDING = 4.0 * 2.3e-16
"""Relative error of a change of momentum in a step, from that of the velocities at both ends, with a margin."""

EXACT = 1e-10
"""Residual over the forces of the draft gears next to a mass [-] that leaves the speed at which bodies part what it
should be: the error of its momentum is this part of their impulse."""

MORE_ITERATIONS = 2
"""To come so near, in trains with slack; then the tolerance will do, for rounding may not let it come nearer."""

NOT_CONVERGED = -1
"""Outcome of a step that Newton's method has not solved."""


@inner
def _comes_to_rest(velocity: float, acceleration: float) -> bool:
    """Whether a mass is slow enough to stand, and not on its way to be faster."""
    return abs(velocity) < CAPTURE_SPEED and velocity * acceleration <= 0.0


@inner
def _predict(masses: MassState, new_velocity: Floats, new_direction: Floats, h: float) -> None:
    """First guess of the velocities at the end: the acceleration stays. Nothing turns round at once."""
    velocity, direction, acceleration = masses.velocity, masses.direction, masses.acceleration
    for m in range(new_direction.shape[0]):
        new_direction[m] = 0.0 if _comes_to_rest(velocity[m], acceleration[m]) else direction[m]
    for m in range(new_velocity.shape[0]):
        guess = velocity[m] + h * acceleration[m]
        new_velocity[m] = guess if guess * new_direction[m] > 0.0 else 0.0


@inner
def _friction(
    trial: MassTrial,
    brakes: BrakeState,
    parameters: VehicleParameters,
    vehicle_trial: VehicleTrial,
    mass_index: Ints,
    members: Members,
) -> None:
    """What brakes and resistance can bring up at the trial velocities, by vehicle and by mass."""
    velocity, direction, sliding_speed = trial.velocity, trial.direction, trial.sliding_speed
    for m in range(sliding_speed.shape[0]):
        speed = max(direction[m] * velocity[m], 0.0)
        sliding_speed[m] = speed if direction[m] != 0.0 else -1.0
    spread(sliding_speed, vehicle_trial.sliding_speed, mass_index)
    brake_forces(
        brakes.gain,
        brakes.offset,
        parameters.friction_n_slope,
        parameters.friction_n_offset,
        parameters.friction_d_slope,
        vehicle_trial,
    )
    running_resistance(parameters, vehicle_trial)
    collect_both(vehicle_trial.brake_force, vehicle_trial.resistance_force, trial.friction, members)
    collect(vehicle_trial.friction_slope, trial.friction_slope, members)


@inner
def _equations(mass: Floats, masses: MassState, trial: MassTrial, gear_tangent: Floats, h: float) -> None:
    """Residual and tangent of every mass, as if all were sliding."""
    velocity, friction_force = masses.velocity, masses.friction_force
    new_velocity, applied_force = trial.velocity, trial.applied_force
    direction, friction, friction_slope = trial.direction, trial.friction, trial.friction_slope
    diagonal, off_diagonal, residual = trial.diagonal, trial.off_diagonal, trial.residual
    last = mass.shape[0] - 1
    per_step = 1.0 / h
    for m in range(last + 1):
        force = applied_force[m] - 0.5 * (friction_force[m] + direction[m] * friction[m])
        residual[m] = force - mass[m] * (per_step * (new_velocity[m] - velocity[m]))
    for m in range(last + 1):
        diagonal[m] = per_step * mass[m] + 0.5 * friction_slope[m]
    for k in range(last):
        diagonal[k] += gear_tangent[k]
    for k in range(last):
        diagonal[k + 1] += gear_tangent[k]
    for k in range(last):
        off_diagonal[k] = -gear_tangent[k]


@inner
def _standing_equations(mass: Floats, masses: MassState, trial: MassTrial, h: float) -> int:
    """Equations of the masses that stand; sets those sliding that friction cannot hold, and returns their number."""
    loose = 0
    for m in range(mass.shape[0]):
        if trial.direction[m] != 0.0:
            continue
        applied_force, friction = trial.applied_force[m], trial.friction[m]
        needed = holding_force(mass, masses, applied_force, m, h)
        # What it takes to end a creep counts for nothing: over a short step it would look like a large force.
        slow = _comes_to_rest(masses.velocity[m], masses.acceleration[m])
        creep_ends = slow and abs(applied_force) < friction
        if abs(needed) > friction and not creep_ends:
            loose += 1
            trial.direction[m] = 1.0 if needed < 0.0 else -1.0
        trial.residual[m] = 0.0
        trial.diagonal[m] = 1.0
        trial.off_diagonal[m] = 0.0
        if m > 0:
            trial.off_diagonal[m - 1] = 0.0
    return loose


@inner
def _unbalanced(mass: Floats, velocity: Floats, residual: Floats, tolerance: float, h: float) -> int:
    """Number of masses that are not in balance within the tolerance, or what rounding allows."""
    count = 0
    rounding = ROUNDING / h
    for m in range(residual.shape[0]):
        allowed = max(tolerance, mass[m] * abs(velocity[m]) * rounding)
        count += 0 if abs(residual[m]) <= allowed else 1
    return count


@inner
def _inexact(mass: Floats, trial: MassTrial, gear_force: Floats, h: float) -> int:
    """Number of masses whose residual is more than hardly anything beside the forces next to them, or than rounding."""
    count = 0
    rounding = ROUNDING / h
    last = mass.shape[0] - 1
    for m in range(last + 1):
        force = (abs(gear_force[m - 1]) if m > 0 else 0.0) + (abs(gear_force[m]) if m < last else 0.0)
        allowed = max(EXACT * force, mass[m] * abs(trial.velocity[m]) * rounding)
        count += 1 if abs(trial.residual[m]) > allowed else 0
    return count


@inner
def _stand_before_turning(velocity: Floats, direction: Floats) -> int:
    """Let masses that would turn round stand first; how many they are."""
    count = 0
    for m in range(direction.shape[0]):
        turned = velocity[m] * direction[m] < 0.0
        direction[m] = 0.0 if turned else direction[m]
        count += 1 if turned else 0
    for m in range(velocity.shape[0]):
        velocity[m] = 0.0 if direction[m] == 0.0 else velocity[m]
    return count


@inner
def _correct(trial: MassTrial) -> None:
    """Newton's correction of the velocities."""
    velocity, correction = trial.velocity, trial.residual
    solve_tridiagonal(trial.diagonal, trial.off_diagonal, correction)
    for m in range(velocity.shape[0]):
        velocity[m] += correction[m]
    _stand_before_turning(velocity, trial.direction)


@inner
def _external_forces(blocks: Blocks, h: float) -> None:
    """Traction and grade on every mass; they do not depend on the trial velocities."""
    settings = blocks.settings[0]
    if settings.has_line:
        line_forces(
            settings.start_chainage,
            grades_of(blocks.grades),
            curves_of(blocks.curves),
            masses_of(blocks.masses),
            blocks.mass_index,
            vehicle_parameters_of(blocks.vehicle_parameters),
            line_index_of(blocks.line_index),
            vehicle_trial_of(blocks.vehicles),
            h,
        )
    if blocks.counters[0].has_traction:
        tractive_efforts(
            vehicle_parameters_of(blocks.vehicle_parameters),
            vehicles_of(blocks.vehicles),
            masses_of(blocks.masses),
            blocks.mass_index,
            vehicle_trial_of(blocks.vehicles),
            h,
        )
    if settings.has_line or blocks.counters[0].has_traction:
        traction, gravity = vehicle_trial_of(blocks.vehicles).traction, vehicle_trial_of(blocks.vehicles).gravity
        collect_both(traction, gravity, mass_trial_of(blocks.masses).external_force, members_of(blocks.members))


@inner
def _evaluate(blocks: Blocks, h: float) -> None:
    """All forces at the trial velocities."""
    masses, trial, gear_trial = masses_of(blocks.masses), mass_trial_of(blocks.masses), gear_trial_of(blocks.gears)
    step_forces(
        trial.velocity,
        gear_parameters_of(blocks.gear_parameters),
        hinges_of(blocks.hinges),
        gears_of(blocks.gears),
        gear_trial,
        h,
    )
    _friction(
        trial,
        brakes_of(blocks.vehicles),
        vehicle_parameters_of(blocks.vehicle_parameters),
        vehicle_trial_of(blocks.vehicles),
        blocks.mass_index,
        members_of(blocks.members),
    )
    applied_forces(masses.external_force, trial.external_force, gear_trial.step_force, trial.applied_force)


@inner
def balance_at_start(blocks: Blocks) -> None:
    """Forces and accelerations of the initial state, from its strokes and velocities."""
    masses, trial = masses_of(blocks.masses), mass_trial_of(blocks.masses)
    for m in range(trial.velocity.shape[0]):
        trial.velocity[m] = masses.velocity[m]
        trial.direction[m] = masses.direction[m]
    _external_forces(blocks, 0.0)
    _evaluate(blocks, 0.0)
    forces_at_end(gear_parameters_of(blocks.gear_parameters), hinges_of(blocks.hinges), gear_trial_of(blocks.gears))
    commit_forces(blocks, 0.0)
    commit_motion(mass_parameters_of(blocks.mass_parameters).mass, masses, trial)
    commit_gears(gears_of(blocks.gears), gear_trial_of(blocks.gears))
    if blocks.settings[0].has_drawbars:
        drawbars_at_end(blocks, 0.0)


@inner
def largest_residual(residual: Floats) -> float:
    """Largest force residual of the last iterate [N]; NaN if any is."""
    largest = 0.0
    for m in range(residual.shape[0]):
        size = abs(residual[m])
        if not size <= largest:
            largest = size
    return largest


@inner
def _slope(mass: Floats, masses: MassState, trial: MassTrial, h: float) -> float:
    """Slope along Newton's correction, at the trial velocities, of what a step makes as small as it can be [W].

    Forces of draft gears rise with the stroke rate, on every part of their curves. So the residuals are the slopes of
    a convex function of the velocities, and a correction leads to its lowest point along the way where this is 0.
    """
    velocity, friction_force = masses.velocity, masses.friction_force
    correction, per_step = trial.residual, 1.0 / h
    slope = 0.0
    for m in range(mass.shape[0]):
        force = trial.applied_force[m] - 0.5 * (friction_force[m] + trial.direction[m] * trial.friction[m])
        slope -= correction[m] * (force - mass[m] * (per_step * (trial.velocity[m] - velocity[m])))
    return slope


@inner
def _correct_downhill(blocks: Blocks, h: float) -> None:
    """Newton's correction of the velocities, as far as it leads downhill, by halving and by secants in turn."""
    mass, masses, trial = (
        mass_parameters_of(blocks.mass_parameters).mass,
        masses_of(blocks.masses),
        mass_trial_of(blocks.masses),
    )
    velocity, start, correction = trial.velocity, trial.diagonal, trial.residual
    solve_tridiagonal(trial.diagonal, trial.off_diagonal, correction)
    for m in range(velocity.shape[0]):
        start[m] = velocity[m]
    steepest = _slope(mass, masses, trial, h)
    near, far, slope_near, slope_far = 0.0, 1.0, steepest, 0.0
    part = 1.0
    for attempt in range(MAX_TRIES):
        for m in range(velocity.shape[0]):
            velocity[m] = start[m] + part * correction[m]
        _evaluate(blocks, h)
        slope = _slope(mass, masses, trial, h)
        if abs(slope) <= FLAT * abs(steepest) or (slope <= 0.0 and part == 1.0):
            break
        if slope <= 0.0:
            near, slope_near = part, slope
        else:
            far, slope_far = part, slope
        secant = near - slope_near * (far - near) / (slope_far - slope_near)
        part = secant if attempt % 2 == 1 else 0.5 * (near + far)
    _stand_before_turning(velocity, trial.direction)


@inner
def solve_step(blocks: Blocks, h: float) -> int:
    """Motion at the end of a step of ``h`` [s] under the brake coefficients ``gain`` and ``offset``, to the trial.

    Returns the number of Newton iterations, or NOT_CONVERGED.
    """
    mass, masses, trial = (
        mass_parameters_of(blocks.mass_parameters).mass,
        masses_of(blocks.masses),
        mass_trial_of(blocks.masses),
    )
    gear_trial = gear_trial_of(blocks.gears)
    tolerance = blocks.settings[0].tolerance
    _external_forces(blocks, h)
    _predict(masses, trial.velocity, trial.direction, h)
    iterations, more = 0, MORE_ITERATIONS if blocks.settings[0].has_slack else 0
    while True:
        _evaluate(blocks, h)
        _equations(mass, masses, trial, gear_trial.tangent, h)
        loose = _standing_equations(mass, masses, trial, h)
        balanced = loose + _unbalanced(mass, trial.velocity, trial.residual, tolerance, h) == 0
        if balanced and (more == 0 or _inexact(mass, trial, gear_trial.step_force, h) == 0):
            break
        more -= 1 if balanced else 0
        if iterations == MAX_ITERATIONS:
            return iterations if balanced else NOT_CONVERGED
        if iterations < PLAIN_ITERATIONS:
            _correct(trial)
        else:
            _correct_downhill(blocks, h)
        iterations += 1
    return iterations


@inner
def take_step(blocks: Blocks, h: float) -> None:
    """Let what was solved for the end of the step be the present state."""
    gear_trial = gear_trial_of(blocks.gears)
    forces_at_end(gear_parameters_of(blocks.gear_parameters), hinges_of(blocks.hinges), gear_trial)
    commit_forces(blocks, h)
    commit_motion(
        mass_parameters_of(blocks.mass_parameters).mass,
        masses_of(blocks.masses),
        mass_trial_of(blocks.masses),
    )
    commit_gears(gears_of(blocks.gears), gear_trial)
