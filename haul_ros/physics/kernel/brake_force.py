"""Brake cylinder and brake shoes (paper sec. 2.3, eq. 3; TB/T 1407-1998)."""

from __future__ import annotations

from haul_ros.physics.kernel import arrays as a
from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.arrays import Floats, Record


@inner
def follow_target(settings: Record, fraction: float, target: float, latched: float, elapsed: float) -> float:
    """Cylinder pressure, as a fraction of emergency pressure, after ``elapsed`` seconds (>= 0).

    Emergency (``latched`` = 1) fills in two stages, service and release at their own rates.
    """
    if elapsed <= 0.0 or fraction == target:
        return fraction
    if fraction > target:
        return max(target, fraction - settings.rate_release * elapsed)
    if latched == 0.0:
        return min(target, fraction + settings.rate_service * elapsed)
    if fraction < settings.knee:
        to_knee = (settings.knee - fraction) / settings.rate_to_knee
        if elapsed < to_knee:
            return fraction + settings.rate_to_knee * elapsed
        fraction = settings.knee
        elapsed -= to_knee
    if elapsed > 0.0:
        fraction += settings.rate_from_knee * elapsed
    return min(target, fraction)


@inner
def _set_coefficients(settings: Record, vehicles: Floats, i: int) -> None:
    """Gain and trim [N] in ``brake force = gain * speed factor + trim`` for the present cylinder pressure."""
    total = vehicles[a.FRACTION, i] * vehicles[a.SHOES, i] * vehicles[a.SHOE_FORCE, i]
    k = vehicles[a.SHOE_FORCE, i]
    if settings.friction_follows_pressure:
        k *= vehicles[a.FRACTION, i]
    k_offset = vehicles[a.FRICTION_K_OFFSET, i]
    by_pressure = (k + k_offset) / (vehicles[a.FRICTION_K_GAIN, i] * k + k_offset)
    by_initial_speed = vehicles[a.FRICTION_V0_REFERENCE, i] - vehicles[a.INITIAL_SPEED, i]
    vehicles[a.GAIN_END, i] = total * vehicles[a.FRICTION_SCALE, i] * by_pressure
    vehicles[a.TRIM_END, i] = total * vehicles[a.FRICTION_V0_SLOPE, i] * by_initial_speed


@inner
def fill_cylinders(settings: Record, vehicles: Floats, start: float, time: float) -> None:
    """Bring every cylinder from ``start`` to ``time`` [s], or from when a wave reached it.

    Sets the brake coefficients for the end of the step.
    """
    for i in range(vehicles.shape[1]):
        if vehicles[a.FILLING, i] == 0.0:
            continue
        elapsed = time - max(vehicles[a.FRACTION_TIME, i], start)
        latched = vehicles[a.LATCHED, i]
        fraction = follow_target(settings, vehicles[a.FRACTION, i], vehicles[a.TARGET, i], latched, elapsed)
        vehicles[a.FRACTION, i] = fraction
        vehicles[a.FRACTION_TIME, i] = time
        vehicles[a.GAIN_START, i] = vehicles[a.GAIN_END, i]
        vehicles[a.TRIM_START, i] = vehicles[a.TRIM_END, i]
        _set_coefficients(settings, vehicles, i)
        vehicles[a.GAIN, i] = vehicles[a.GAIN_END, i]
        vehicles[a.TRIM, i] = vehicles[a.TRIM_END, i]
        # One more turn after the target is reached makes the coefficients at start and end equal.
        settled = (
            fraction == vehicles[a.TARGET, i]
            and vehicles[a.GAIN_START, i] == vehicles[a.GAIN_END, i]
            and vehicles[a.TRIM_START, i] == vehicles[a.TRIM_END, i]
        )
        vehicles[a.FILLING, i] = 0.0 if settled else 1.0


@inner
def interpolate_coefficients(vehicles: Floats, share: float) -> None:
    """Set the brake coefficients to those at a share 0..1 of the step."""
    for i in range(vehicles.shape[1]):
        gain, trim = vehicles[a.GAIN_START, i], vehicles[a.TRIM_START, i]
        vehicles[a.GAIN, i] = gain + share * (vehicles[a.GAIN_END, i] - gain)
        vehicles[a.TRIM, i] = trim + share * (vehicles[a.TRIM_END, i] - trim)


@inner
def brake_forces(vehicles: Floats) -> None:
    """Brake force of every vehicle at its sliding speed [N], and its slope [N s/m], stored in NEW_SLOPE."""
    for i in range(vehicles.shape[1]):
        v = max(vehicles[a.SLIDING_SPEED, i], 0.0)
        above = vehicles[a.FRICTION_N_SLOPE, i] * v + vehicles[a.FRICTION_N_OFFSET, i]
        factor = above / (vehicles[a.FRICTION_D_SLOPE, i] * v + 1.0)
        vehicles[a.NEW_BRAKE, i] = vehicles[a.GAIN, i] * factor + vehicles[a.TRIM, i]
    for i in range(vehicles.shape[1]):
        v = max(vehicles[a.SLIDING_SPEED, i], 0.0)
        above = vehicles[a.FRICTION_N_SLOPE, i] * v + vehicles[a.FRICTION_N_OFFSET, i]
        below = 1.0 / (vehicles[a.FRICTION_D_SLOPE, i] * v + 1.0)
        slope = vehicles[a.FRICTION_N_SLOPE, i] - above * below * vehicles[a.FRICTION_D_SLOPE, i]
        vehicles[a.NEW_SLOPE, i] = vehicles[a.GAIN, i] * slope * below
