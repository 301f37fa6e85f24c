"""Data of the kernel, in SI units: flat arrays, one row for each quantity.

A *mass* is one vehicle, or several joined by rigid drawbars; a *connection* is a coupler with a
draft gear, between mass ``k`` and mass ``k + 1``. Without rigid drawbars masses are vehicles and
connections are couplers.

Each quantity lies in one piece in memory and loops do one thing at a time, so the compiler works
on several vehicles at once; a loop that stores to many rows would stop it from doing so.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Records = NDArray[np.void]
Record = Any
"""One element of a structured array, as numba sees it."""

COMPRESSION, TENSION = 0, 1

# Kinds of brake wave.
SERVICE, RELEASE, EMERGENCY, EMERGENCY_RELEASE = 0, 1, 2, 3

# Rows of Train.masses. direction: +1 forward, -1 backward, 0 standing, held by friction; push: force without
# friction [N]; outer: traction and gravity [N]; friction: magnitude while sliding, or at most while standing [N],
# friction_slope [N s/m]; share: part of it that acts; way: within the step [m]; new_*: trial values for its end.
(
    MASS,
    DISPLACEMENT,
    VELOCITY,
    ACCELERATION,
    DIRECTION,
    PUSH,
    NEW_VELOCITY,
    NEW_DIRECTION,
    NEW_PUSH,
    OUTER,
    FRICTION,
    FRICTION_SLOPE,
    SHARE,
    WAY,
    DIAGONAL,
    OFF_DIAGONAL,
    RESIDUAL,
) = range(17)
N_MASS_ROWS = 17

# Rows of Train.connections. work: done on the gear since the start [J]; mean, gap: (fu + fl)/2 and (fu - fl)/2 [N]
# and their slopes [N/m]; tangent: dF/d(stroke rate at the end of the step) [N s/m]; full_stroke: at which the gear
# is closed, slack included [m]; times [s], bottomed_time NaN if never; inverse_transition_speed: 1/Ve [s/m].
(
    INVERSE_TRANSITION_SPEED,
    FULL_STROKE,
    STROKE,
    STROKE_RATE,
    FORCE,
    WORK,
    NEW_STROKE,
    NEW_RATE,
    NEW_FORCE,
    TANGENT,
    MEAN,
    MEAN_SLOPE,
    GAP,
    GAP_SLOPE,
    MAX_COMPRESSION,
    MAX_COMPRESSION_TIME,
    MAX_TENSION,
    MAX_TENSION_TIME,
    MAX_COMPRESSION_STROKE,
    MAX_TENSION_STROKE,
    BOTTOMED_TIME,
) = range(21)
N_CONNECTION_ROWS = 21

# Rows of Train.vehicles.
# offset: centre behind the head of the train [m]. resistance: constant [N], linear [N s/m], quadratic [N s^2/m^2],
# lowest speed of the formula [m/s], standing: to be overcome at a start [N].
# Shoes: shoe_force in emergency [N]; friction factor = (n_slope v + n_offset)/(d_slope v + 1), the rest as in
# model.vehicle.ShoeFriction.
# traction, gravity: forward positive [N]; brake_force, resistance_force: against forward motion positive [N]; works
# since the start [J]: brake and resistance taken from the train, gravity and traction given to it.
# fraction, target: brake cylinder pressure over emergency pressure; fraction_time: the instant that fraction belongs
# to [s]; initial_speed: when this application began [m/s]; latched: 1 in emergency; *_by: serial number of the
# newest wave that did so; brake force = gain * friction
# factor + trim [N], at the start and the end of the step; filling: 1 while these may differ.
# sliding_speed: trial speed in the direction of motion [m/s], -1 at a standstill.
# bar_*: rigid drawbar behind the vehicle, if there is one: force [N], extremes [N], times [s].
(
    VEHICLE_MASS,
    WEIGHT,
    OFFSET,
    RESISTANCE_CONSTANT,
    RESISTANCE_LINEAR,
    RESISTANCE_QUADRATIC,
    RESISTANCE_LOWEST_SPEED,
    RESISTANCE_STANDING,
    SHOES,
    SHOE_FORCE,
    FRICTION_SCALE,
    FRICTION_K_OFFSET,
    FRICTION_K_GAIN,
    FRICTION_N_SLOPE,
    FRICTION_N_OFFSET,
    FRICTION_D_SLOPE,
    FRICTION_V0_SLOPE,
    FRICTION_V0_REFERENCE,
    TRACTION,
    NEW_TRACTION,
    GRAVITY,
    NEW_GRAVITY,
    CURVE_DRAG,
    BRAKE_FORCE,
    RESISTANCE_FORCE,
    BRAKE_WORK,
    RESISTANCE_WORK,
    GRAVITY_WORK,
    TRACTION_WORK,
    FRACTION,
    TARGET,
    FRACTION_TIME,
    INITIAL_SPEED,
    LATCHED,
    LATCHED_BY,
    UNLATCHED_BY,
    APPLIED_BY,
    RELEASED_BY,
    FILLING,
    GAIN,
    TRIM,
    GAIN_START,
    TRIM_START,
    GAIN_END,
    TRIM_END,
    SLIDING_SPEED,
    NEW_BRAKE,
    NEW_RESISTANCE,
    NEW_SLOPE,
    VEHICLE_SHARE,
    VEHICLE_WAY,
    BAR_FORCE,
    BAR_COMPRESSION,
    BAR_COMPRESSION_TIME,
    BAR_TENSION,
    BAR_TENSION_TIME,
) = range(56)
N_VEHICLE_ROWS = 56

# Rows of Train.members (per mass) and Train.places (per vehicle).
FIRST, END = 0, 1
MASS_INDEX, GRADE_INDEX, CURVE_INDEX = 0, 1, 2

# First index of Train.hinges: (fu + fl)/2 and (fu - fl)/2 are sums of slope * max(0, x - knot).
KNOT, HINGE_MEAN, HINGE_GAP = 0, 1, 2


def _record(fields: str) -> np.dtype[np.void]:
    """Structured type of 8-byte fields, named in a text: real numbers, or integers if marked ``#``."""
    kinds = [(name.lstrip("#"), "i8" if name.startswith("#") else "f8") for name in fields.split()]
    return np.dtype(kinds, align=True)


SETTINGS = _record("""
    time_step tolerance start_chainage #has_line #has_stops #has_drawbars #has_traction
    knee rate_to_knee rate_from_knee rate_service rate_release #friction_follows_pressure
""")
"""time_step [s]; tolerance: force residual at which a step is converged [N]; start_chainage: of the
head at t = 0 [m]; knee: fraction of emergency pressure; rates: such fractions per second [1/s]."""

COUNTERS = _record(
    "#step #newton_total #newton_max #fallback_steps #unconverged_steps #waves #waves_started #last_motion_step "
    "worst_residual"
)
"""Since the start; waves: under way; last_motion_step: after which something still moved, -1 if nothing ever did;
worst_residual: the largest one accepted in an unconverged step [N]."""

WAVE = _record("time speed level #kind #serial #origin #ahead #behind")
"""time at which it starts [s], speed [m/s], level: cylinder fraction asked for; serial: counts the
waves as they are started, from 1; origin: vehicle;
ahead, behind: the next vehicle to be reached on either side, -1 / v where none is left."""

LINE_STEP = _record("start value")
"""A value (grade [m/m] or curve resistance [N/N]) that holds from a chainage [m] on."""


class Train(NamedTuple):
    """Everything the kernel works on: m masses, v vehicles."""

    settings: Records  # (1,) SETTINGS
    counters: Records  # (1,) COUNTERS
    masses: Floats  # (N_MASS_ROWS, m)
    connections: Floats  # (N_CONNECTION_ROWS, m - 1)
    vehicles: Floats  # (N_VEHICLE_ROWS, v)
    members: Ints  # (2, m) first vehicle of each mass and the one after its last
    places: Ints  # (3, v) mass of each vehicle; steps of the line that it is on, -1 before the first
    hinges: Floats  # (3, 2, h, m - 1), second index COMPRESSION / TENSION
    waves: Records  # (w,), the first ``counters.waves`` are in use
    grades: Records  # (g,) LINE_STEP
    curves: Records  # (k,) LINE_STEP
