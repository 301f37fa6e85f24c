"""Masses of several vehicles: to and from their members, and the forces in the rigid drawbars between them."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.data import DrawbarExtremes, Floats, GearExtremes, Ints, Members, VehicleState


@inner
def keep_force(extremes: DrawbarExtremes | GearExtremes, i: int, force: float, time: float) -> None:
    """Let a force be the largest so far in its direction if it is."""
    if force > extremes.compression[i]:
        extremes.compression[i] = force
        extremes.compression_time[i] = time
    elif -force > extremes.tension[i]:
        extremes.tension[i] = -force
        extremes.tension_time[i] = time


@inner
def spread(of_masses: Floats, of_vehicles: Floats, mass_index: Ints) -> None:
    """Give every vehicle the value of its mass."""
    if of_masses.shape[0] == of_vehicles.shape[0]:
        for i in range(of_vehicles.shape[0]):
            of_vehicles[i] = of_masses[i]
    else:
        for i in range(of_vehicles.shape[0]):
            of_vehicles[i] = of_masses[mass_index[i]]


@inner
def collect(of_vehicles: Floats, of_masses: Floats, members: Members) -> None:
    """Add a quantity of its members up for every mass."""
    if of_masses.shape[0] == of_vehicles.shape[0]:
        for m in range(of_masses.shape[0]):
            of_masses[m] = of_vehicles[m]
    else:
        for m in range(of_masses.shape[0]):
            total = 0.0
            for i in range(members.first[m], members.end[m]):
                total += of_vehicles[i]
            of_masses[m] = total


@inner
def collect_both(one: Floats, other: Floats, of_masses: Floats, members: Members) -> None:
    """Add two quantities of its members up for every mass."""
    if of_masses.shape[0] == one.shape[0]:
        for m in range(of_masses.shape[0]):
            of_masses[m] = one[m] + other[m]
    else:
        for m in range(of_masses.shape[0]):
            total = 0.0
            for i in range(members.first[m], members.end[m]):
                total += one[i] + other[i]
            of_masses[m] = total


@inner
def update_drawbars(
    acceleration: Floats,
    gear_force: Floats,
    mass: Floats,
    vehicles: VehicleState,
    members: Members,
    bar_force: Floats,
    extremes: DrawbarExtremes,
    time: float,
) -> None:
    """Forces in rigid drawbars, from the equilibrium of the vehicles before each, and their extremes.

    ``acceleration`` is that of the masses, ``mass`` that of the vehicles.
    """
    for m in range(acceleration.shape[0]):
        force = gear_force[m - 1] if m > 0 else 0.0
        for i in range(members.first[m], members.end[m] - 1):
            driving = vehicles.traction[i] + vehicles.gravity[i]
            holding = vehicles.brake_force[i] + vehicles.resistance_force[i]
            force += mass[i] * acceleration[m] - driving + holding
            bar_force[i] = force
            keep_force(extremes, i, force, time)
