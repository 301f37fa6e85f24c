"""Brake valve of a locomotive: equalising reservoir, relay, feed from the main reservoir, emergency, compressor."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.air_data import (
    NEARLY_CHARGED,
    AirParameters,
    AirState,
    DriverValveParameters,
    DriverValveState,
)
from haul_ros.physics.kernel.air_flow import exchanged, vented
from haul_ros.physics.kernel.data import Record


@inner
def _added(total: float, rest: float, part: float) -> tuple[float, float]:
    """A sum with one part more, and the rest that rounding leaves; that of a large sum would show in hours (Kahan)."""
    wanted = part - rest
    new = total + wanted
    return new, (new - total) - wanted


@inner
def add_vented(account: Record, mass: float) -> None:
    """Add to the air that has left [kg]."""
    account.vented, account.vented_rest = _added(account.vented, account.vented_rest, mass)


@inner
def _opening(difference: float, air: Record) -> float:
    """Part of the relay's valve that is open, by what it has to correct [Pa]."""
    return min(1.0, max(0.0, (difference - air.dead_band) / air.relay_span))


@inner
def _take_equalising(air: Record, valves: DriverValveState, k: int) -> None:
    target, equalising = valves.target[k], valves.equalising[k]
    if target < equalising:
        valves.equalising[k] = max(target, equalising - air.equalising_down * air.step)
    else:
        valves.equalising[k] = min(target, equalising + air.equalising_up * air.step)


@inner
def _feel(air: Record, valves: DriverValveState, k: int, pipe: float, link_down: float) -> None:
    """What the valve makes of the pipe: an emergency that others started, a fall that nobody commanded here."""
    if valves.chamber[k] - pipe > air.emergency_difference and valves.tripped[k] == 0.0:
        valves.tripped[k] = 1.0
        valves.vent_left[k] = air.vent_time
    valves.chamber[k] += (pipe - valves.chamber[k]) * air.step / (air.emergency_lag + air.step)
    if valves.equalising[k] == valves.target[k] and pipe > valves.equalising[k] - NEARLY_CHARGED:
        valves.charged[k] = 1.0
    fallen = valves.charged[k] == 1.0 and pipe < valves.equalising[k] - air.feed_cut_difference
    if fallen or link_down == 1.0:
        valves.feed_cut[k] = 1.0


@inner
def _compress(air: Record, parameters: DriverValveParameters, valves: DriverValveState, k: int) -> float:
    """Mass that the compressor puts into the main reservoir in an air step [kg]."""
    if valves.main_reservoir[k] < air.compressor_on:
        valves.compressing[k] = 1.0
    elif valves.main_reservoir[k] >= air.compressor_off:
        valves.compressing[k] = 0.0
    mass = valves.compressing[k] * air.compressor_flow * air.step
    valves.main_reservoir[k] += air.gas * mass / parameters.reservoir_volume[k]
    return float(mass)


@inner
def _feed(
    air: Record, parameters: DriverValveParameters, valves: DriverValveState, k: int, pipe: float, volume: float
) -> float:
    """Mass that goes from the main reservoir into the pipe in an air step [kg]."""
    holding = valves.target[k] < air.charge_pressure and air.maintaining == 0
    closed = valves.emergency[k] == 1.0 or valves.tripped[k] == 1.0 or valves.feed_cut[k] == 1.0
    if closed or holding or valves.main_reservoir[k] <= pipe:
        return 0.0
    area = air.feed_area * _opening(valves.equalising[k] - pipe, air)
    mass = exchanged(air, area, valves.main_reservoir[k], parameters.reservoir_volume[k], pipe, volume)
    valves.main_reservoir[k] -= air.gas * mass / parameters.reservoir_volume[k]
    return float(mass)


@inner
def driver_valve(
    air: Record,
    account: Record,
    pipe_parameters: AirParameters,
    state: AirState,
    parameters: DriverValveParameters,
    valves: DriverValveState,
    k: int,
    link_down: float,
) -> None:
    """The brake valve of one locomotive for an air step."""
    i = int(parameters.vehicle[k])
    pipe, volume = state.pipe[i], pipe_parameters.pipe_volume[i]
    if pipe_parameters.from_main_reservoir[i] == 1.0:  # the locomotive's own cylinder has taken from it
        valves.main_reservoir[k] = state.auxiliary[i]
    _take_equalising(air, valves, k)
    _feel(air, valves, k, pipe, link_down)
    brought = _compress(air, parameters, valves, k)
    account.compressed, account.compressed_rest = _added(account.compressed, account.compressed_rest, brought)
    if valves.emergency[k] == 1.0 or valves.vent_left[k] > 0.0:
        area = air.emergency_area
        valves.vent_left[k] = max(0.0, valves.vent_left[k] - air.step)
    else:
        area = air.exhaust_area * _opening(pipe - valves.equalising[k], air)
    lost = vented(air, area, pipe, volume)
    fed = _feed(air, parameters, valves, k, pipe, volume)
    add_vented(account, lost)
    account.fed += fed
    state.inflow[i] += fed - lost
    if pipe_parameters.from_main_reservoir[i] == 1.0:
        state.auxiliary[i] = valves.main_reservoir[k]


@inner
def told_by_pipe(air: Record, valves: DriverValveState, k: int, pipe: float) -> bool:
    """Whether the pipe tells a locomotive of an application or an emergency."""
    fallen = pipe < valves.equalising[k] - air.feed_cut_difference
    return fallen or valves.tripped[k] == 1.0 or valves.emergency[k] == 1.0
