"""The end of a step that has converged: forces, works and motion become those of the present time."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.blocks import (
    Blocks,
    drawbar_extremes_of,
    drawbars_of,
    gear_trial_of,
    gears_of,
    mass_parameters_of,
    mass_trial_of,
    masses_of,
    members_of,
    vehicle_parameters_of,
    vehicle_trial_of,
    vehicles_of,
)
from haul_ros.physics.kernel.data import (
    Floats,
    GearState,
    GearTrial,
    MassState,
    MassTrial,
    Members,
    VehicleState,
    VehicleTrial,
)
from haul_ros.physics.kernel.drawbar import collect_both, spread, update_drawbars
from haul_ros.physics.kernel.effort import commit_efforts

LEAST_FRICTION = 1e-9
"""Friction [N] below which there is none to share among the members of a mass."""


@inner
def holding_force(mass: Floats, masses: MassState, applied_force: float, m: int, h: float) -> float:
    """Mean friction force over the step that leaves a mass at rest at its end [N], forward positive.

    ``applied_force`` is the mean over the step, too.
    """
    return -mass[m] * masses.velocity[m] / h - applied_force


@inner
def _account_arrested(
    mass: Floats,
    masses: MassState,
    trial: MassTrial,
    members: Members,
    vehicles: VehicleState,
    vehicle_trial: VehicleTrial,
    h: float,
) -> None:
    """Friction work of masses that come to rest in this step, over what the trapezoidal rule will add for them."""
    for m in range(mass.shape[0]):
        if trial.direction[m] != 0.0 or masses.velocity[m] == 0.0:
            continue
        needed = holding_force(mass, masses, trial.applied_force[m], m, h)
        mean = -needed / max(trial.friction[m], LEAST_FRICTION)
        mobilised = trial.mobilised[m]
        travelled = trial.displacement_change[m]
        for i in range(members.first[m], members.end[m]):
            brake, resistance = vehicle_trial.brake_force[i], vehicle_trial.resistance_force[i]
            ruled = 0.5 * (vehicles.brake_force[i] + mobilised * brake)
            vehicles.brake_work[i] += (mean * brake - ruled) * travelled
            ruled = 0.5 * (vehicles.resistance_force[i] + mobilised * resistance)
            vehicles.resistance_work[i] += (mean * resistance - ruled) * travelled


@inner
def _commit_friction(available: Floats, mobilised: Floats, travelled: Floats, force: Floats, work: Floats) -> None:
    """Friction force at the end of the step, and its work by the trapezoidal rule."""
    for i in range(force.shape[0]):
        now = mobilised[i] * available[i]
        work[i] += 0.5 * (force[i] + now) * travelled[i]
    for i in range(force.shape[0]):
        force[i] = mobilised[i] * available[i]


@inner
def _commit_external(new_force: Floats, travelled: Floats, force: Floats, work: Floats) -> None:
    """Force of gravity at the end of the step, and its work by the trapezoidal rule."""
    for i in range(force.shape[0]):
        mean = 0.5 * (force[i] + new_force[i])
        work[i] += mean * travelled[i]
    for i in range(force.shape[0]):
        force[i] = new_force[i]


@inner
def mobilised_share(direction: float, applied_force: float, friction: float) -> float:
    """Part of the friction of a mass that acts, -1 .. 1.

    Members of a standing mass share the holding force in proportion to what each can give.
    """
    held = applied_force / max(friction, LEAST_FRICTION)
    held = min(1.0, max(-1.0, held))
    return direction if direction != 0.0 else held


@inner
def applied_forces(start: Floats, end: Floats, gear_force: Floats, applied_force: Floats) -> None:
    """Force of couplers, traction and grade on every mass; of the latter two the mean of two instants."""
    last = applied_force.shape[0] - 1
    applied_force[0] = 0.5 * (start[0] + end[0]) + (gear_force[0] if last > 0 else 0.0)
    for m in range(1, last):
        applied_force[m] = 0.5 * (start[m] + end[m]) + (gear_force[m] - gear_force[m - 1])
    if last > 0:
        applied_force[last] = 0.5 * (start[last] + end[last]) - gear_force[last - 1]


@inner
def _commit_traction(blocks: Blocks, h: float) -> None:
    """Efforts at the end of the step; those that the next one starts from are what is given at the speed found."""
    trial, vehicle_trial = mass_trial_of(blocks.masses), vehicle_trial_of(blocks.vehicles)
    vehicles = vehicles_of(blocks.vehicles)
    commit_efforts(
        vehicle_parameters_of(blocks.vehicle_parameters), vehicles, vehicle_trial, trial.velocity, blocks.mass_index, h
    )
    collect_both(vehicles.traction, vehicle_trial.gravity, trial.external_force, members_of(blocks.members))


@inner
def commit_forces(blocks: Blocks, h: float) -> None:
    """Forces of all vehicles at the end of the step, and their works."""
    masses, trial = masses_of(blocks.masses), mass_trial_of(blocks.masses)
    vehicles, vehicle_trial = vehicles_of(blocks.vehicles), vehicle_trial_of(blocks.vehicles)
    mobilised, travelled = vehicle_trial.mobilised, vehicle_trial.displacement_change
    for m in range(trial.displacement_change.shape[0]):
        trial.displacement_change[m] = 0.5 * h * (masses.velocity[m] + trial.velocity[m])
    spread(trial.displacement_change, travelled, blocks.mass_index)
    if blocks.counters[0].has_traction:
        _commit_traction(blocks, h)
    force = gear_trial_of(blocks.gears).force
    applied_forces(trial.external_force, trial.external_force, force, masses.applied_force)
    for m in range(trial.mobilised.shape[0]):
        trial.mobilised[m] = mobilised_share(trial.direction[m], masses.applied_force[m], trial.friction[m])
    spread(trial.mobilised, mobilised, blocks.mass_index)
    _account_arrested(
        mass_parameters_of(blocks.mass_parameters).mass,
        masses,
        trial,
        members_of(blocks.members),
        vehicles,
        vehicle_trial,
        h,
    )
    _commit_friction(vehicle_trial.brake_force, mobilised, travelled, vehicles.brake_force, vehicles.brake_work)
    _commit_friction(
        vehicle_trial.resistance_force, mobilised, travelled, vehicles.resistance_force, vehicles.resistance_work
    )
    if blocks.settings[0].has_line:
        _commit_external(vehicle_trial.gravity, travelled, vehicles.gravity, vehicles.gravity_work)


@inner
def excess_acceleration(applied_force: float, friction: float, mass: float) -> float:
    """Acceleration of a standing mass by what its friction cannot hold, 0 if it can hold all."""
    excess = max(abs(applied_force) - friction, 0.0) / mass
    return excess if applied_force > 0.0 else -excess


@inner
def commit_motion(mass: Floats, masses: MassState, trial: MassTrial) -> None:
    """Motion of every mass at the end of the step, and the forces that the next one starts from."""
    velocity, acceleration, displacement = masses.velocity, masses.acceleration, masses.displacement
    direction, friction = trial.direction, trial.friction
    applied_force, friction_force = masses.applied_force, masses.friction_force
    for m in range(friction_force.shape[0]):
        friction_force[m] = trial.mobilised[m] * friction[m]
    for m in range(acceleration.shape[0]):
        sliding = (applied_force[m] - friction_force[m]) / mass[m]
        excess = excess_acceleration(applied_force[m], friction[m], mass[m])
        acceleration[m] = sliding if direction[m] != 0.0 else excess
    for m in range(displacement.shape[0]):
        displacement[m] += trial.displacement_change[m]
    for m in range(velocity.shape[0]):
        velocity[m] = trial.velocity[m]
    for m in range(direction.shape[0]):
        masses.direction[m] = direction[m]
    for m in range(applied_force.shape[0]):
        masses.external_force[m] = trial.external_force[m]


@inner
def commit_gears(gears: GearState, trial: GearTrial) -> None:
    """Strokes and forces of every draft gear at the end of the step, what its hysteresis dissipated, and its work."""
    stroke, rate, force, dissipated = gears.stroke, gears.stroke_rate, gears.force, gears.dissipated
    for k in range(dissipated.shape[0]):
        change = trial.stroke[k] - stroke[k]
        dissipated[k] += trial.hysteresis[k] * trial.transition[k] * change
    taken, given = gears.taken, gears.given
    for k in range(taken.shape[0]):
        work = trial.step_force[k] * (trial.stroke[k] - stroke[k])
        taken[k] += max(work, 0.0)
        given[k] += max(-work, 0.0)
    for k in range(stroke.shape[0]):
        stroke[k] = trial.stroke[k]
    for k in range(rate.shape[0]):
        rate[k] = trial.stroke_rate[k]
    for k in range(force.shape[0]):
        force[k] = trial.force[k]


@inner
def drawbars_at_end(blocks: Blocks, time: float) -> None:
    """Forces in the rigid drawbars at the end of a step, and their extremes."""
    update_drawbars(
        masses_of(blocks.masses).acceleration,
        gears_of(blocks.gears).force,
        vehicle_parameters_of(blocks.vehicle_parameters).mass,
        vehicles_of(blocks.vehicles),
        members_of(blocks.members),
        drawbars_of(blocks.vehicles).force,
        drawbar_extremes_of(blocks.vehicles),
        time,
    )
