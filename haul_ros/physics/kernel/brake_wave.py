"""Brake waves in the brake pipe (paper sec. 2.2, eq. 4)."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.brake_force import follow_target
from haul_ros.physics.kernel.data import (
    EMERGENCY,
    EMERGENCY_RELEASE,
    RELEASE,
    SERVICE,
    BrakeState,
    Floats,
    Ints,
    Record,
    Records,
    VehicleParameters,
    VehicleState,
)
from haul_ros.physics.kernel.effort import drop_efforts, stop_pulling


@inner
def _acts(wave: Record, brakes: BrakeState, i: int) -> bool:
    """Whether a wave still has anything to say to a vehicle.

    A wave that a newer one of the opposite kind has overtaken, or met from the other side, has not;
    in an emergency only its end and other emergencies have.
    """
    if wave.kind == EMERGENCY:
        return wave.serial > brakes.unlatched_by[i]
    if wave.kind == EMERGENCY_RELEASE:
        return wave.serial > brakes.latched_by[i]
    if brakes.latched[i] == 1.0:
        return False
    if wave.kind == SERVICE:
        return wave.serial > max(brakes.released_by[i], brakes.unlatched_by[i])
    return wave.serial > brakes.applied_by[i]


@inner
def _arrive(
    settings: Record,
    wave: Record,
    brakes: BrakeState,
    parameters: VehicleParameters,
    vehicles: VehicleState,
    i: int,
    speed: float,
    start: float,
    time: float,
) -> None:
    """Wave reaches a vehicle: bring its cylinder from ``start`` up to that instant, then set the new target."""
    if not _acts(wave, brakes, i):
        return
    fraction, target = brakes.fraction[i], brakes.target[i]
    elapsed = time - max(brakes.fraction_time[i], start)
    if elapsed > 0.0:
        fraction = follow_target(settings, fraction, target, brakes.latched[i], elapsed)
        brakes.fraction[i] = fraction
    brakes.fraction_time[i] = max(brakes.fraction_time[i], time)
    brakes.filling[i] = 1.0
    if fraction == 0.0 and (wave.kind == EMERGENCY or wave.kind == SERVICE):
        brakes.initial_speed[i] = speed
    if wave.kind == EMERGENCY:
        brakes.latched[i] = 1.0
        brakes.target[i] = 1.0
        brakes.latched_by[i] = max(brakes.latched_by[i], wave.serial)
        drop_efforts(parameters, vehicles, i)
    elif wave.kind == EMERGENCY_RELEASE:
        brakes.latched[i] = 0.0
        brakes.target[i] = 0.0
        brakes.unlatched_by[i] = max(brakes.unlatched_by[i], wave.serial)
    elif wave.kind == SERVICE:
        # A weaker application, late from another locomotive, does not feed the pipe.
        brakes.target[i] = max(target, wave.level)
        brakes.applied_by[i] = max(brakes.applied_by[i], wave.serial)
        if vehicles.link_down[i] != 0.0:  # the brake pipe is all that tells this locomotive of an application
            stop_pulling(vehicles, i)
    elif wave.kind == RELEASE:
        brakes.target[i] = min(target, wave.level)
        brakes.released_by[i] = max(brakes.released_by[i], wave.serial)


@inner
def arrival_time(wave: Record, offset: float, origin_offset: float) -> float:
    """Time [s] at which a wave reaches a vehicle: its start plus distance over wave speed."""
    return wave.time + abs(offset - origin_offset) / wave.speed


@inner
def advance_waves(
    settings: Record,
    counters: Record,
    waves: Records,
    velocity: Floats,
    mass_index: Ints,
    parameters: VehicleParameters,
    brakes: BrakeState,
    vehicles: VehicleState,
    start: float,
    time: float,
) -> None:
    """Let every wave run, in both directions from its locomotive, in a step from ``start`` to ``time`` [s].

    Arrivals need not fall on time steps: the cylinder starts to fill at the exact arrival time.
    Waves that have left the train, or come to its ends or to parted hoses, are removed, the others keep their order.
    """
    centre_offset = parameters.centre_offset
    kept = 0
    for w in range(counters.waves):
        wave = waves[w]
        origin = centre_offset[wave.origin]
        for direction in (-1, 1):
            i = wave.ahead if direction < 0 else wave.behind
            while wave.first <= i <= wave.last:
                arrival = arrival_time(wave, centre_offset[i], origin)
                if arrival > time:
                    break
                speed = abs(velocity[mass_index[i]])
                _arrive(settings, wave, brakes, parameters, vehicles, i, speed, start, arrival)
                i += direction
            if direction < 0:
                wave.ahead = i
            else:
                wave.behind = i
        if wave.ahead >= wave.first or wave.behind <= wave.last:
            waves[kept] = waves[w]
            kept += 1
    counters.waves = kept
