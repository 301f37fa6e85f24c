"""Coupler force by the velocity method (paper sec. 2.4, eq. 5), averaged over the way of a step.

With x = |stroke|, w the stroke rate and Ve the transition speed the law is

    F = sgn(stroke) m(x) + d(x) g(w),   m = (fu + fl)/2,   d = (fu - fl)/2,   g = w/Ve limited to -1 .. 1

fu (loading) and fl (unloading) are sums of hinges, which hold tables, slack, preload and bottoming alike.

What acts on the masses over a step is the mean of m and d along the way that the stroke goes, and of g between
the stroke rates at both ends. So the work of m is the change of the energy stored under it, whatever knots lie
on the way, and that of d is at least zero: no contact gives back more than it took, at any step. (Discrete gradient
by averaging: Gonzalez, J. Nonlinear Sci. 6, 1996; Quispel and McLaren, J. Phys. A 41, 2008. Where force is
proportional to stroke and rate it is Newmark's mean of the forces at both ends.)
"""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.data import Floats, GearParameters, GearState, GearTrial, Hinges

_STILL = 1e-300
"""Change [m, m/s over the transition speed] that is none, for its inverse may not be a number."""


@inner
def _strokes(velocity: Floats, stroke: Floats, rate: Floats, new_stroke: Floats, new_rate: Floats, h: float) -> None:
    """Stroke rates and strokes at the end of the step, by the Newmark formula s' = s + h/2 (w + w')."""
    for k in range(new_rate.shape[0]):
        new_rate[k] = velocity[k + 1] - velocity[k]
    for k in range(new_stroke.shape[0]):
        rates = rate[k] + new_rate[k]
        new_stroke[k] = stroke[k] + 0.5 * h * rates


@inner
def _way(stroke: Floats, new_stroke: Floats, low: Floats, high: Floats, per_span: Floats) -> None:
    """Smallest and largest magnitude of the stroke on the way, for a stroke that keeps its sign; 1 / difference."""
    for k in range(low.shape[0]):
        low[k] = min(abs(stroke[k]), abs(new_stroke[k]))
    for k in range(high.shape[0]):
        high[k] = max(abs(stroke[k]), abs(new_stroke[k]))
    for k in range(per_span.shape[0]):
        per_span[k] = 1.0 / (high[k] - low[k]) if high[k] - low[k] > _STILL else 0.0


@inner
def _past_knots(
    stroke: Floats,
    new_stroke: Floats,
    compression_knot: Floats,
    tension_knot: Floats,
    low: Floats,
    high: Floats,
    per_span: Floats,
    share: Floats,
    lever: Floats,
) -> None:
    """Part of the way past a knot, and how far past it the middle of that part lies."""
    for k in range(share.shape[0]):
        knot = compression_knot[k] if stroke[k] + new_stroke[k] >= 0.0 else tension_knot[k]
        past = high[k] - min(max(knot, low[k]), high[k])
        whole = 1.0 if low[k] >= knot else 0.0
        share[k] = past * per_span[k] if per_span[k] > 0.0 else whole
        lever[k] = max(0.5 * (high[k] + max(low[k], knot)) - knot, 0.0)


@inner
def _add_hinge(
    stroke: Floats,
    new_stroke: Floats,
    compression_change: Floats,
    tension_change: Floats,
    share: Floats,
    lever: Floats,
    value: Floats,
    slope: Floats,
) -> None:
    """Mean of a hinge along the way, and its slope by the magnitude of the stroke at the end."""
    for k in range(value.shape[0]):
        steeper = compression_change[k] if stroke[k] + new_stroke[k] >= 0.0 else tension_change[k]
        deeper = abs(new_stroke[k]) >= abs(stroke[k])
        moved = 1.0 - 0.5 * share[k] if deeper else 0.5 * share[k]
        steeper *= share[k]
        value[k] += steeper * lever[k]
        slope[k] += steeper * moved


@inner
def _curves_on_the_way(stroke: Floats, hinges: Hinges, trial: GearTrial) -> None:
    """Means of both curves along the way, for strokes that keep their sign."""
    new_stroke, low, high, share, lever = trial.stroke, trial.low, trial.high, trial.share, trial.lever
    _way(stroke, new_stroke, low, high, trial.per_span)
    for k in range(stroke.shape[0]):
        trial.mean[k] = 0.0
        trial.mean_slope[k] = 0.0
    for k in range(stroke.shape[0]):
        trial.hysteresis[k] = 0.0
        trial.hysteresis_slope[k] = 0.0
    for i in range(hinges.compression_knot.shape[0]):
        _past_knots(
            stroke, new_stroke, hinges.compression_knot[i], hinges.tension_knot[i],
            low, high, trial.per_span, share, lever,
        )  # fmt: skip
        _add_hinge(
            stroke, new_stroke, hinges.compression_mean[i], hinges.tension_mean[i],
            share, lever, trial.mean, trial.mean_slope,
        )  # fmt: skip
        _add_hinge(
            stroke, new_stroke, hinges.compression_hysteresis[i], hinges.tension_hysteresis[i],
            share, lever, trial.hysteresis, trial.hysteresis_slope,
        )  # fmt: skip


@inner
def _through_zero(hinges: Hinges, trial: GearTrial, k: int, stroke: float) -> None:
    """Means of both curves for a stroke that changes its sign: from the areas under them on either side of zero."""
    new_stroke = trial.stroke[k]
    span = new_stroke - stroke
    buff, draft = max(stroke, new_stroke), max(-stroke, -new_stroke)
    mean_area, hysteresis_area, mean, hysteresis = 0.0, 0.0, 0.0, 0.0
    for i in range(hinges.compression_knot.shape[0]):
        past_buff = max(buff - hinges.compression_knot[i, k], 0.0)
        past_draft = max(draft - hinges.tension_knot[i, k], 0.0)
        mean_buff, mean_draft = hinges.compression_mean[i, k] * past_buff, hinges.tension_mean[i, k] * past_draft
        hysteresis_buff = hinges.compression_hysteresis[i, k] * past_buff
        hysteresis_draft = hinges.tension_hysteresis[i, k] * past_draft
        mean_area += 0.5 * (mean_buff * past_buff - mean_draft * past_draft)
        hysteresis_area += 0.5 * (hysteresis_buff * past_buff + hysteresis_draft * past_draft)
        mean += mean_buff if new_stroke > 0.0 else -mean_draft
        hysteresis += hysteresis_buff if new_stroke > 0.0 else hysteresis_draft
    sign = 1.0 if stroke + new_stroke >= 0.0 else -1.0
    mean_force, half_gap = mean_area / abs(span), hysteresis_area / abs(span)
    trial.mean[k] = sign * mean_force
    trial.mean_slope[k] = (mean - mean_force) / span
    trial.hysteresis[k] = half_gap
    trial.hysteresis_slope[k] = sign * (hysteresis - half_gap) / span


@inner
def _transition(
    rate: Floats, new_rate: Floats, inverse_speed: Floats, transition: Floats, transition_slope: Floats
) -> None:
    """Mean of g between the stroke rates at both ends, and its slope by the one at the end."""
    for k in range(transition.shape[0]):
        start, end = rate[k] * inverse_speed[k], new_rate[k] * inverse_speed[k]
        low, high = min(start, end), max(start, end)
        changes = high - low > _STILL
        per_span = 1.0 / (high - low) if changes else 0.0
        from_, to = min(1.0, max(-1.0, low)), min(1.0, max(-1.0, high))
        saturated = max(high - max(low, 1.0), 0.0) - max(min(high, -1.0) - low, 0.0)
        middle = 0.5 * (from_ + to)
        moved = middle - low if end >= start else high - middle
        still = 0.5 if abs(end) < 1.0 else 0.0
        transition[k] = (saturated + (to - from_) * middle) * per_span if changes else to
        slope = ((to - from_) * per_span) * (moved * per_span)
        transition_slope[k] = (slope if changes else still) * inverse_speed[k]


@inner
def step_forces(
    velocity: Floats, parameters: GearParameters, hinges: Hinges, gears: GearState, trial: GearTrial, h: float
) -> None:
    """Mean forces of all draft gears over the step, and their tangents, for the trial velocities at its end.

    The tangent, by the stroke rate w' at the end, is h/2 dF/ds' + dF/dw'.
    """
    stroke, rate, new_stroke = gears.stroke, gears.stroke_rate, trial.stroke
    _strokes(velocity, stroke, rate, new_stroke, trial.stroke_rate, h)
    _curves_on_the_way(stroke, hinges, trial)
    for k in range(stroke.shape[0]):
        if stroke[k] * new_stroke[k] < 0.0:
            _through_zero(hinges, trial, k, stroke[k])
    _transition(rate, trial.stroke_rate, parameters.inverse_transition_speed, trial.transition, trial.transition_slope)
    mean, mean_slope, hysteresis, hysteresis_slope = (
        trial.mean,
        trial.mean_slope,
        trial.hysteresis,
        trial.hysteresis_slope,
    )
    transition, force, stiffness, tangent = trial.transition, trial.step_force, trial.stiffness, trial.tangent
    for k in range(force.shape[0]):
        sign = 1.0 if stroke[k] + new_stroke[k] >= 0.0 else -1.0
        force[k] = sign * mean[k] + hysteresis[k] * transition[k]
    for k in range(stiffness.shape[0]):
        sign = 1.0 if stroke[k] + new_stroke[k] >= 0.0 else -1.0
        stiffness[k] = mean_slope[k] + sign * (hysteresis_slope[k] * transition[k])
    for k in range(tangent.shape[0]):
        tangent[k] = 0.5 * h * stiffness[k] + hysteresis[k] * trial.transition_slope[k]


@inner
def forces_at_end(parameters: GearParameters, hinges: Hinges, trial: GearTrial) -> None:
    """Forces of all draft gears at the strokes and stroke rates of the end of the step."""
    stroke, rate, inverse_speed = trial.stroke, trial.stroke_rate, parameters.inverse_transition_speed
    mean, hysteresis, force = trial.end_mean, trial.end_hysteresis, trial.force
    for k in range(mean.shape[0]):
        mean[k] = 0.0
        hysteresis[k] = 0.0
    for i in range(hinges.compression_knot.shape[0]):
        for k in range(mean.shape[0]):
            buff = stroke[k] >= 0.0
            past = max(abs(stroke[k]) - (hinges.compression_knot[i, k] if buff else hinges.tension_knot[i, k]), 0.0)
            mean[k] += (hinges.compression_mean[i, k] if buff else hinges.tension_mean[i, k]) * past
            hysteresis[k] += (hinges.compression_hysteresis[i, k] if buff else hinges.tension_hysteresis[i, k]) * past
    for k in range(force.shape[0]):
        sign = 1.0 if stroke[k] >= 0.0 else -1.0
        g = min(1.0, max(-1.0, rate[k] * inverse_speed[k]))
        force[k] = sign * mean[k] + hysteresis[k] * g


@inner
def force_at(hinges: Hinges, k: int, stroke: float, g: float) -> float:
    """Force of one draft gear at a stroke, and at a stroke rate over the transition speed of -1 .. 1."""
    mean, hysteresis = 0.0, 0.0
    buff = stroke >= 0.0
    for i in range(hinges.compression_knot.shape[0]):
        past = max(abs(stroke) - (hinges.compression_knot[i, k] if buff else hinges.tension_knot[i, k]), 0.0)
        mean += (hinges.compression_mean[i, k] if buff else hinges.tension_mean[i, k]) * past
        hysteresis += (hinges.compression_hysteresis[i, k] if buff else hinges.tension_hysteresis[i, k]) * past
    return (mean if buff else -mean) + hysteresis * g
