"""Masses of several vehicles: to and from their members, and the forces in the rigid drawbars between them."""

from __future__ import annotations

from haul_ros.physics.kernel import arrays as a
from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.arrays import Floats, Ints


@inner
def spread(masses: Floats, source: int, vehicles: Floats, target: int, places: Ints) -> None:
    """Give every vehicle the value of its mass."""
    if masses.shape[1] == vehicles.shape[1]:
        for i in range(vehicles.shape[1]):
            vehicles[target, i] = masses[source, i]
    else:
        for i in range(vehicles.shape[1]):
            vehicles[target, i] = masses[source, places[a.MASS_INDEX, i]]


@inner
def collect(vehicles: Floats, one: int, other: int, masses: Floats, target: int, members: Ints) -> None:
    """Add one or two quantities (``other`` = -1: one) of its members up for every mass."""
    if masses.shape[1] == vehicles.shape[1] and other >= 0:
        for m in range(masses.shape[1]):
            masses[target, m] = vehicles[one, m] + vehicles[other, m]
    elif masses.shape[1] == vehicles.shape[1]:
        for m in range(masses.shape[1]):
            masses[target, m] = vehicles[one, m]
    else:
        for m in range(masses.shape[1]):
            total = 0.0
            for i in range(members[a.FIRST, m], members[a.END, m]):
                total += vehicles[one, i] + (vehicles[other, i] if other >= 0 else 0.0)
            masses[target, m] = total


@inner
def update_drawbars(masses: Floats, joints: Floats, vehicles: Floats, members: Ints, time: float) -> None:
    """Forces in rigid drawbars, from the equilibrium of the vehicles before each, and their extremes."""
    for m in range(masses.shape[1]):
        force = joints[a.FORCE, m - 1] if m > 0 else 0.0
        for i in range(members[a.FIRST, m], members[a.END, m] - 1):
            driving = vehicles[a.TRACTION, i] + vehicles[a.GRAVITY, i]
            holding = vehicles[a.BRAKE_FORCE, i] + vehicles[a.RESISTANCE_FORCE, i]
            force += vehicles[a.VEHICLE_MASS, i] * masses[a.ACCELERATION, m] - driving + holding
            vehicles[a.BAR_FORCE, i] = force
            if force > vehicles[a.BAR_COMPRESSION, i]:
                vehicles[a.BAR_COMPRESSION, i] = force
                vehicles[a.BAR_COMPRESSION_TIME, i] = time
            elif -force > vehicles[a.BAR_TENSION, i]:
                vehicles[a.BAR_TENSION, i] = -force
                vehicles[a.BAR_TENSION_TIME, i] = time
