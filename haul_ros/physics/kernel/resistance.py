"""Running resistance (TB/T 1407-1998), grade and curve."""

from __future__ import annotations

from haul_ros.physics.kernel import arrays as a
from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.arrays import Floats, Ints, Records


@inner
def running_resistance(vehicles: Floats) -> None:
    """Resistance of every vehicle at its sliding speed [N], curve included, and its slope, added to NEW_SLOPE.

    Below the lowest speed of the formula its value there holds; standing vehicles get what has
    to be overcome at a start.
    """
    for i in range(vehicles.shape[1]):
        v = max(vehicles[a.SLIDING_SPEED, i], vehicles[a.RESISTANCE_LOWEST_SPEED, i])
        by_speed = (vehicles[a.RESISTANCE_LINEAR, i] + vehicles[a.RESISTANCE_QUADRATIC, i] * v) * v
        force = vehicles[a.RESISTANCE_CONSTANT, i] + by_speed
        force = vehicles[a.RESISTANCE_STANDING, i] if vehicles[a.SLIDING_SPEED, i] < 0.0 else force
        vehicles[a.NEW_RESISTANCE, i] = force + vehicles[a.CURVE_DRAG, i]
    for i in range(vehicles.shape[1]):
        v = vehicles[a.SLIDING_SPEED, i]
        slope = vehicles[a.RESISTANCE_LINEAR, i] + 2.0 * vehicles[a.RESISTANCE_QUADRATIC, i] * v
        vehicles[a.NEW_SLOPE, i] += slope if v > vehicles[a.RESISTANCE_LOWEST_SPEED, i] else 0.0


@inner
def _step_index(steps: Records, chainage: float, index: int) -> int:
    """Index of the step that holds at a chainage; -1 before the first. ``index`` is where to start looking."""
    while index + 1 < steps.shape[0] and chainage >= steps[index + 1].start:
        index += 1
    while index >= 0 and chainage < steps[index].start:
        index -= 1
    return index


@inner
def line_forces(
    start: float, grades: Records, curves: Records, masses: Floats, vehicles: Floats, places: Ints, h: float
) -> None:
    """Grade force and curve resistance of every vehicle at its own chainage at the end of the step.

    ``start`` is the chainage of the head at t = 0 [m]. The position is predicted with the
    acceleration at the start of the step: the steps of the line then do not move while Newton iterates.
    """
    for i in range(vehicles.shape[1]):
        m = places[a.MASS_INDEX, i]
        way = masses[a.DISPLACEMENT, m] + h * masses[a.VELOCITY, m] + 0.5 * h * h * masses[a.ACCELERATION, m]
        chainage = start - vehicles[a.OFFSET, i] + way
        g = _step_index(grades, chainage, places[a.GRADE_INDEX, i])
        places[a.GRADE_INDEX, i] = g
        vehicles[a.NEW_GRAVITY, i] = -vehicles[a.WEIGHT, i] * grades[g].value if g >= 0 else 0.0
        k = _step_index(curves, chainage, places[a.CURVE_INDEX, i])
        places[a.CURVE_INDEX, i] = k
        vehicles[a.CURVE_DRAG, i] = vehicles[a.WEIGHT, i] * curves[k].value if k >= 0 else 0.0
