"""Data of the kernel, in SI units: named arrays of one number per vehicle, mass or draft gear.

A *mass* is one vehicle, or several joined by rigid drawbars; a *gear* is the draft gear of the coupler between mass
``k`` and mass ``k + 1``. Without rigid drawbars masses are vehicles and gears are couplers. v vehicles, m masses.

Who may write what: ``*Parameters`` and `Settings` nobody after assembly (the arrays are read-only, which the compiler
checks); ``*State`` what belongs to the present instant, carried from step to step; ``*Trial`` what Newton's method
tries for the end of the step, to be overwritten by the next; ``*Extremes`` the largest so far.

Each quantity lies in one piece in memory and loops do one thing at a time, so the compiler works on several vehicles
at once; a loop that stores to many arrays would stop it from doing so. How they lie in memory: `blocks`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Records = Any
"""Structured array, (n,) np.recarray."""
Record = Any
"""One element of it: fields are attributes."""

# Kinds of brake wave.
SERVICE, RELEASE, EMERGENCY, EMERGENCY_RELEASE = 0, 1, 2, 3

PARTS = 256
"""A time step that is too long for what happens in it is done in parts, of down to this fraction of it."""

LARGEST_SWING = 0.3
"""Of two masses in contact in a part [rad]; chosen as `resolution.STIFF_CONTACT` is. Here, for the check of a scenario
reads it, and is not to load the compiler."""


class VehicleParameters(NamedTuple):
    """Data of every vehicle (v,)."""

    mass: Floats
    """[kg]"""
    weight: Floats
    """[N]"""
    centre_offset: Floats
    """Distance of the centre behind the head of the train, couplers free [m]."""
    resistance_constant: Floats
    """Running resistance at no speed [N]."""
    resistance_linear: Floats
    """[N s/m]"""
    resistance_quadratic: Floats
    """[N s^2/m^2]"""
    resistance_lowest_speed: Floats
    """Below it the resistance at this speed holds [m/s]."""
    resistance_standing: Floats
    """To be overcome at a start [N]."""
    shoes: Floats
    """Number of brake shoes [-]."""
    shoe_force: Floats
    """On each shoe in a fully developed emergency application [N]."""
    friction_scale: Floats
    """Of the friction coefficient [-], as the next seven: see `haul_ros.model.vehicle.ShoeFriction`."""
    friction_k_offset: Floats
    """[N]"""
    friction_k_gain: Floats
    """[-]"""
    friction_n_slope: Floats
    """Over d_offset [s/m]: the speed factor is (n_slope v + n_offset) / (d_slope v + 1)."""
    friction_n_offset: Floats
    """Over d_offset [-]."""
    friction_d_slope: Floats
    """Over d_offset [s/m]."""
    friction_v0_slope: Floats
    """[s/m]"""
    friction_v0_reference: Floats
    """[m/s]"""
    max_power: Floats
    """Of traction; infinite: no limit [W]."""
    max_effort: Floats
    """Tractive effort at rest; infinite: as commanded [N]."""
    effort_slope: Floats
    """By which this falls with the speed, up to ``effort_speed`` [N s/m]."""
    effort_speed: Floats
    """Speed from which the tractive effort does not fall but for its power [m/s]."""
    max_electric_brake: Floats
    """Force of the electric brake [N]."""
    electric_power: Floats
    """Power of the electric brake [W]."""
    electric_fade_speed: Floats
    """Speed below which the electric brake fades, to nothing at rest [m/s]."""
    electric_in_emergency: Floats
    """1: an emergency leaves the electric brake on [-]."""
    interlock: Floats
    """1: the electric brake holds the vehicle's own air brake off, but in an emergency [-]."""
    adhesion_constant: Floats
    """Adhesion coefficient, constant + numerator / (offset + v); infinite: no limit [-]."""
    adhesion_numerator: Floats
    """[m/s]"""
    adhesion_offset: Floats
    """[m/s]"""
    effort_rate: Floats
    """At which the effort follows what is asked for; infinite: at once [N/s]."""
    changeover_time: Floats
    """At least between traction and electric brake [s]."""


class VehicleState(NamedTuple):
    """Outer forces on every vehicle (v,) at the present time, and their works since the start."""

    traction: Floats
    """Tractive effort or electric brake, forward positive [N]."""
    effort_asked: Floats
    """What the driver asks for: tractive effort, or negative electric brake [N]."""
    traction_demand: Floats
    """As far as this has been followed, from the present instant, or the end of the step, on [N]."""
    traction_in_force: Floats
    """The demand that ``traction`` comes from [N]."""
    changeover_left: Floats
    """Until traction may follow on electric braking, or the other way round [s]."""
    effort_sense: Floats
    """1 after traction, -1 after electric braking, 0 before either [-]."""
    link_down: Floats
    """1 for a locomotive whose radio link is down [-]."""
    gravity: Floats
    """Along the line, forward positive [N]."""
    brake_force: Floats
    """Against forward motion positive [N]."""
    resistance_force: Floats
    """Running and curve resistance, against forward motion positive [N]."""
    brake_work: Floats
    """Taken from the train [J]."""
    resistance_work: Floats
    """Taken from the train [J]."""
    gravity_work: Floats
    """Given to the train [J]."""
    traction_work: Floats
    """Given to the train [J]."""
    electric_work: Floats
    """Taken from the train by the electric brake [J]."""


class BrakeState(NamedTuple):
    """Brake cylinder and valve of every vehicle (v,). Brake force = gain * speed factor + offset."""

    fraction: Floats
    """Cylinder pressure over emergency pressure [-]."""
    target: Floats
    """The fraction that the brake pipe last asked for [-]."""
    fraction_time: Floats
    """The instant that ``fraction`` belongs to [s]."""
    initial_speed: Floats
    """When this application began [m/s]."""
    latched: Floats
    """1 in emergency [-]."""
    latched_by: Floats
    """Serial number of the newest wave that did so [-]."""
    unlatched_by: Floats
    """The same [-]."""
    applied_by: Floats
    """The same [-]."""
    released_by: Floats
    """The same [-]."""
    filling: Floats
    """1 while gain and offset may differ at the start and the end of the step [-]."""
    gain: Floats
    """In force in this step or part of a step [N]."""
    offset: Floats
    """In force in this step or part of a step [N]."""
    gain_start: Floats
    """At the start of the time step [N]."""
    offset_start: Floats
    """At the start of the time step [N]."""
    gain_end: Floats
    """At the end of the time step [N]."""
    offset_end: Floats
    """At the end of the time step [N]."""


class VehicleTrial(NamedTuple):
    """Trial values of every vehicle (v,) for the end of the step."""

    traction: Floats
    """Tractive effort or electric brake [N]."""
    traction_demand: Floats
    """What it comes from [N]."""
    gravity: Floats
    """[N]"""
    curve_drag: Floats
    """Curve resistance, a magnitude [N]."""
    sliding_speed: Floats
    """Speed in the direction of motion [m/s]; -1 at a standstill."""
    brake_force: Floats
    """What the brake gives while sliding, or can give while standing [N]."""
    resistance_force: Floats
    """What the resistance gives while sliding, or can give while standing [N]."""
    friction_slope: Floats
    """Slope of both by speed [N s/m]."""
    mobilised: Floats
    """Part of this friction that acts, -1 .. 1: the direction while sliding [-]."""
    displacement_change: Floats
    """In the step [m]."""


class DrawbarState(NamedTuple):
    """Rigid drawbar behind every vehicle (v,), where there is one."""

    force: Floats
    """Compression positive [N]."""


class DrawbarExtremes(NamedTuple):
    """Largest forces in the rigid drawbar behind every vehicle (v,), as magnitudes, and when."""

    compression: Floats
    """[N]"""
    compression_time: Floats
    """[s]"""
    tension: Floats
    """[N]"""
    tension_time: Floats
    """[s]"""


class MassParameters(NamedTuple):
    """Data of every mass (m,)."""

    mass: Floats
    """[kg]"""


class MassState(NamedTuple):
    """Motion of every mass (m,) at the present time, forward positive."""

    displacement: Floats
    """From where it stands at the start in a train of free couplers [m]."""
    velocity: Floats
    """[m/s]"""
    acceleration: Floats
    """[m/s^2]"""
    direction: Floats
    """1 forward, -1 backward, 0 standing, held by friction [-]."""
    applied_force: Floats
    """All forces but friction [N]."""
    external_force: Floats
    """Traction and gravity [N]."""
    friction_force: Floats
    """Of brakes and resistance, against forward motion positive [N]."""


class MassTrial(NamedTuple):
    """Trial values of every mass (m,) for the end of the step, and the equations that mend them."""

    velocity: Floats
    """[m/s]"""
    direction: Floats
    """As in `MassState` [-]."""
    applied_force: Floats
    """All forces but friction, mean over the step [N]."""
    external_force: Floats
    """Traction and gravity [N]."""
    friction: Floats
    """Brakes and resistance: what acts while sliding, or is there at most while standing; a magnitude [N]."""
    friction_slope: Floats
    """By speed [N s/m]."""
    sliding_speed: Floats
    """In the direction of motion [m/s]; -1 at a standstill."""
    mobilised: Floats
    """Part of the friction that acts, -1 .. 1: the direction while sliding [-]."""
    displacement_change: Floats
    """In the step [m]."""
    diagonal: Floats
    """Of the tangent [N s/m]."""
    off_diagonal: Floats
    """Of the tangent, between this mass and the next [N s/m]."""
    residual: Floats
    """Force out of balance; then Newton's correction of the velocity [N], [m/s]."""


class GearParameters(NamedTuple):
    """Data of every draft gear (m - 1,)."""

    inverse_transition_speed: Floats
    """1/Ve [s/m]."""
    full_stroke: Floats
    """In buff, at which the gear is closed, slack included [m]."""
    full_draft_stroke: Floats
    """The same in draft; infinite once the coupler is parted [m]."""
    inverse_reduced_mass: Floats
    """1/m1 + 1/m2 of the masses that it joins [1/kg]."""
    largest_swing: Floats
    """Of its masses in contact, in a part of a time step, see `haul_ros.physics.kernel.resolution` [rad]."""
    strength: Floats
    """Tension at which the coupler breaks; infinite: never, or it is parted already [N]."""
    hose_reach: Floats
    """Gap of a parted coupler at which the hose parts; infinite: it is not parted, or the hose is already [m]."""


class Hinges(NamedTuple):
    """Curves of every draft gear (h, m - 1): sums of slope * max(0, |stroke| - knot), see `haul_ros.physics.hinges`."""

    compression_knot: Floats
    """[m]"""
    tension_knot: Floats
    """[m]"""
    compression_mean: Floats
    """Slope change of the mean of loading and unloading curve, (fu + fl)/2 [N/m]."""
    tension_mean: Floats
    """The same [N/m]."""
    compression_hysteresis: Floats
    """Slope change of half their difference, (fu - fl)/2 [N/m]."""
    tension_hysteresis: Floats
    """The same [N/m]."""


class GearState(NamedTuple):
    """Every draft gear (m - 1,) at the present time, compression positive."""

    stroke: Floats
    """[m]"""
    stroke_rate: Floats
    """[m/s]"""
    force: Floats
    """[N]"""
    dissipated: Floats
    """By the hysteresis since the start [J]."""
    taken: Floats
    """Work done on it since the start by the force that acts on the masses [J]."""
    given: Floats
    """Work done by it since the start [J]."""


class GearTrial(NamedTuple):
    """Trial values of every draft gear (m - 1,) for the end of the step, or as means over the way of the step."""

    stroke: Floats
    """At the end [m]."""
    stroke_rate: Floats
    """At the end [m/s]."""
    force: Floats
    """At the end [N]."""
    step_force: Floats
    """Mean over the step [N]."""
    stiffness: Floats
    """Of this mean, by the stroke at the end [N/m]."""
    tangent: Floats
    """Of this mean, by the stroke rate at the end [N s/m]."""
    low: Floats
    """Smallest magnitude of the stroke on the way [m]."""
    high: Floats
    """Largest magnitude of the stroke on the way [m]."""
    per_span: Floats
    """1 / (high - low), 0 where the stroke stands still [1/m]."""
    share: Floats
    """Part of the way past a knot [-]."""
    lever: Floats
    """How far past the knot the middle of that part lies [m]."""
    mean: Floats
    """(fu + fl)/2, mean over the way [N]."""
    mean_slope: Floats
    """By the magnitude of the stroke at the end [N/m]."""
    hysteresis: Floats
    """(fu - fl)/2, mean over the way [N]."""
    hysteresis_slope: Floats
    """By the magnitude of the stroke at the end [N/m]."""
    transition: Floats
    """w/Ve limited to -1 .. 1, mean between the stroke rates at start and end [-]."""
    transition_slope: Floats
    """By the stroke rate at the end [s/m]."""
    end_mean: Floats
    """(fu + fl)/2 at the end [N]."""
    end_hysteresis: Floats
    """(fu - fl)/2 at the end [N]."""


class GearExtremes(NamedTuple):
    """Largest of every draft gear (m - 1,) at the ends of the steps so far, as magnitudes, and when."""

    compression: Floats
    """[N]"""
    compression_time: Floats
    """[s]"""
    tension: Floats
    """[N]"""
    tension_time: Floats
    """[s]"""
    compression_stroke: Floats
    """[m]"""
    tension_stroke: Floats
    """[m]"""
    bottomed_time: Floats
    """When the gear first closed fully [s]; NaN: never."""


class Members(NamedTuple):
    """Vehicles of every mass (m,)."""

    first: Ints
    """Index of the first [-]."""
    end: Ints
    """Index after the last [-]."""


class GradePieces(NamedTuple):
    """Grade along the line, linear from a chainage on to the next (g,)."""

    start: Floats
    """Chainage [m]."""
    value: Floats
    """There [m/m]."""
    slope: Floats
    """Change by chainage, in the ramp between two grades [1/m]."""


class LineSteps(NamedTuple):
    """Values that hold along the line from a chainage on to the next (c,)."""

    start: Floats
    """Chainage [m]."""
    value: Floats
    """Curve resistance [N/N]."""


class LineIndex(NamedTuple):
    """Where every vehicle (v,) was found last among the pieces of the line; -1 before the first."""

    grade: Ints
    """[-]"""
    curve: Ints
    """[-]"""


def record_type(fields: str) -> np.dtype[Any]:
    """Structured type of 8-byte fields, named in a text: real numbers, or integers if marked ``#``."""
    kinds = [(name.lstrip("#"), "i8" if name.startswith("#") else "f8") for name in fields.split()]
    return np.dtype(kinds, align=True)


SETTINGS = record_type("""
    time_step tolerance start_chainage #has_line #has_stops #has_drawbars #has_slack #may_part
    knee rate_to_knee rate_from_knee rate_service rate_release #friction_follows_pressure
""")
"""time_step [s]; tolerance: force residual at which a step is converged [N]; start_chainage: of the
head at t = 0 [m]; may_part: 1 if a coupler may break, or the hose of a parted one part; knee: fraction of emergency
pressure; rates: such fractions per second [1/s]."""

COUNTERS = record_type(
    "#step #newton_total #newton_max #fallback_steps #unconverged_steps #waves #waves_started #last_motion_step "
    "#has_traction #balanced #divided_steps #part worst_residual"
)
"""Since the start; waves: under way; last_motion_step: after which something still moved, -1 if nothing ever did;
has_traction: 1 once there was any; balanced: 1 once the initial state is in balance; divided_steps: done in parts
because of a stiff contact; part: what is tried next of the time step, in 256ths; worst_residual: the largest one
accepted in an unconverged step [N]."""

WAVE = record_type("time speed level #kind #serial #origin #ahead #behind #first #last")
"""time at which it starts [s], speed [m/s], level: cylinder fraction asked for; serial: counts the
waves as they are started, from 1; origin: vehicle;
ahead, behind: the next vehicle to be reached on either side; first, last: the vehicles that it can reach at all, for
it does not pass a parted hose."""
