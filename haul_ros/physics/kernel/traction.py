"""Tractive effort that changes between two steps."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.blocks import (
    Blocks,
    mass_parameters_of,
    mass_trial_of,
    masses_of,
    members_of,
    vehicle_parameters_of,
    vehicle_trial_of,
    vehicles_of,
)
from haul_ros.physics.kernel.commit import mobilised_share
from haul_ros.physics.kernel.effort import effort_at


@inner
def take_up_traction(blocks: Blocks) -> None:
    """Let the tractive effort that is demanded act from the present instant on.

    The force jumps at this instant: the next step starts from what holds after the jump.
    """
    vehicles, masses, mass = (
        vehicles_of(blocks.vehicles),
        masses_of(blocks.masses),
        mass_parameters_of(blocks.mass_parameters).mass,
    )
    parameters = vehicle_parameters_of(blocks.vehicle_parameters)
    for i in range(vehicles.traction.shape[0]):
        if vehicles.traction_demand[i] == vehicles.traction_in_force[i]:
            continue
        m = blocks.mass_index[i]
        effort = effort_at(parameters, i, vehicles.traction_demand[i], masses.velocity[m])
        change = effort - vehicles.traction[i]
        vehicles.traction_in_force[i] = vehicles.traction_demand[i]
        vehicles.traction[i] = effort
        blocks.counters[0].has_traction = 1
        masses.applied_force[m] += change
        masses.external_force[m] += change
        if masses.direction[m] != 0.0:
            masses.acceleration[m] += change / mass[m]
        else:
            _hold_standing(blocks, m)


@inner
def _hold_standing(blocks: Blocks, m: int) -> None:
    """A standing mass is held by a share of its friction; what is more than all of it sets it in motion."""
    masses, vehicles, available = (
        masses_of(blocks.masses),
        vehicles_of(blocks.vehicles),
        vehicle_trial_of(blocks.vehicles),
    )
    applied_force, friction = masses.applied_force[m], mass_trial_of(blocks.masses).friction[m]
    mobilised = mobilised_share(0.0, applied_force, friction)
    masses.friction_force[m] = mobilised * friction
    if abs(applied_force) > friction:
        masses.acceleration[m] = (applied_force - mobilised * friction) / mass_parameters_of(
            blocks.mass_parameters
        ).mass[m]
    members = members_of(blocks.members)
    for i in range(members.first[m], members.end[m]):
        vehicles.brake_force[i] = mobilised * available.brake_force[i]
        vehicles.resistance_force[i] = mobilised * available.resistance_force[i]
