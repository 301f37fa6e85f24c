"""Brake cylinder and brake shoes (paper sec. 2.3, eq. 3; TB/T 1407-1998)."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.data import BrakeState, Floats, Record, VehicleParameters, VehicleTrial


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
def set_coefficients(settings: Record, parameters: VehicleParameters, brakes: BrakeState, i: int) -> None:
    """Gain and offset [N] in ``brake force = gain * speed factor + offset`` for the present cylinder pressure."""
    total = brakes.fraction[i] * parameters.shoes[i] * parameters.shoe_force[i]
    k = parameters.shoe_force[i]
    # The paper's law, the coefficient at full pressure all along, is one for emergency applications.
    if settings.friction_follows_pressure or brakes.latched[i] == 0.0:
        k *= brakes.fraction[i]
    k_offset = parameters.friction_k_offset[i]
    by_pressure = (k + k_offset) / (parameters.friction_k_gain[i] * k + k_offset)
    by_initial_speed = parameters.friction_v0_reference[i] - brakes.initial_speed[i]
    brakes.gain_end[i] = total * parameters.friction_scale[i] * by_pressure
    brakes.offset_end[i] = total * parameters.friction_v0_slope[i] * by_initial_speed


@inner
def fill_cylinders(
    settings: Record, parameters: VehicleParameters, brakes: BrakeState, start: float, time: float
) -> None:
    """Bring every cylinder from ``start`` to ``time`` [s], or from when a wave reached it.

    Sets the brake coefficients for the end of the step.
    """
    for i in range(brakes.filling.shape[0]):
        if brakes.filling[i] == 0.0:
            continue
        elapsed = time - max(brakes.fraction_time[i], start)
        fraction = follow_target(settings, brakes.fraction[i], brakes.target[i], brakes.latched[i], elapsed)
        brakes.fraction[i] = fraction
        brakes.fraction_time[i] = time
        brakes.gain_start[i] = brakes.gain_end[i]
        brakes.offset_start[i] = brakes.offset_end[i]
        set_coefficients(settings, parameters, brakes, i)
        brakes.gain[i] = brakes.gain_end[i]
        brakes.offset[i] = brakes.offset_end[i]
        # One more turn after the target is reached makes the coefficients at start and end equal.
        settled = (
            fraction == brakes.target[i]
            and brakes.gain_start[i] == brakes.gain_end[i]
            and brakes.offset_start[i] == brakes.offset_end[i]
        )
        brakes.filling[i] = 0.0 if settled else 1.0


@inner
def interpolate_coefficients(brakes: BrakeState, part: float) -> None:
    """Set the brake coefficients to those at a part 0..1 of the step."""
    for i in range(brakes.gain.shape[0]):
        gain, offset = brakes.gain_start[i], brakes.offset_start[i]
        brakes.gain[i] = gain + part * (brakes.gain_end[i] - gain)
        brakes.offset[i] = offset + part * (brakes.offset_end[i] - offset)


@inner
def brake_forces(
    gain: Floats, offset: Floats, n_slope: Floats, n_offset: Floats, d_slope: Floats, trial: VehicleTrial
) -> None:
    """Brake force of every vehicle at its sliding speed [N], and its slope [N s/m], to ``trial``."""
    speed, force, friction_slope = trial.sliding_speed, trial.brake_force, trial.friction_slope
    for i in range(force.shape[0]):
        v = max(speed[i], 0.0)
        above = n_slope[i] * v + n_offset[i]
        factor = above / (d_slope[i] * v + 1.0)
        force[i] = gain[i] * factor + offset[i]
    for i in range(friction_slope.shape[0]):
        v = max(speed[i], 0.0)
        above = n_slope[i] * v + n_offset[i]
        below = 1.0 / (d_slope[i] * v + 1.0)
        slope = n_slope[i] - above * below * d_slope[i]
        friction_slope[i] = gain[i] * slope * below
