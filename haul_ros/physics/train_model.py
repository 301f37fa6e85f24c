"""The train as the kernel sees it: arrays built from the model, advanced step by step."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.consist import Consist
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.track import Track
from haul_ros.physics.assembly import assemble, protected, with_room_for_waves
from haul_ros.physics.kernel import data
from haul_ros.physics.kernel._jit import is_cached
from haul_ros.physics.kernel.advance import advance
from haul_ros.physics.kernel.blocks import Blocks, Train, named
from haul_ros.physics.lumping import lump
from haul_ros.units import seconds_to_ns

NEWTON_TOLERANCE = 1e-3
"""Force residual [N] at which a step counts as converged."""

Floats = NDArray[np.float64]


def kernel_is_cached() -> bool:
    """Whether the compiled kernel is at hand; else the first train made in this process waits some 20 s for it."""
    return is_cached(advance)


class WaveKind(enum.IntEnum):
    """What a brake wave asks of the vehicles that it reaches."""

    SERVICE = data.SERVICE
    RELEASE = data.RELEASE
    EMERGENCY = data.EMERGENCY
    EMERGENCY_RELEASE = data.EMERGENCY_RELEASE


@dataclass(frozen=True, slots=True)
class StepStatistics:
    """How the steps went since the start.

    ``divided_steps`` were done in parts because they met stiff contacts of draft gears; ``fallback_steps`` did not
    converge whole and were divided; ``unconverged_steps`` is the number
    of smallest parts taken all the same, with at most ``worst_residual`` [N].
    """

    steps: int
    newton_iterations: int
    newton_iterations_max: int
    divided_steps: int
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
    ) -> None:
        self.consist = consist
        self._wave_speeds = _brake_speeds(brakes)
        self._time_step = time_step
        self._start_chainage = (track or Track()).start_chainage
        self._cylinder_pressure = np.array([v.cylinder_pressure for v in consist.vehicles])
        lumped = lump(consist)
        self._rigid = lumped.rigid
        self.gears = lumped.gears
        """The draft gears, in the order of the couplers that have one."""
        self._use(
            assemble(
                consist,
                lumped,
                brakes,
                track or Track(),
                initial_speed=np.asarray(initial_speed, dtype=np.float64),
                time_step=time_step,
                tolerance=NEWTON_TOLERANCE,
            )
        )
        advance(self._blocks, 0)
        self.initial_kinetic_energy = self.kinetic_energy

    def _use(self, blocks: Blocks) -> None:
        self._blocks = blocks
        self._train = named(blocks)
        self._step = self._train.counters.step

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in ("_train", "_step")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        # A copy: the names have to be views of its own memory.
        self.__dict__.update(state)
        self._use(protected(self._blocks))

    # -- running ---------------------------------------------------------------------------------

    def advance(self, n_steps: int) -> None:
        """Advance by ``n_steps`` time steps. Releases the GIL."""
        advance(self._blocks, n_steps)

    @property
    def step(self) -> int:
        """Time steps done."""
        return int(self._step[0])

    @property
    def time_step(self) -> float:
        """Step of the Newmark method [s]."""
        return self._time_step

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
        counters = self._train.counters[0]
        n = int(counters.waves)
        if n == len(self._train.waves):
            n = self._drop_spent_waves()
        if n == len(self._train.waves):
            self._use(with_room_for_waves(self._blocks))
        serial = counters.waves_started + 1
        self._train.waves[n] = (time, self._wave_speeds[kind], level, kind, serial, vehicle, vehicle, vehicle + 1)
        counters.waves_started = serial
        counters.waves = n + 1

    @property
    def waves_under_way(self) -> int:
        """Brake waves that have not left the train."""
        return int(self._train.counters[0].waves)

    def _drop_spent_waves(self) -> int:
        """Remove waves that have nothing to say any more to the vehicles still before them; how many are left."""
        brakes, counters = self._train.brakes, self._train.counters[0]
        waves = self._train.waves[: int(counters.waves)]
        ends = waves.serial[waves.kind == WaveKind.EMERGENCY_RELEASE]
        overruled_by = {
            WaveKind.EMERGENCY: brakes.unlatched_by,
            WaveKind.EMERGENCY_RELEASE: brakes.latched_by,
            WaveKind.SERVICE: np.maximum(brakes.released_by, brakes.unlatched_by),
            WaveKind.RELEASE: brakes.applied_by,
        }
        kept = []
        for n, wave in enumerate(waves):
            spent = wave.serial <= overruled_by[WaveKind(int(wave.kind))]
            if wave.kind == WaveKind.SERVICE and not (ends < wave.serial).any():
                spent |= brakes.latched == 1.0  # and only ends of the emergency that overrule this wave can come
            if not (spent[: int(wave.ahead) + 1].all() and spent[int(wave.behind) :].all()):
                kept.append(n)
        waves[: len(kept)] = waves[kept]
        counters.waves = len(kept)
        return len(kept)

    def set_traction(self, vehicle: int, force: float) -> None:
        """Set the tractive effort [N] of a vehicle from the present time on; its power may give less."""
        self._train.vehicles.traction_demand[vehicle] = force
        advance(self._blocks, 0)

    def set_radio_link(self, vehicle: int, connected: bool) -> None:
        """Say whether the radio link to a locomotive is up; while it is down, a brake wave ends its traction.

        If its brake is applied when the link goes down, traction ends then.
        """
        self._train.vehicles.link_down[vehicle] = 0.0 if connected else 1.0
        if self.stopped_by_pipe(vehicle):
            self.set_traction(vehicle, 0.0)

    def stopped_by_pipe(self, vehicle: int) -> bool:
        """Whether the brake pipe alone keeps a locomotive from pulling: its link is down, and a brake is applied."""
        return bool(self._train.vehicles.link_down[vehicle] != 0.0) and self.brake_target(vehicle) > 0.0

    # -- observing ---------------------------------------------------------------------------------

    @property
    def at_standstill(self) -> bool:
        """Every vehicle stands, held by friction."""
        return not self._train.masses.direction.any()

    @property
    def brakes_settled(self) -> bool:
        """No brake wave is under way and no brake cylinder filling or emptying."""
        return self._train.counters[0].waves == 0 and not self._train.brakes.filling.any()

    def in_emergency(self, vehicle: int) -> bool:
        """An emergency wave has reached a vehicle, and none that ends it."""
        return bool(self._train.brakes.latched[vehicle])

    @property
    def stop_time(self) -> float:
        """When the last vehicle came to rest [s], to a time step; 0 if none moved. For a standing train."""
        return float(self._train.counters[0].last_motion_step + 1) * self.time_step

    @property
    def speed(self) -> Floats:
        """Speed of every vehicle (n_vehicles,) [m/s]; a copy."""
        return self._train.masses.velocity[self._train.mass_index]

    @property
    def displacement(self) -> Floats:
        """Travelled distance of every vehicle since the start (n_vehicles,) [m]; a copy."""
        return self._train.masses.displacement[self._train.mass_index]

    @property
    def acceleration(self) -> Floats:
        """Acceleration of every vehicle (n_vehicles,) [m/s^2]; a copy."""
        return self._train.masses.acceleration[self._train.mass_index]

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy of the whole train [J]."""
        return float(np.sum(0.5 * self._train.mass_parameters.mass * self._train.masses.velocity**2))

    def brake_target(self, vehicle: int) -> float:
        """What the brake pipe last asked of the brake of a vehicle, as a fraction of emergency pressure."""
        return float(self._train.brakes.target[vehicle])

    @property
    def brake_targets(self) -> Floats:
        """`brake_target` of every vehicle (n_vehicles,); a copy."""
        return self._train.brakes.target.copy()

    @property
    def bottomed_times(self) -> Floats:
        """When each gear first closed fully (n_couplers,) [s], NaN: never; a copy."""
        bottomed = np.full(len(self._rigid), np.nan)
        bottomed[~self._rigid] = self._train.gear_extremes.bottomed_time
        return bottomed

    @property
    def train(self) -> Train:
        """The arrays that the kernel works on, for energy balance and tests; not to be written."""
        return self._train

    def _by_coupler(self, of_gears: Floats, of_drawbars: Floats | None = None) -> Floats:
        """Values of the draft gears and of the drawbars in one array (n_couplers,); without values of these 0."""
        values = np.zeros(len(self._rigid))
        values[~self._rigid] = of_gears
        if of_drawbars is not None:
            values[self._rigid] = of_drawbars[:-1][self._rigid]
        return values

    def sample(self) -> Sample:
        """The present state, as published and recorded."""
        train, gears = self._train, self._train.gears
        free_chainage = self._start_chainage - train.vehicle_parameters.centre_offset
        return Sample(
            step=self.step,
            time_ns=seconds_to_ns(self.time),
            stroke=self._by_coupler(gears.stroke),
            stroke_rate=self._by_coupler(gears.stroke_rate),
            coupler_force=self._by_coupler(gears.force, train.drawbars.force),
            chainage=free_chainage + self.displacement,
            speed=self.speed,
            brake_force=train.vehicles.brake_force.copy(),
            cylinder_pressure=train.brakes.fraction * self._cylinder_pressure,
        )

    def extremes(self) -> CouplerExtremes:
        """Largest coupler forces and strokes since the start."""
        gears, drawbars = self._train.gear_extremes, self._train.drawbar_extremes
        return CouplerExtremes(
            compression=self._by_coupler(gears.compression, drawbars.compression),
            compression_time=self._by_coupler(gears.compression_time, drawbars.compression_time),
            tension=self._by_coupler(gears.tension, drawbars.tension),
            tension_time=self._by_coupler(gears.tension_time, drawbars.tension_time),
            compression_stroke=self._by_coupler(gears.compression_stroke),
            tension_stroke=self._by_coupler(gears.tension_stroke),
            bottomed_time=self.bottomed_times,
        )

    def statistics(self) -> StepStatistics:
        """How the steps went since the start."""
        counters = self._train.counters[0]
        return StepStatistics(
            steps=int(counters.step),
            newton_iterations=int(counters.newton_total),
            newton_iterations_max=int(counters.newton_max),
            divided_steps=int(counters.divided_steps),
            fallback_steps=int(counters.fallback_steps),
            unconverged_steps=int(counters.unconverged_steps),
            worst_residual=float(counters.worst_residual),
        )
