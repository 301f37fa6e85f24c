"""The train as the kernel sees it: arrays built from the model, advanced step by step."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from haul_ros.model.air_brake import ATMOSPHERE, PneumaticBrake
from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.consist import Consist
from haul_ros.model.initial_state import InitialAir
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.track import Track
from haul_ros.physics.air_assembly import total_air
from haul_ros.physics.assembly import assemble, protected, with_room_for_waves
from haul_ros.physics.hinges import stored_energy
from haul_ros.physics.kernel import data
from haul_ros.physics.kernel._jit import interpreted, is_cached
from haul_ros.physics.kernel.advance import advance
from haul_ros.physics.kernel.air_data import RELEASED
from haul_ros.physics.kernel.air_driver_valve import told_by_pipe
from haul_ros.physics.kernel.air_flow import FLOW_FACTOR
from haul_ros.physics.kernel.blocks import Blocks, Train, named
from haul_ros.physics.kernel.effort import drop_efforts, stop_pulling
from haul_ros.physics.lumping import lump
from haul_ros.physics.parting import Parting, PartingKind, leak_areas, stop_waves_at, without_draft, without_hose
from haul_ros.units import seconds_to_ns

NEWTON_TOLERANCE = 1e-3
"""Force residual [N] at which a step counts as converged."""

SETTLED_RATE = 100.0
"""Change of cylinder pressure [Pa/s] below which a pneumatic brake has settled, with SETTLED_FLOW."""

SETTLED_FLOW = 5e-3
"""Flow in the brake pipe [kg/s] below which no wave is under way in it; that of leaks and charging is less."""

_FULL = 0.75
"""Part of the room for brake waves above which, with the spent ones dropped, more room is made."""

Floats = NDArray[np.float64]

_told_by_pipe = interpreted(told_by_pipe)
_drop_efforts = interpreted(drop_efforts)
_stop_pulling = interpreted(stop_pulling)

COMPILING = (
    "compiling the model, once after an installation or if what is kept of it is damaged; "
    "takes half a minute, to two on a busy machine"
)
"""What users are told then."""


def kernel_is_cached() -> bool:
    """Whether the compiled kernel is at hand; else the first train made in this process waits for it."""
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


def _least_before(waves: data.Records, serials: NDArray[Any]) -> Floats:
    """Of serial numbers by vehicle, the least among the vehicles still before each wave; infinite: none is."""
    ahead = np.concatenate(([np.inf], np.minimum.accumulate(serials)))
    behind = np.concatenate((np.minimum.accumulate(serials[::-1])[::-1], [np.inf]))
    return np.asarray(np.minimum(ahead[waves.ahead + 1], behind[waves.behind]))


def _brake_speeds(brakes: BrakeSystem | PneumaticBrake) -> dict[WaveKind, float]:
    if isinstance(brakes, PneumaticBrake):  # waves come of its air
        return {}
    return {
        WaveKind.SERVICE: brakes.wave_speeds.service,
        WaveKind.RELEASE: brakes.wave_speeds.release,
        WaveKind.EMERGENCY: brakes.wave_speeds.emergency,
        WaveKind.EMERGENCY_RELEASE: brakes.wave_speeds.release,
    }


@dataclass(frozen=True, slots=True, eq=False)
class ValveState:
    """Control valves of every vehicle (v,), and what the brake valves of the locomotives (k,) ask of them.

    ``applied``: not released; ``emergency``: it has tripped. ``release_commanded``: some brake valve charges the pipe;
    ``emergency_commanded``: some brake valve vents it by hand. ``targets``: gauge pressures of the pipe that the brake
    valves are put to [Pa]; ``feed_cut``: they do not feed it. ``cut_out`` (v,): the control valve is cut out;
    ``held_off`` (v,): the electric brake keeps the cylinder empty.
    """

    applied: NDArray[np.bool_]
    emergency: NDArray[np.bool_]
    release_commanded: bool
    emergency_commanded: bool
    targets: Floats
    feed_cut: NDArray[np.bool_]
    cut_out: NDArray[np.bool_]
    held_off: NDArray[np.bool_]

    @property
    def out_of_use(self) -> NDArray[np.bool_]:
        """Vehicles whose cylinder stays empty whatever the pipe says (v,)."""
        return self.cut_out | self.held_off


class TrainModel:
    """Longitudinal dynamics of one train.

    Parameters
    ----------
    consist, brakes, track
        The train and its line.
    initial_speed
        Speed at t = 0 [m/s]: one for all, or one for each mass (vehicles joined rigidly are one).
    initial_stroke
        Stroke of the couplers at t = 0 [m], compression positive: one for all, or one for each (that of a rigid
        drawbar counts for nothing). The head stands at the start of the line, the vehicles behind it as they must.
    initial_air
        Pressures of a pneumatic brake at t = 0; None: charged and released.
    time_step
        Step of the Newmark method [s].
    hose_reach
        Gap of a parted coupler at which its hose parts [m].
    """

    def __init__(
        self,
        consist: Consist,
        brakes: BrakeSystem | PneumaticBrake,
        track: Track | None = None,
        *,
        initial_speed: ArrayLike,
        initial_stroke: ArrayLike = 0.0,
        initial_air: InitialAir | None = None,
        time_step: float = 1e-3,
        hose_reach: float = 0.3,
    ) -> None:
        self.consist = consist
        self._wave_speeds = _brake_speeds(brakes)
        self._pneumatic = brakes if isinstance(brakes, PneumaticBrake) else None
        self._driver_valve = {locomotive.vehicle: k for k, locomotive in enumerate(consist.locomotives)}
        self._time_step = time_step
        self._start_chainage = (track or Track()).start_chainage
        self._cylinder_pressure = np.array([v.cylinder_pressure for v in consist.vehicles])
        lumped = lump(consist)
        self._rigid = lumped.rigid
        self.gears = lumped.gears
        """The draft gears, in the order of the couplers that have one."""
        stroke = np.broadcast_to(np.asarray(initial_stroke, dtype=np.float64), self._rigid.shape)[~self._rigid]
        self._use(
            assemble(
                consist,
                lumped,
                brakes,
                track or Track(),
                initial_speed=np.asarray(initial_speed, dtype=np.float64),
                initial_stroke=stroke,
                initial_air=initial_air,
                time_step=time_step,
                tolerance=NEWTON_TOLERANCE,
            )
        )
        n_couplers, n_vehicles = len(consist.couplers), len(consist.vehicles)
        self._hose_reach = hose_reach
        self._parted = np.zeros(n_couplers, dtype=bool)
        self._hose_parted, self._cock_open = np.zeros(n_couplers, dtype=bool), np.ones(n_couplers, dtype=bool)
        self._draft_stroke = np.zeros(n_couplers)  # the largest before a coupler parted
        self._leakage, self._holes = np.zeros(n_vehicles), np.zeros(n_vehicles)
        self._partings: list[Parting] = []
        self._air_at_start = self._air()
        advance(self._blocks, 0)
        self.initial_kinetic_energy = self.kinetic_energy
        self.initial_gear_energy = np.array([*map(stored_energy, self.gears, stroke)])
        self.initial_demand = 0.0
        """Brake demand that the locomotives' brake valves stand at, 0 to 1."""
        if self._pneumatic is not None and initial_air is not None and initial_air.cylinder > 0.0:
            self.initial_demand = self._pneumatic.demand_at(initial_air.pipe)

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
        end = self.step + n_steps
        advance(self._blocks, n_steps)
        while self._train.settings[0].may_part:
            self._let_part()
            if self.step == end:
                break
            advance(self._blocks, end - self.step)

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
            # With little gained, the next look would come soon, and one at every wave would cost more than the waves
            if n > _FULL * len(self._train.waves):
                self._use(with_room_for_waves(self._blocks))
        serial = counters.waves_started + 1
        parted = np.flatnonzero(self._hose_parted)
        first = int(parted[parted < vehicle].max(initial=-1)) + 1
        last = int(parted[parted >= vehicle].min(initial=len(self._hose_parted)))
        speed = self._wave_speeds[kind]
        self._train.waves[n] = (time, speed, level, kind, serial, vehicle, vehicle, vehicle + 1, first, last)
        counters.waves_started = serial
        counters.waves = n + 1

    @property
    def waves_under_way(self) -> int:
        """Brake waves that have not left the train, or come to their ends at parted hoses."""
        return int(self._train.counters[0].waves)

    def _drop_spent_waves(self) -> int:
        """Remove waves that have nothing to say any more to the vehicles still before them; how many are left."""
        brakes, counters = self._train.brakes, self._train.counters[0]
        waves = self._train.waves[: int(counters.waves)]
        ends = waves.serial[waves.kind == WaveKind.EMERGENCY_RELEASE]
        ended_later = waves.serial <= ends.min(initial=counters.waves_started)
        overruled = np.maximum(brakes.released_by, brakes.unlatched_by)
        service, release = waves.kind == WaveKind.SERVICE, waves.kind == WaveKind.RELEASE
        spent = np.zeros(len(waves), dtype=bool)
        for of_kind, overruled_by in (
            (waves.kind == WaveKind.EMERGENCY, brakes.unlatched_by),
            (waves.kind == WaveKind.EMERGENCY_RELEASE, brakes.latched_by),
            (release, brakes.applied_by),
            (service & ~ended_later, overruled),
            # In an emergency that only ends overruling this wave can end, it has nothing to say
            (service & ended_later, np.where(brakes.latched == 1.0, np.inf, overruled)),
        ):
            spent[of_kind] = waves.serial[of_kind] <= _least_before(waves[of_kind], overruled_by)
        left = int(np.count_nonzero(~spent))
        waves[:left] = waves[~spent]
        counters.waves = left
        return left

    def set_traction(self, vehicle: int, force: float) -> None:
        """Ask a vehicle for a tractive effort [N] from the present time on; it gives what it can, at its own rate.

        None leaves an electric brake alone.
        """
        if force != 0.0 or not self._train.vehicles.effort_asked[vehicle] < 0.0:
            self._ask_effort(vehicle, force)

    def set_electric_brake(self, vehicle: int, force: float) -> None:
        """Ask a vehicle for an electric brake force [N], in the same way; none leaves traction alone."""
        if force != 0.0 or not self._train.vehicles.effort_asked[vehicle] > 0.0:
            self._ask_effort(vehicle, -force)

    def _ask_effort(self, vehicle: int, effort: float) -> None:
        vehicles = self._train.vehicles
        vehicles.effort_asked[vehicle] = effort
        if self._train.vehicle_parameters.effort_rate[vehicle] == np.inf:
            vehicles.traction_demand[vehicle] = effort
        if effort != 0.0:
            self._train.counters.has_traction[0] = 1
        advance(self._blocks, 0)

    def drop_efforts(self, vehicle: int) -> None:
        """An emergency at a vehicle: traction ends at once, the electric brake too unless it is to stay."""
        _drop_efforts(self._train.vehicle_parameters, self._train.vehicles, vehicle)
        advance(self._blocks, 0)

    def stop_pulling(self, vehicle: int) -> None:
        """End the tractive effort of a vehicle at once; an electric brake stays."""
        _stop_pulling(self._train.vehicles, vehicle)
        advance(self._blocks, 0)

    @property
    def efforts(self) -> Floats:
        """Tractive effort, or negative electric brake, of every vehicle (n_vehicles,) [N], as it acts; a copy."""
        return self._train.vehicles.traction.copy()

    def set_radio_link(self, vehicle: int, connected: bool) -> None:
        """Say whether the radio link to a locomotive is up; while it is down, a brake wave ends its traction.

        If its brake is applied when the link goes down, traction ends then.
        """
        self._train.vehicles.link_down[vehicle] = 0.0 if connected else 1.0
        if self.stopped_by_pipe(vehicle):
            self.stop_pulling(vehicle)

    def stopped_by_pipe(self, vehicle: int) -> bool:
        """Whether the brake pipe alone keeps a locomotive from pulling: its link is down, and a brake is applied."""
        if self._train.vehicles.link_down[vehicle] == 0.0:
            return False
        if self._pneumatic is None:
            return self.brake_target(vehicle) > 0.0
        air, valves, k = self._train.air[0], self._train.driver_valves, self._driver_valve[vehicle]
        return bool(_told_by_pipe(air, valves, k, self._train.air_state.pipe[vehicle]))

    # -- pneumatic brake ---------------------------------------------------------------------------

    @property
    def pneumatic(self) -> PneumaticBrake | None:
        """The pneumatic brake of the train; None if it has the empirical one."""
        return self._pneumatic

    def set_brake_valve(self, vehicle: int, demand: float) -> None:
        """Put the brake valve of a locomotive to a demand, 0 released to 1 full service, by hand.

        It opens its feed again, whatever had closed it, if that demand is release; an application opens none, for a
        valve that maintains its reduction would charge a pipe that an emergency or a parted hose has emptied.
        """
        assert self._pneumatic is not None
        self._turn_valve(vehicle, self._pneumatic.pressure_for(demand), emergency=False)

    def set_emergency_valve(self, vehicle: int) -> None:
        """Put the brake valve of a locomotive to emergency: the pipe is vented until it is put elsewhere."""
        self._turn_valve(vehicle, 0.0, emergency=True)

    def _turn_valve(self, vehicle: int, pressure: float, *, emergency: bool) -> None:
        k, valves = self._driver_valve[vehicle], self._train.driver_valves
        valves.target[k] = pressure + ATMOSPHERE
        valves.emergency[k] = float(emergency)
        valves.charged[k] = 0.0
        if valves.target[k] >= self._train.air[0].charge_pressure:
            valves.tripped[k] = valves.feed_cut[k] = 0.0

    def _air(self) -> float:
        """Air in brake and main reservoirs, plus what has left, less what compressors have brought [kg]."""
        train, account = self._train, self._train.air_account[0]
        if self._pneumatic is None:
            return 0.0
        gas = float(train.air[0].gas)
        reservoirs = train.driver_valves.main_reservoir * train.driver_valve_parameters.reservoir_volume
        inside = total_air(train.air_parameters, train.air_state, gas) + float(np.sum(reservoirs)) / gas
        return inside + float(account.vented) - float(account.compressed)

    @property
    def air_error(self) -> float:
        """Part of the air of a pneumatic brake that came from nowhere or went there; infinite: a pressure is none."""
        if self._pneumatic is None:
            return 0.0
        state = self._train.air_state
        if not all((row > 0.0).all() for row in (state.pipe, state.auxiliary, state.cylinder)):
            return float("inf")
        return abs(self._air() / self._air_at_start - 1.0)

    def set_cock(self, coupler: int, *, is_open: bool) -> None:
        """Open or close the angle cocks between two vehicles (those of both); ValueError: there is no such coupler."""
        self._check_coupler(coupler)
        self._cock_open[coupler] = is_open
        self._set_openings()

    def set_hole(self, vehicle: int, area: float) -> None:
        """Let the brake pipe of a vehicle have an opening to the atmosphere of an effective area [m^2]; 0: none.

        ValueError: there is no such vehicle, or no such area.
        """
        self._check_vehicle(vehicle)
        if not 0.0 <= area < 1.0:
            raise ValueError(f"area {area} m^2: expected 0 to 1")
        self._holes[vehicle] = area
        self._set_openings()

    def set_leak(self, vehicle: int, bore: float) -> None:
        """The same by the bore of a hole [m], with the discharge coefficient of all bores."""
        assert self._pneumatic is not None
        self.set_hole(vehicle, self._pneumatic.discharge * np.pi / 4.0 * bore**2)

    def set_leakage(self, rate: float) -> None:
        """Let the whole pipe leak so that it falls at a rate [Pa/s], charged, without feed and control valves."""
        assert self._pneumatic is not None
        air, volume = self._train.air[0], self._train.air_parameters.pipe_volume
        self._leakage = leak_areas(volume, float(air.gas), float(air.charge_pressure), rate)
        self._set_openings()

    def cut_out_valve(self, vehicle: int, *, cut_out: bool) -> None:
        """Cut the control valve of a vehicle out from the pipe, or in again; ValueError: there is no such vehicle."""
        self._check_vehicle(vehicle)
        self._train.air_state.cut_out[vehicle] = float(cut_out)

    def part_hose(self, coupler: int) -> None:
        """Part the hose between two vehicles: where cocks are open both ends of the pipe are open to the atmosphere.

        With the empirical brake an emergency wave starts at both ends, and no wave passes between them any more.
        ValueError: there is no such coupler.
        """
        self._check_coupler(coupler)
        if self._hose_parted[coupler]:
            return
        self._hose_parted[coupler] = True
        if self._pneumatic is not None:
            self._set_openings()
            return
        stop_waves_at(self._train.waves[: int(self._train.counters[0].waves)], coupler)
        for vehicle in (coupler, coupler + 1):
            self.start_wave(self.time, vehicle, WaveKind.EMERGENCY)

    def _set_openings(self) -> None:
        state = self._train.air_state
        ends = (self._hose_parted & self._cock_open) * float(self._train.air[0].pipe_area)
        state.cock[:-1] = self._cock_open & ~self._hose_parted
        state.hole[:] = self._leakage + self._holes
        state.hole[:-1] += ends
        state.hole[1:] += ends

    def _check_coupler(self, coupler: int) -> None:
        if not 0 <= coupler < len(self.consist.couplers):
            raise ValueError(f"coupler {coupler}: expected 0 to {len(self.consist.couplers) - 1}")

    def _check_vehicle(self, vehicle: int) -> None:
        if not 0 <= vehicle < len(self.consist.vehicles):
            raise ValueError(f"vehicle {vehicle}: expected 0 to {len(self.consist.vehicles) - 1}")

    # -- separation --------------------------------------------------------------------------------

    def uncouple(self, coupler: int) -> None:
        """Open a coupler now, whatever it bears; ValueError: there is none, or it is a rigid drawbar."""
        self._check_coupler(coupler)
        if self._rigid[coupler]:
            raise ValueError(f"coupler {coupler}: is a rigid drawbar")
        if not self._parted[coupler]:
            self._part(coupler, PartingKind.UNCOUPLED)

    @property
    def parted(self) -> NDArray[np.bool_]:
        """Couplers that are parted (n_couplers,): they bear no draft any more; a copy."""
        return self._parted.copy()

    @property
    def hose_parted(self) -> NDArray[np.bool_]:
        """Couplers whose hoses are parted (n_couplers,); a copy."""
        return self._hose_parted.copy()

    def take_partings(self) -> list[Parting]:
        """What has given way since the last call, in order of time."""
        taken, self._partings = self._partings, []
        return taken

    def _let_part(self) -> None:
        """Part what gives way at the end of a time step."""
        parameters, gears = self._train.gear_parameters, self._train.gears
        couplers = np.flatnonzero(~self._rigid)
        broken = couplers[-gears.force > parameters.strength]
        out_of_reach = couplers[-gears.stroke > parameters.hose_reach]
        for coupler in broken:
            self._part(int(coupler), PartingKind.BROKEN)
        for coupler in out_of_reach:
            self._tell(int(coupler), PartingKind.HOSE)
            self._use(without_hose(self._blocks, self._gear_of(coupler)))
            self.part_hose(int(coupler))

    def _part(self, coupler: int, kind: PartingKind) -> None:
        self._tell(coupler, kind)
        k, gears = self._gear_of(coupler), self._train.gears
        if gears.stroke[k] < 0.0:
            gears.dissipated[k] += stored_energy(self.gears[k], float(gears.stroke[k]))
        self._draft_stroke[coupler] = self._train.gear_extremes.tension_stroke[k]
        self._parted[coupler] = True
        self._use(without_draft(self._blocks, k, np.inf if self._hose_parted[coupler] else self._hose_reach))

    def _tell(self, coupler: int, kind: PartingKind) -> None:
        gears, k = self._train.gears, self._gear_of(coupler)
        self._partings.append(Parting(self.time, coupler, kind, -float(gears.force[k]), -float(gears.stroke[k])))

    def _gear_of(self, coupler: int) -> int:
        return int(np.count_nonzero(~self._rigid[:coupler]))

    @property
    def stored_energies(self) -> Floats:
        """What the draft gears would give back if let out slowly (n_gears,) [J]; a parted one has nothing in draft."""
        strokes, parted = self._train.gears.stroke, self._parted[~self._rigid]
        stored = np.array([*map(stored_energy, self.gears, strokes)])
        return np.where(parted & (strokes < 0.0), 0.0, stored)

    # -- observing ---------------------------------------------------------------------------------

    @property
    def at_standstill(self) -> bool:
        """Every vehicle stands, held by friction."""
        return not self._train.masses.direction.any()

    @property
    def brakes_settled(self) -> bool:
        """No brake wave is under way and no brake cylinder filling or emptying."""
        if self._pneumatic is not None:
            return self._air_settled()
        return self._train.counters[0].waves == 0 and not self._train.brakes.filling.any()

    def _air_settled(self) -> bool:
        state, valves = self._train.air_state, self._train.driver_valves
        set_out = (valves.equalising != valves.target) & (valves.emergency == 0.0)
        rate = np.abs(state.cylinder - state.cylinder_before) / self._train.air[0].step
        flow = SETTLED_FLOW + self._leaks
        return not set_out.any() and bool(rate.max() < SETTLED_RATE) and bool(np.abs(state.flow).max() < flow)

    @property
    def _leaks(self) -> float:
        """What leaves the pipe through leaks and holes [kg/s], which the brake valves feed for ever."""
        air, pipe, holes = self._train.air[0], self._train.air_state.pipe, self._leakage + self._holes
        return FLOW_FACTOR / float(air.root_gas) * float(np.sum(holes * pipe)) if holes.any() else 0.0

    def in_emergency(self, vehicle: int) -> bool:
        """An emergency has reached a vehicle, and nothing that ends it."""
        if self._pneumatic is not None:
            valves, k = self._train.driver_valves, self._driver_valve.get(vehicle)
            felt = k is not None and bool(valves.tripped[k] or valves.emergency[k])
            return felt or bool(self._train.air_state.emergency[vehicle])
        return bool(self._train.brakes.latched[vehicle])

    @property
    def stop_time(self) -> float:
        """When the last vehicle came to rest [s], to a time step; 0 if none moved. For a standing train."""
        return float(self._train.counters[0].last_motion_step + 1) * self.time_step

    @property
    def speed(self) -> Floats:
        """Speed of every vehicle (n_vehicles,) [m/s]; a copy."""
        return self._train.masses.velocity[self._train.mass_index]

    def chainage(self, vehicle: int) -> float:
        """Where the centre of a vehicle is [m]."""
        train = self._train
        travelled = train.masses.displacement[train.mass_index[vehicle]]
        return float(self._start_chainage - train.vehicle_parameters.centre_offset[vehicle] + travelled)

    @property
    def displacement(self) -> Floats:
        """Way of every vehicle (n_vehicles,) [m], from where it stands at t = 0 if the couplers are free; a copy."""
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

    def valves(self) -> ValveState | None:
        """What the control valves do; None without a pneumatic brake."""
        if self._pneumatic is None:
            return None
        state, driver = self._train.air_state, self._train.driver_valves
        charging = (driver.target >= self._train.air[0].charge_pressure) & (driver.feed_cut == 0.0)
        return ValveState(
            applied=state.position != RELEASED,
            emergency=state.emergency != 0.0,
            release_commanded=bool((charging & (driver.tripped == 0.0)).any()),
            emergency_commanded=bool(driver.emergency.any()),
            targets=driver.target - ATMOSPHERE,
            feed_cut=driver.feed_cut != 0.0,
            cut_out=state.cut_out != 0.0,
            held_off=state.held_off != 0.0,
        )

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
            pipe_pressure=self._gauge(train.air_state.pipe),
            auxiliary_pressure=self._gauge(train.air_state.auxiliary),
        )

    def _gauge(self, pressure: Floats) -> Floats | None:
        return pressure - ATMOSPHERE if self._pneumatic is not None else None

    def extremes(self) -> CouplerExtremes:
        """Largest coupler forces and strokes since the start."""
        gears, drawbars = self._train.gear_extremes, self._train.drawbar_extremes
        draft_stroke = np.where(self._parted, self._draft_stroke, self._by_coupler(gears.tension_stroke))
        return CouplerExtremes(
            compression=self._by_coupler(gears.compression, drawbars.compression),
            compression_time=self._by_coupler(gears.compression_time, drawbars.compression_time),
            tension=self._by_coupler(gears.tension, drawbars.tension),
            tension_time=self._by_coupler(gears.tension_time, drawbars.tension_time),
            compression_stroke=self._by_coupler(gears.compression_stroke),
            tension_stroke=draft_stroke,
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
