"""The train as the kernel sees it: arrays built from the model, advanced step by step."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.consist import Consist
from haul_ros.model.draft_gear import DraftGear
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.track import Track
from haul_ros.physics.hinges import side_hinges
from haul_ros.physics.kernel import arrays as a
from haul_ros.physics.kernel._jit import is_cached
from haul_ros.physics.kernel.advance import advance
from haul_ros.physics.kernel.newmark import LEAST_FRICTION
from haul_ros.units import GRAVITY, seconds_to_ns

CURVE_RESISTANCE = 600.0 / 1000.0
"""Resistance of a curve times its radius [m]: 600/R N per kN (TB/T 1407-1998)."""

NEWTON_TOLERANCE = 1e-3
"""Force residual [N] at which a step counts as converged."""

_NEVER_REACHED = 1e9
"""Stroke [m] of hinges that only fill up the array; finite, for 0 times infinity is not a number."""

_ROOM_FOR_WAVES = 64
"""Brake waves under way at one time, to begin with."""

Floats = NDArray[np.float64]


def kernel_is_cached() -> bool:
    """Whether the compiled kernel is at hand; else the first train made in this process waits some 20 s for it."""
    return is_cached(advance)


class WaveKind(enum.IntEnum):
    """What a brake wave tells the vehicles that it reaches."""

    SERVICE = a.SERVICE
    RELEASE = a.RELEASE
    EMERGENCY = a.EMERGENCY
    EMERGENCY_RELEASE = a.EMERGENCY_RELEASE


@dataclass(frozen=True, slots=True)
class StepStatistics:
    """How the steps went since the start.

    ``fallback_steps`` did not converge whole and were divided; ``unconverged_steps`` is the number
    of smallest parts taken all the same, with at most ``worst_residual`` [N].
    """

    steps: int
    newton_iterations: int
    newton_iterations_max: int
    fallback_steps: int
    unconverged_steps: int
    worst_residual: float

    @property
    def newton_iterations_mean(self) -> float:
        """Newton iterations per step."""
        return self.newton_iterations / max(self.steps, 1)


def _brake_speeds(brakes: BrakeSystem) -> dict[WaveKind, float]:
    return {
        WaveKind.SERVICE: brakes.wave_speeds.service,
        WaveKind.RELEASE: brakes.wave_speeds.release,
        WaveKind.EMERGENCY: brakes.wave_speeds.emergency,
        WaveKind.EMERGENCY_RELEASE: brakes.wave_speeds.release,
    }


def _hinge_array(gears: list[DraftGear]) -> Floats:
    """Hinges (3, 2, h, c) of the curves, padded with hinges that are never reached."""
    by_gear = {
        gear: {a.COMPRESSION: side_hinges(gear, gear.compression), a.TENSION: side_hinges(gear, gear.tension)}
        for gear in set(gears)
    }
    n_hinges = max((len(side[0]) for sides in by_gear.values() for side in sides.values()), default=1)
    hinges = np.zeros((3, 2, n_hinges, len(gears)))
    hinges[a.KNOT] = _NEVER_REACHED
    for c, gear in enumerate(gears):
        for side, (knots, loading, unloading) in by_gear[gear].items():
            hinges[a.KNOT, side, : len(knots), c] = knots
            hinges[a.HINGE_MEAN, side, : len(knots), c] = (loading + unloading) / 2.0
            hinges[a.HINGE_GAP, side, : len(knots), c] = (loading - unloading) / 2.0
    return hinges


def _vehicle_array(consist: Consist) -> Floats:
    rows = np.zeros((a.N_VEHICLE_ROWS, len(consist.vehicles)))
    for i, vehicle in enumerate(consist.vehicles):
        resistance, friction = vehicle.resistance, vehicle.friction
        weight = vehicle.mass * GRAVITY
        lowest = resistance.minimum_speed
        at_lowest = resistance.constant + (resistance.linear + resistance.quadratic * lowest) * lowest
        column = {
            a.VEHICLE_MASS: vehicle.mass,
            a.WEIGHT: weight,
            a.OFFSET: consist.centre_offsets[i],
            a.RESISTANCE_CONSTANT: weight * resistance.constant,
            a.RESISTANCE_LINEAR: weight * resistance.linear,
            a.RESISTANCE_QUADRATIC: weight * resistance.quadratic,
            a.RESISTANCE_LOWEST_SPEED: lowest,
            a.RESISTANCE_STANDING: weight * max(resistance.starting, at_lowest),
            a.SHOES: vehicle.shoes,
            a.SHOE_FORCE: vehicle.shoe_force,
            a.FRICTION_SCALE: friction.scale,
            a.FRICTION_K_OFFSET: friction.k_offset,
            a.FRICTION_K_GAIN: friction.k_gain,
            a.FRICTION_N_SLOPE: friction.n_slope / friction.d_offset,
            a.FRICTION_N_OFFSET: friction.n_offset / friction.d_offset,
            a.FRICTION_D_SLOPE: friction.d_slope / friction.d_offset,
            a.FRICTION_V0_SLOPE: friction.v0_slope,
            a.FRICTION_V0_REFERENCE: friction.v0_reference,
        }
        rows[list(column), i] = list(column.values())
    return rows


def _rate(share: float, time: float) -> float:
    return share / time if time > 0.0 else np.inf


class TrainModel:
    """Longitudinal dynamics of one train.

    Parameters
    ----------
    consist, brakes, track
        The train and its line.
    initial_speed
        Speed at t = 0 [m/s]: one for all, or one for each mass (vehicles joined rigidly are one).
    time_step
        Step of the Newmark method [s].
    """

    def __init__(
        self,
        consist: Consist,
        brakes: BrakeSystem,
        track: Track | None = None,
        *,
        initial_speed: ArrayLike,
        time_step: float = 1e-3,
        tolerance: float = NEWTON_TOLERANCE,
    ) -> None:
        self.consist = consist
        self._wave_speeds = _brake_speeds(brakes)
        self._rigid = np.array([gear is None for gear in consist.couplers], dtype=bool)
        self._cylinder_pressure = np.array([v.cylinder_pressure for v in consist.vehicles])
        speeds = np.asarray(initial_speed, dtype=np.float64)
        self._train = self._build(consist, brakes, track or Track(), speeds, time_step, tolerance)
        advance(self._train, 0)
        self.gears = [gear for gear in consist.couplers if gear is not None]
        self.initial_kinetic_energy = self.kinetic_energy

    @staticmethod
    def _build(
        consist: Consist, brakes: BrakeSystem, track: Track, initial_speed: Floats, time_step: float, tolerance: float
    ) -> a.Train:
        flexible = [j for j, gear in enumerate(consist.couplers) if gear is not None]
        gears = [gear for gear in consist.couplers if gear is not None]
        bounds = [0, *(j + 1 for j in flexible), len(consist.vehicles)]

        settings = np.zeros(1, a.SETTINGS)
        build_up = brakes.build_up
        settings["time_step"] = time_step
        settings["tolerance"] = tolerance
        settings["knee"] = build_up.knee
        settings["rate_to_knee"] = _rate(build_up.knee, build_up.knee_time)
        settings["rate_from_knee"] = _rate(1.0 - build_up.knee, build_up.full_time - build_up.knee_time)
        settings["rate_service"] = _rate(brakes.full_service, build_up.service_time)
        settings["rate_release"] = _rate(1.0, build_up.release_time)
        settings["friction_follows_pressure"] = build_up.friction_follows_pressure
        settings["start_chainage"] = track.start_chainage
        settings["has_line"] = bool(track.grades or track.curves)
        settings["has_stops"] = any(np.isfinite(gear.maximum_stroke) for gear in gears)
        settings["has_drawbars"] = len(gears) < len(consist.couplers)

        vehicles = _vehicle_array(consist)
        members = np.array([bounds[:-1], bounds[1:]], dtype=np.int64)
        masses = np.zeros((a.N_MASS_ROWS, len(bounds) - 1))
        masses[a.MASS] = np.add.reduceat(vehicles[a.VEHICLE_MASS], bounds[:-1])
        masses[a.VELOCITY] = initial_speed
        masses[a.DIRECTION] = np.sign(initial_speed)
        counters = np.zeros(1, a.COUNTERS)
        counters["last_motion_step"] = 0 if masses[a.DIRECTION].any() else -1
        places = np.full((3, len(consist.vehicles)), -1, dtype=np.int64)
        places[a.MASS_INDEX] = np.repeat(np.arange(masses.shape[1]), np.diff(bounds))

        connections = np.zeros((a.N_CONNECTION_ROWS, len(gears)))
        connections[a.INVERSE_TRANSITION_SPEED] = [1.0 / gear.transition_speed for gear in gears]
        connections[a.FULL_STROKE] = [gear.maximum_stroke + gear.slack / 2.0 for gear in gears]
        connections[a.BOTTOMED_TIME] = np.nan

        return a.Train(
            settings=settings,
            counters=counters,
            masses=masses,
            connections=connections,
            vehicles=vehicles,
            members=members,
            places=places,
            hinges=_hinge_array(gears),
            waves=np.zeros(_ROOM_FOR_WAVES, a.WAVE),
            grades=np.array(list(track.grades), a.LINE_STEP),
            curves=np.array([(at, CURVE_RESISTANCE * k) for at, k in track.curves], a.LINE_STEP),
        )

    # -- running ---------------------------------------------------------------------------------

    def advance(self, n_steps: int) -> None:
        """Advance by ``n_steps`` time steps. Releases the GIL."""
        advance(self._train, n_steps)

    @property
    def step(self) -> int:
        """Time steps done."""
        return int(self._train.counters["step"][0])

    @property
    def time_step(self) -> float:
        """Step of the Newmark method [s]."""
        return float(self._train.settings["time_step"][0])

    @property
    def time(self) -> float:
        """Simulation time [s], counted in steps."""
        return self.step * self.time_step

    def start_wave(self, time: float, vehicle: int, kind: WaveKind, level: float = 0.0) -> None:
        """Let a brake wave start at a vehicle at a time [s], not before the present one.

        Waves are to be started in the order of their times: where two meet, the one started later prevails.

        ``level`` is the cylinder pressure that a service application or a release asks for, as a
        fraction of emergency pressure.
        """
        n = int(self._train.counters["waves"][0])
        if n == len(self._train.waves):
            more = np.concatenate((self._train.waves, np.zeros(n, a.WAVE)))
            self._train = self._train._replace(waves=more)
        serial = self._train.counters["waves_started"][0] + 1
        self._train.waves[n] = (time, self._wave_speeds[kind], level, kind, serial, vehicle, vehicle, vehicle + 1)
        self._train.counters["waves_started"] = serial
        self._train.counters["waves"] = n + 1

    def set_traction(self, vehicle: int, force: float) -> None:
        """Set the tractive effort [N] of a vehicle from the present time on."""
        masses, vehicles = self._train.masses, self._train.vehicles
        m = self._train.places[a.MASS_INDEX, vehicle]
        change = force - vehicles[a.TRACTION, vehicle]
        if change == 0.0:
            return
        vehicles[[a.TRACTION, a.NEW_TRACTION], vehicle] = force
        self._train.settings["has_traction"] = True
        # The force jumps at this instant: the next step starts from what holds after the jump.
        masses[a.PUSH, m] += change
        if masses[a.DIRECTION, m] != 0:
            masses[a.ACCELERATION, m] += change / masses[a.MASS, m]
        else:
            members = slice(*self._train.members[:, m])
            # Held by a share of its friction; what is more than all of it sets the mass in motion.
            friction = masses[a.FRICTION, m]
            share = float(np.clip(masses[a.PUSH, m] / max(friction, LEAST_FRICTION), -1.0, 1.0))
            if abs(masses[a.PUSH, m]) > friction:
                masses[a.ACCELERATION, m] = (masses[a.PUSH, m] - share * friction) / masses[a.MASS, m]
            vehicles[a.BRAKE_FORCE, members] = share * vehicles[a.NEW_BRAKE, members]
            vehicles[a.RESISTANCE_FORCE, members] = share * vehicles[a.NEW_RESISTANCE, members]

    # -- looking ---------------------------------------------------------------------------------

    @property
    def at_standstill(self) -> bool:
        """Every vehicle stands, held by friction."""
        return not self._train.masses[a.DIRECTION].any()

    @property
    def brakes_settled(self) -> bool:
        """No brake wave is under way and no brake cylinder filling or emptying."""
        return self._train.counters["waves"][0] == 0 and not self._train.vehicles[a.FILLING].any()

    def in_emergency(self, vehicle: int) -> bool:
        """An emergency wave has reached a vehicle, and none that ends it."""
        return bool(self._train.vehicles[a.LATCHED, vehicle])

    @property
    def stop_time(self) -> float:
        """When the last vehicle came to rest [s], to a time step; 0 if none moved. For a standing train."""
        return float(self._train.counters["last_motion_step"][0] + 1) * self.time_step

    @property
    def speed(self) -> Floats:
        """Speed of every vehicle (n_vehicles,) [m/s]; a copy."""
        return self._by_vehicle(a.VELOCITY)

    @property
    def displacement(self) -> Floats:
        """Way of every vehicle since the start (n_vehicles,) [m]; a copy."""
        return self._by_vehicle(a.DISPLACEMENT)

    @property
    def acceleration(self) -> Floats:
        """Acceleration of every vehicle (n_vehicles,) [m/s^2]; a copy."""
        return self._by_vehicle(a.ACCELERATION)

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy of the whole train [J]."""
        masses = self._train.masses
        return float(np.sum(0.5 * masses[a.MASS] * masses[a.VELOCITY] ** 2))

    def brake_target(self, vehicle: int) -> float:
        """What the brake of a vehicle was last told to reach, as a fraction of emergency pressure."""
        return float(self._train.vehicles[a.TARGET, vehicle])

    @property
    def brake_targets(self) -> Floats:
        """`brake_target` of every vehicle (n_vehicles,); a copy."""
        return np.array(self._train.vehicles[a.TARGET])

    @property
    def bottomed_times(self) -> Floats:
        """When each gear first closed fully (n_couplers,) [s], NaN: never; a copy."""
        bottomed = np.full(len(self._rigid), np.nan)
        bottomed[~self._rigid] = self._train.connections[a.BOTTOMED_TIME]
        return bottomed

    @property
    def train(self) -> a.Train:
        """The arrays that the kernel works on, for energy balance and tests; not to be written."""
        return self._train

    def _by_vehicle(self, row: int) -> Floats:
        return np.asarray(self._train.masses[row, self._train.places[a.MASS_INDEX]])

    def _by_coupler(self, flexible: int, rigid: int | None = None) -> Floats:
        values = np.zeros(len(self._rigid))
        values[~self._rigid] = self._train.connections[flexible]
        if rigid is not None:
            values[self._rigid] = self._train.vehicles[rigid, :-1][self._rigid]
        return values

    def sample(self) -> Sample:
        """The present state, as published and recorded."""
        vehicles = self._train.vehicles
        start = self._train.settings["start_chainage"][0]
        return Sample(
            step=self.step,
            time_ns=seconds_to_ns(self.time),
            stroke=self._by_coupler(a.STROKE),
            stroke_rate=self._by_coupler(a.STROKE_RATE),
            coupler_force=self._by_coupler(a.FORCE, a.BAR_FORCE),
            chainage=start - vehicles[a.OFFSET] + self.displacement,
            speed=self.speed,
            brake_force=vehicles[a.BRAKE_FORCE].copy(),
            cylinder_pressure=vehicles[a.FRACTION] * self._cylinder_pressure,
        )

    def extremes(self) -> CouplerExtremes:
        """Largest coupler forces and strokes since the start."""
        return CouplerExtremes(
            compression=self._by_coupler(a.MAX_COMPRESSION, a.BAR_COMPRESSION),
            compression_time=self._by_coupler(a.MAX_COMPRESSION_TIME, a.BAR_COMPRESSION_TIME),
            tension=self._by_coupler(a.MAX_TENSION, a.BAR_TENSION),
            tension_time=self._by_coupler(a.MAX_TENSION_TIME, a.BAR_TENSION_TIME),
            compression_stroke=self._by_coupler(a.MAX_COMPRESSION_STROKE),
            tension_stroke=self._by_coupler(a.MAX_TENSION_STROKE),
            bottomed_time=self.bottomed_times,
        )

    def statistics(self) -> StepStatistics:
        """How the steps went since the start."""
        counters = self._train.counters[0]
        return StepStatistics(
            steps=int(counters["step"]),
            newton_iterations=int(counters["newton_total"]),
            newton_iterations_max=int(counters["newton_max"]),
            fallback_steps=int(counters["fallback_steps"]),
            unconverged_steps=int(counters["unconverged_steps"]),
            worst_residual=float(counters["worst_residual"]),
        )
