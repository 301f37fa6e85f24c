"""The arrays of the kernel, assembled from the model of a train."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.consist import Consist
from haul_ros.model.draft_gear import DraftGear
from haul_ros.model.initial_state import InitialAir
from haul_ros.model.track import Track
from haul_ros.model.vehicle import VehicleType
from haul_ros.physics.air_assembly import assemble_air, no_air
from haul_ros.physics.hinges import side_hinges
from haul_ros.physics.kernel import data
from haul_ros.physics.kernel.blocks import Blocks, named, row_count
from haul_ros.physics.kernel.resolution import PRELOADED_CONTACT, SLACK_CONTACT, STIFF_CONTACT
from haul_ros.physics.lumping import LumpedTrain
from haul_ros.units import GRAVITY

CURVE_RESISTANCE = 600.0 / 1000.0
"""Resistance of a curve times its radius [m]: 600/R N per kN (TB/T 1407-1998)."""

_NEVER_REACHED = 1e9
"""Stroke [m] of hinges that only fill up the array; finite, for 0 times infinity is not a number."""

_ROOM_FOR_WAVES = 64
"""Brake waves under way at one time, to begin with."""

_PARAMETERS = (
    "settings",
    "mass_index",
    "vehicle_parameters",
    "members",
    "mass_parameters",
    "gear_parameters",
    "hinges",
    "grades",
    "curves",
    "air",
    "air_parameters",
    "driver_valve_parameters",
)
"""Blocks that are parameters."""

Floats = NDArray[np.float64]


def assemble(
    consist: Consist,
    lumped: LumpedTrain,
    brakes: BrakeSystem | PneumaticBrake,
    track: Track,
    *,
    initial_speed: Floats,
    initial_stroke: Floats,
    initial_air: InitialAir | None,
    time_step: float,
    tolerance: float,
) -> Blocks:
    """The memory of a train before its first step.

    ``initial_speed`` [m/s] is one for all or one for each mass (m,), ``initial_stroke`` [m] one for each draft gear
    (m - 1,), ``tolerance`` the force residual [N] at which a step counts as converged.
    """
    n_vehicles, n_masses, n_gears = len(consist.vehicles), len(lumped.mass), len(lumped.gears)
    of_air = assemble_air(consist, brakes, time_step, initial_air) if isinstance(brakes, PneumaticBrake) else no_air()
    blocks = Blocks(
        settings=_settings(lumped, brakes, track, time_step, tolerance),
        counters=np.zeros(1, data.COUNTERS).view(np.recarray),
        waves=np.zeros(_ROOM_FOR_WAVES, data.WAVE).view(np.recarray),
        mass_index=lumped.mass_index,
        vehicle_parameters=_vehicle_parameters(consist),
        vehicles=_zeros("vehicles", n_vehicles),
        members=np.array(data.Members(lumped.first, lumped.end)),
        mass_parameters=np.array(data.MassParameters(lumped.mass)),
        masses=_zeros("masses", n_masses),
        gear_parameters=_gear_parameters(lumped.gears, lumped.mass, time_step),
        hinges=_hinges(lumped.gears),
        gears=_zeros("gears", n_gears),
        grades=_grade_pieces(track),
        curves=_curve_steps(track),
        line_index=np.full((len(data.LineIndex._fields), n_vehicles), -1, dtype=np.int64),
        **of_air._asdict(),
    )
    train = named(blocks)
    train.gears.stroke[:] = initial_stroke
    train.masses.displacement[1:] = np.cumsum(initial_stroke)
    train.masses.velocity[:] = initial_speed
    train.masses.direction[:] = np.sign(initial_speed)
    train.gear_extremes.bottomed_time[:] = np.nan
    train.counters.part[:] = data.PARTS
    train.counters.last_motion_step[:] = 0 if train.masses.direction.any() else -1
    return protected(blocks)


def protected(blocks: Blocks) -> Blocks:
    """The same memory, what nobody may write after assembly made read-only; copies of arrays have lost that."""
    for name in _PARAMETERS:
        getattr(blocks, name).flags.writeable = False
    return blocks


def with_room_for_waves(blocks: Blocks) -> Blocks:
    """The same memory with room for as many brake waves again."""
    more = np.zeros(len(blocks.waves), data.WAVE)
    return blocks._replace(waves=np.concatenate((blocks.waves, more)).view(np.recarray))


def _zeros(block: str, columns: int) -> Floats:
    return np.zeros((row_count(block), columns))


def _rate(fraction: float, time: float) -> float:
    return fraction / time if time > 0.0 else np.inf


def _settings(
    lumped: LumpedTrain, brakes: BrakeSystem | PneumaticBrake, track: Track, time_step: float, tolerance: float
) -> data.Records:
    settings = np.zeros(1, data.SETTINGS).view(np.recarray)
    settings.time_step = time_step
    settings.tolerance = tolerance
    if isinstance(brakes, BrakeSystem):
        build_up = brakes.build_up
        settings.knee = build_up.knee
        settings.rate_to_knee = _rate(build_up.knee, build_up.knee_time)
        settings.rate_from_knee = _rate(1.0 - build_up.knee, build_up.full_time - build_up.knee_time)
        settings.rate_service = _rate(brakes.full_service, build_up.service_time)
        settings.rate_release = _rate(1.0, build_up.release_time)
        settings.friction_follows_pressure = build_up.friction_follows_pressure
    else:
        settings.friction_follows_pressure = True
    settings.start_chainage = track.start_chainage
    settings.has_line = bool(track.grades or track.curves)
    settings.has_stops = any(np.isfinite(gear.maximum_stroke) for gear in lumped.gears)
    settings.has_slack = any(gear.slack > 0.0 for gear in lumped.gears)
    settings.has_drawbars = lumped.rigid.any()
    settings.may_part = any(np.isfinite(gear.strength) for gear in lumped.gears)
    return settings


def _vehicle_parameters(consist: Consist) -> Floats:
    columns = [
        _vehicle(vehicle, offset) for vehicle, offset in zip(consist.vehicles, consist.centre_offsets, strict=True)
    ]
    return np.ascontiguousarray(np.array(columns, dtype=np.float64).T)


def _vehicle(vehicle: VehicleType, centre_offset: float) -> tuple[float, ...]:
    """Numbers of a vehicle in the order of `VehicleParameters`."""
    resistance, friction = vehicle.resistance, vehicle.friction
    weight = vehicle.mass * GRAVITY
    lowest = resistance.minimum_speed
    at_lowest = resistance.constant + (resistance.linear + resistance.quadratic * lowest) * lowest
    numbers: dict[str, float] = {
        "mass": vehicle.mass,
        "weight": weight,
        "centre_offset": centre_offset,
        "resistance_constant": weight * resistance.constant,
        "resistance_linear": weight * resistance.linear,
        "resistance_quadratic": weight * resistance.quadratic,
        "resistance_lowest_speed": lowest,
        "resistance_standing": weight * max(resistance.starting, at_lowest),
        "shoes": vehicle.shoes,
        "shoe_force": vehicle.shoe_force,
        "friction_scale": friction.scale,
        "friction_k_offset": friction.k_offset,
        "friction_k_gain": friction.k_gain,
        "friction_n_slope": friction.n_slope / friction.d_offset,
        "friction_n_offset": friction.n_offset / friction.d_offset,
        "friction_d_slope": friction.d_slope / friction.d_offset,
        "friction_v0_slope": friction.v0_slope,
        "friction_v0_reference": friction.v0_reference,
        "max_power": vehicle.max_power,
        **_efforts(vehicle),
    }
    return tuple(numbers[name] for name in data.VehicleParameters._fields)


def _efforts(vehicle: VehicleType) -> dict[str, float]:
    """Numbers of traction and electric brake by their names in `VehicleParameters`."""
    electric, adhesion = vehicle.electric_brake, vehicle.adhesion
    full = max(vehicle.max_tractive_effort, electric.max_force)
    fall = vehicle.max_tractive_effort - vehicle.continuous_effort
    return {
        "max_effort": vehicle.max_tractive_effort if vehicle.continuous_speed > 0.0 else np.inf,
        "effort_slope": fall / vehicle.continuous_speed if vehicle.continuous_speed > 0.0 else 0.0,
        "effort_speed": vehicle.continuous_speed,
        "max_electric_brake": electric.max_force,
        "electric_power": electric.max_power,
        "electric_fade_speed": electric.fade_speed,
        "electric_in_emergency": float(electric.stays_in_emergency),
        "interlock": float(electric.interlock),
        "adhesion_constant": adhesion.constant if adhesion else np.inf,
        "adhesion_numerator": adhesion.numerator if adhesion else 0.0,
        "adhesion_offset": adhesion.offset if adhesion else 1.0,
        "effort_rate": full / vehicle.effort_rise_time if vehicle.effort_rise_time > 0.0 else np.inf,
        "changeover_time": vehicle.changeover_time,
    }


def _largest_swing(gear: DraftGear, time_step: float) -> float:
    """Swing [rad] of a gear's contacts that a part of a time step [s] may go through."""
    stiff = SLACK_CONTACT if gear.slack > 0.0 else STIFF_CONTACT
    return min(data.LARGEST_SWING, (PRELOADED_CONTACT if gear.preloaded else stiff) * time_step)


def _gear_parameters(gears: Sequence[DraftGear], mass: Floats, time_step: float) -> Floats:
    parameters = data.GearParameters(
        inverse_transition_speed=np.array([1.0 / gear.transition_speed for gear in gears]),
        full_stroke=np.array([gear.maximum_stroke + gear.slack / 2.0 for gear in gears]),
        full_draft_stroke=np.array([gear.maximum_stroke + gear.slack / 2.0 for gear in gears]),
        inverse_reduced_mass=1.0 / mass[:-1] + 1.0 / mass[1:],
        largest_swing=np.array([_largest_swing(gear, time_step) for gear in gears]),
        strength=np.array([gear.strength for gear in gears]),
        hose_reach=np.full(len(gears), np.inf),
    )
    return np.array(parameters, dtype=np.float64)


def _hinges(gears: Sequence[DraftGear]) -> Floats:
    """Hinges (6, h, g) of the curves, padded with hinges that are never reached."""
    by_gear = {gear: (side_hinges(gear, gear.compression), side_hinges(gear, gear.tension)) for gear in set(gears)}
    n_hinges = max((len(side[0]) for sides in by_gear.values() for side in sides), default=1)
    block = np.zeros((len(data.Hinges._fields), n_hinges, len(gears)))
    hinges = data.Hinges(*block)
    compression = (hinges.compression_knot, hinges.compression_mean, hinges.compression_hysteresis)
    tension = (hinges.tension_knot, hinges.tension_mean, hinges.tension_hysteresis)
    hinges.compression_knot[:] = hinges.tension_knot[:] = _NEVER_REACHED
    for k, gear in enumerate(gears):
        for (knot, mean, hysteresis), side in zip((compression, tension), by_gear[gear], strict=True):
            knots, loading, unloading = side
            knot[: len(knots), k] = knots
            mean[: len(knots), k] = (loading + unloading) / 2.0
            hysteresis[: len(knots), k] = (loading - unloading) / 2.0
    return block


def _grade_pieces(track: Track) -> Floats:
    """Grades as pieces: a change is one, or with ramps two, the ramp and what follows it."""
    pieces: list[tuple[float, float, float]] = []
    before, half = 0.0, track.grade_ramp / 2.0
    for chainage, grade in track.grade_changes if half > 0.0 else track.grades:
        if half > 0.0:
            pieces.append((chainage - half, before, (grade - before) / track.grade_ramp))
        pieces.append((chainage + half, grade, 0.0))
        before = grade
    columns = np.array(pieces, dtype=np.float64).reshape(len(pieces), len(data.GradePieces._fields))
    return np.ascontiguousarray(columns.T)


def _curve_steps(track: Track) -> Floats:
    parameters = data.LineSteps(
        start=np.array([start for start, _ in track.curves]),
        value=np.array([CURVE_RESISTANCE * curvature for _, curvature in track.curves]),
    )
    return np.array(parameters, dtype=np.float64)
