"""Coupler force by the velocity method (paper sec. 2.4, eq. 5)."""

from __future__ import annotations

from haul_ros.physics.kernel import arrays as a
from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.arrays import Floats


@inner
def _strokes(masses: Floats, joints: Floats, h: float) -> None:
    """Stroke rates and strokes at the end of the step, by the Newmark formula s' = s + h/2 (w + w')."""
    for k in range(joints.shape[1]):
        joints[a.NEW_RATE, k] = masses[a.NEW_VELOCITY, k + 1] - masses[a.NEW_VELOCITY, k]
    for k in range(joints.shape[1]):
        rates = joints[a.STROKE_RATE, k] + joints[a.NEW_RATE, k]
        joints[a.NEW_STROKE, k] = joints[a.STROKE, k] + 0.5 * h * rates


@inner
def _curve(joints: Floats, hinges: Floats, quantity: int, value: int, slope: int) -> None:
    """Sum of hinges at the magnitude of the new stroke, to the rows ``value`` and ``slope``."""
    for k in range(joints.shape[1]):
        joints[value, k] = 0.0
        joints[slope, k] = 0.0
    for i in range(hinges.shape[2]):
        for k in range(joints.shape[1]):
            stroke = joints[a.NEW_STROKE, k]
            buff = stroke >= 0.0
            past = abs(stroke) - (hinges[a.KNOT, a.COMPRESSION, i, k] if buff else hinges[a.KNOT, a.TENSION, i, k])
            steeper = hinges[quantity, a.COMPRESSION, i, k] if buff else hinges[quantity, a.TENSION, i, k]
            steeper = steeper if past >= 0.0 else 0.0
            joints[slope, k] += steeper
            joints[value, k] += steeper * max(past, 0.0)


@inner
def coupler_forces(masses: Floats, joints: Floats, hinges: Floats, h: float) -> None:
    """Strokes, forces and tangents of all connections for the trial velocities.

    With x = |stroke|, w the stroke rate towards larger x and Ve the transition speed:

        F = sgn(stroke) [ (fu + fl)/2 + (fu - fl)/2 g ],   g = w/Ve limited to -1 .. 1

    fu (loading) and fl (unloading) are sums of hinges, which hold tables, slack, preload and
    bottoming alike. The tangent is dF/dw' = h/2 dF/ds + dF/dw.
    """
    _strokes(masses, joints, h)
    _curve(joints, hinges, a.HINGE_MEAN, a.MEAN, a.MEAN_SLOPE)
    _curve(joints, hinges, a.HINGE_GAP, a.GAP, a.GAP_SLOPE)
    for k in range(joints.shape[1]):
        sign = 1.0 if joints[a.NEW_STROKE, k] >= 0.0 else -1.0
        g = min(1.0, max(-1.0, sign * joints[a.NEW_RATE, k] * joints[a.INVERSE_TRANSITION_SPEED, k]))
        joints[a.NEW_FORCE, k] = sign * (joints[a.MEAN, k] + joints[a.GAP, k] * g)
    for k in range(joints.shape[1]):
        sign = 1.0 if joints[a.NEW_STROKE, k] >= 0.0 else -1.0
        g = sign * joints[a.NEW_RATE, k] * joints[a.INVERSE_TRANSITION_SPEED, k]
        damping = joints[a.GAP, k] * joints[a.INVERSE_TRANSITION_SPEED, k]
        damping = damping if abs(g) < 1.0 else 0.0
        g = min(1.0, max(-1.0, g))
        joints[a.TANGENT, k] = 0.5 * h * (joints[a.MEAN_SLOPE, k] + joints[a.GAP_SLOPE, k] * g) + damping
