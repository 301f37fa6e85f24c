"""Running resistance (TB/T 1407-1998), grade and curve."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.data import (
    Floats,
    GradePieces,
    Ints,
    LineIndex,
    LineSteps,
    MassState,
    VehicleParameters,
    VehicleTrial,
)


@inner
def running_resistance(parameters: VehicleParameters, trial: VehicleTrial) -> None:
    """Resistance of every vehicle at its sliding speed [N], curve included, and its slope, added to that of the brake.

    Below the lowest speed of the formula its value there holds; standing vehicles get what has
    to be overcome at a start.
    """
    constant, linear = parameters.resistance_constant, parameters.resistance_linear
    quadratic, standing = parameters.resistance_quadratic, parameters.resistance_standing
    lowest_speed, speed, curve_drag = parameters.resistance_lowest_speed, trial.sliding_speed, trial.curve_drag
    resistance, friction_slope = trial.resistance_force, trial.friction_slope
    for i in range(resistance.shape[0]):
        v = max(speed[i], lowest_speed[i])
        by_speed = (linear[i] + quadratic[i] * v) * v
        force = constant[i] + by_speed
        force = standing[i] if speed[i] < 0.0 else force
        resistance[i] = force + curve_drag[i]
    for i in range(friction_slope.shape[0]):
        v = speed[i]
        slope = linear[i] + 2.0 * quadratic[i] * v
        friction_slope[i] += slope if v > lowest_speed[i] else 0.0


@inner
def _step_index(start: Floats, chainage: float, index: int) -> int:
    """Index of the piece of the line that holds at a chainage; -1 before the first. ``index``: where to start."""
    while index + 1 < start.shape[0] and chainage >= start[index + 1]:
        index += 1
    while index >= 0 and chainage < start[index]:
        index -= 1
    return index


@inner
def line_forces(
    start: float,
    grades: GradePieces,
    curves: LineSteps,
    masses: MassState,
    mass_index: Ints,
    parameters: VehicleParameters,
    line_index: LineIndex,
    trial: VehicleTrial,
    h: float,
) -> None:
    """Grade force and curve resistance of every vehicle at its own chainage at the end of the step.

    ``start`` is the chainage of the head at t = 0 [m]. The position is predicted with the
    acceleration at the start of the step: the pieces of the line then do not move while Newton iterates.
    """
    displacement, velocity, acceleration = masses.displacement, masses.velocity, masses.acceleration
    for i in range(mass_index.shape[0]):
        m = mass_index[i]
        travelled = displacement[m] + h * velocity[m] + 0.5 * h * h * acceleration[m]
        chainage = start - parameters.centre_offset[i] + travelled
        g = _step_index(grades.start, chainage, line_index.grade[i])
        line_index.grade[i] = g
        grade = grades.value[g] + grades.slope[g] * (chainage - grades.start[g]) if g >= 0 else 0.0
        trial.gravity[i] = -parameters.weight[i] * grade
        k = _step_index(curves.start, chainage, line_index.curve[i])
        line_index.curve[i] = k
        trial.curve_drag[i] = parameters.weight[i] * curves.value[k] if k >= 0 else 0.0
