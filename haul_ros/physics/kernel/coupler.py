"""Coupler force by the velocity method (paper sec. 2.4, eq. 5)."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.data import Floats, GearParameters, GearState, GearTrial, Hinges


@inner
def _strokes(velocity: Floats, stroke: Floats, rate: Floats, new_stroke: Floats, new_rate: Floats, h: float) -> None:
    """Stroke rates and strokes at the end of the step, by the Newmark formula s' = s + h/2 (w + w')."""
    for k in range(new_rate.shape[0]):
        new_rate[k] = velocity[k + 1] - velocity[k]
    for k in range(new_stroke.shape[0]):
        rates = rate[k] + new_rate[k]
        new_stroke[k] = stroke[k] + 0.5 * h * rates


@inner
def _curve(
    stroke: Floats,
    compression_knot: Floats,
    compression_change: Floats,
    tension_knot: Floats,
    tension_change: Floats,
    value: Floats,
    slope: Floats,
) -> None:
    """Sum of hinges at the magnitude of the stroke, and its slope."""
    for k in range(value.shape[0]):
        value[k] = 0.0
        slope[k] = 0.0
    for i in range(compression_knot.shape[0]):
        for k in range(value.shape[0]):
            buff = stroke[k] >= 0.0
            past = abs(stroke[k]) - (compression_knot[i, k] if buff else tension_knot[i, k])
            steeper = compression_change[i, k] if buff else tension_change[i, k]
            steeper = steeper if past >= 0.0 else 0.0
            slope[k] += steeper
            value[k] += steeper * max(past, 0.0)


@inner
def coupler_forces(
    velocity: Floats, parameters: GearParameters, hinges: Hinges, gears: GearState, trial: GearTrial, h: float
) -> None:
    """Strokes, forces and tangents of all draft gears, to ``trial``, for the trial velocities of the masses.

    With x = |stroke|, w the stroke rate towards larger x and Ve the transition speed:

        F = sgn(stroke) [ (fu + fl)/2 + (fu - fl)/2 g ],   g = w/Ve limited to -1 .. 1

    fu (loading) and fl (unloading) are sums of hinges, which hold tables, slack, preload and
    bottoming alike. The tangent is dF/dw' = h/2 dF/ds + dF/dw.
    """
    inverse_speed, stroke, rate = parameters.inverse_transition_speed, trial.stroke, trial.stroke_rate
    mean, hysteresis = trial.mean, trial.hysteresis
    mean_slope, hysteresis_slope = trial.mean_slope, trial.hysteresis_slope
    _strokes(velocity, gears.stroke, gears.stroke_rate, stroke, rate, h)
    _curve(
        stroke, hinges.compression_knot, hinges.compression_mean, hinges.tension_knot, hinges.tension_mean,
        mean, mean_slope,
    )  # fmt: skip
    _curve(
        stroke, hinges.compression_knot, hinges.compression_hysteresis, hinges.tension_knot, hinges.tension_hysteresis,
        hysteresis, hysteresis_slope,
    )  # fmt: skip
    force, tangent = trial.force, trial.tangent
    for k in range(force.shape[0]):
        sign = 1.0 if stroke[k] >= 0.0 else -1.0
        g = min(1.0, max(-1.0, sign * rate[k] * inverse_speed[k]))
        force[k] = sign * (mean[k] + hysteresis[k] * g)
    for k in range(tangent.shape[0]):
        sign = 1.0 if stroke[k] >= 0.0 else -1.0
        g = sign * rate[k] * inverse_speed[k]
        damping = hysteresis[k] * inverse_speed[k]
        damping = damping if abs(g) < 1.0 else 0.0
        g = min(1.0, max(-1.0, g))
        tangent[k] = 0.5 * h * (mean_slope[k] + hysteresis_slope[k] * g) + damping
