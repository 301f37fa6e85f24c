"""Brake waves in the brake pipe (paper sec. 2.2, eq. 4)."""

from __future__ import annotations

from haul_ros.physics.kernel import arrays as a
from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.arrays import Floats, Ints, Record, Records
from haul_ros.physics.kernel.brake_force import follow_target


@inner
def _acts(wave: Record, vehicles: Floats, i: int) -> bool:
    """Whether a wave still has anything to say to a vehicle.

    A wave that a newer one of the opposite kind has overtaken, or met from the other side, has not;
    in an emergency only its end and other emergencies have.
    """
    if wave.kind == a.EMERGENCY:
        return wave.serial > vehicles[a.UNLATCHED_BY, i]
    if wave.kind == a.EMERGENCY_RELEASE:
        return wave.serial > vehicles[a.LATCHED_BY, i]
    if vehicles[a.LATCHED, i] == 1.0:
        return False
    if wave.kind == a.SERVICE:
        return wave.serial > max(vehicles[a.RELEASED_BY, i], vehicles[a.UNLATCHED_BY, i])
    return wave.serial > vehicles[a.APPLIED_BY, i]


@inner
def _arrive(settings: Record, wave: Record, vehicles: Floats, i: int, speed: float, start: float, time: float) -> None:
    """Wave reaches a vehicle: bring its cylinder from ``start`` up to that instant, then set the new target."""
    if not _acts(wave, vehicles, i):
        return
    latched = vehicles[a.LATCHED, i]
    fraction, target = vehicles[a.FRACTION, i], vehicles[a.TARGET, i]
    elapsed = time - max(vehicles[a.FRACTION_TIME, i], start)
    if elapsed > 0.0:
        fraction = follow_target(settings, fraction, target, latched, elapsed)
        vehicles[a.FRACTION, i] = fraction
    vehicles[a.FRACTION_TIME, i] = max(vehicles[a.FRACTION_TIME, i], time)
    vehicles[a.FILLING, i] = 1.0
    if fraction == 0.0 and (wave.kind == a.EMERGENCY or wave.kind == a.SERVICE):
        vehicles[a.INITIAL_SPEED, i] = speed
    if wave.kind == a.EMERGENCY:
        vehicles[a.LATCHED, i] = 1.0
        vehicles[a.TARGET, i] = 1.0
        vehicles[a.LATCHED_BY, i] = max(vehicles[a.LATCHED_BY, i], wave.serial)
        vehicles[a.NEW_TRACTION, i] = 0.0  # a locomotive stops pulling when its brake pipe is vented
    elif wave.kind == a.EMERGENCY_RELEASE:
        vehicles[a.LATCHED, i] = 0.0
        vehicles[a.TARGET, i] = 0.0
        vehicles[a.UNLATCHED_BY, i] = max(vehicles[a.UNLATCHED_BY, i], wave.serial)
    elif wave.kind == a.SERVICE:
        # A weaker application, late from another locomotive, does not feed the pipe.
        vehicles[a.TARGET, i] = max(target, wave.level)
        vehicles[a.APPLIED_BY, i] = max(vehicles[a.APPLIED_BY, i], wave.serial)
    elif wave.kind == a.RELEASE:
        vehicles[a.TARGET, i] = min(target, wave.level)
        vehicles[a.RELEASED_BY, i] = max(vehicles[a.RELEASED_BY, i], wave.serial)


@inner
def arrival_time(wave: Record, offset: float, origin_offset: float) -> float:
    """Time [s] at which a wave reaches a vehicle: its start plus distance over wave speed."""
    return wave.time + abs(offset - origin_offset) / wave.speed


@inner
def _copy(source: Record, target: Record) -> None:
    target.time = source.time
    target.speed = source.speed
    target.level = source.level
    target.kind = source.kind
    target.serial = source.serial
    target.origin = source.origin
    target.ahead = source.ahead
    target.behind = source.behind


@inner
def advance_waves(
    settings: Record,
    counters: Record,
    waves: Records,
    masses: Floats,
    vehicles: Floats,
    places: Ints,
    start: float,
    time: float,
) -> None:
    """Let every wave run, in both directions from its locomotive, in a step from ``start`` to ``time`` [s].

    Arrivals need not fall on time steps: the cylinder starts to fill at the exact arrival time.
    Waves that have left the train are removed, the others keep their order.
    """
    kept = 0
    for w in range(counters.waves):
        wave = waves[w]
        origin = vehicles[a.OFFSET, wave.origin]
        for direction in (-1, 1):
            i = wave.ahead if direction < 0 else wave.behind
            while 0 <= i < vehicles.shape[1]:
                arrival = arrival_time(wave, vehicles[a.OFFSET, i], origin)
                if arrival > time:
                    break
                speed = abs(masses[a.VELOCITY, places[a.MASS_INDEX, i]])
                _arrive(settings, wave, vehicles, i, speed, start, arrival)
                i += direction
            if direction < 0:
                wave.ahead = i
            else:
                wave.behind = i
        if wave.ahead >= 0 or wave.behind < vehicles.shape[1]:
            if kept != w:
                _copy(wave, waves[kept])
            kept += 1
    counters.waves = kept
