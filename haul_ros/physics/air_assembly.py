"""The arrays of the pneumatic brake, assembled from its model; without one they are there, and empty."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.air_brake import ATMOSPHERE, ControlValve, DriverValve, PneumaticBrake, Release
from haul_ros.model.consist import Consist
from haul_ros.model.initial_state import InitialAir
from haul_ros.physics.kernel import air_data, data

GAS_CONSTANT = 287.0
"""Of air [J/(kg K)]."""

VISCOSITY = 1.81e-5
"""Dynamic, of air at 20 degrees [Pa s]."""

_NO_BULB = 1e-6
"""Volume [m^3] of a bulb that nothing leads to, so that it has a pressure."""

_KINDS = {Release.DIRECT: air_data.DIRECT_RELEASE, Release.GRADUATED: air_data.GRADUATED_RELEASE}

Floats = NDArray[np.float64]


class AirBlocks(NamedTuple):
    """The blocks of the pneumatic brake, by the names that they have in `Blocks`."""

    air: data.Records
    air_account: data.Records
    air_parameters: Floats
    air_state: Floats
    driver_valve_parameters: Floats
    driver_valves: Floats


def no_air() -> AirBlocks:
    """The blocks of a train without a pneumatic brake."""

    def empty(kind: type[NamedTuple]) -> Floats:
        return np.zeros((len(kind._fields), 0))

    return AirBlocks(
        air=np.zeros(1, air_data.AIR).view(np.recarray),
        air_account=np.zeros(1, air_data.AIR_ACCOUNT).view(np.recarray),
        air_parameters=empty(air_data.AirParameters),
        air_state=empty(air_data.AirState),
        driver_valve_parameters=empty(air_data.DriverValveParameters),
        driver_valves=empty(air_data.DriverValveState),
    )


def assemble_air(
    consist: Consist, brake: PneumaticBrake, time_step: float, initial: InitialAir | None = None
) -> AirBlocks:
    """The memory of the pneumatic brake of a train, charged and released unless ``initial`` says otherwise."""
    initial = initial or InitialAir(brake.pressure, brake.pressure, 0.0)
    gas = GAS_CONSTANT * brake.pipe.temperature
    parameters = _parameters(consist, brake)
    return AirBlocks(
        air=_settings(brake, gas, time_step),
        air_account=np.zeros(1, air_data.AIR_ACCOUNT).view(np.recarray),
        air_parameters=parameters,
        air_state=_filled(air_data.AirParameters(*parameters), brake, initial, gas),
        driver_valve_parameters=np.array(
            air_data.DriverValveParameters(
                vehicle=np.array([float(locomotive.vehicle) for locomotive in consist.locomotives]),
                reservoir_volume=np.full(len(consist.locomotives), brake.driver_valve.main_reservoir_volume),
            )
        ),
        driver_valves=_driver_valves(len(consist.locomotives), brake, initial),
    )


def _settings(brake: PneumaticBrake, gas: float, time_step: float) -> data.Records:
    valve: DriverValve = brake.driver_valve
    air = np.zeros(1, air_data.AIR).view(np.recarray)
    air.present = 1
    air.every = max(1, round(brake.step / time_step))
    air.substeps = max(1, round(time_step / brake.step))
    air.step = time_step * air.every / air.substeps
    air.gas = gas
    air.root_gas = math.sqrt(gas)
    air.atmosphere = ATMOSPHERE
    air.pipe_area = math.pi / 4.0 * brake.pipe.bore**2
    air.pipe_bore = brake.pipe.bore
    air.pipe_friction = brake.pipe.friction_factor
    air.viscosity = VISCOSITY
    air.charge_pressure = ATMOSPHERE + brake.pressure
    for name in ("equalising_down", "equalising_up", "dead_band", "relay_span", "emergency_difference"):
        air[name] = getattr(valve, name)
    for name in ("emergency_lag", "vent_time", "feed_cut_difference", "maintaining"):
        air[name] = getattr(valve, name)
    for name in ("exhaust", "feed", "emergency"):
        air[f"{name}_area"] = _area(getattr(valve, f"{name}_bore"), brake.discharge)
    air.compressor_flow = valve.compressor_flow * ATMOSPHERE / gas
    air.compressor_on = ATMOSPHERE + valve.compressor_on
    air.compressor_off = ATMOSPHERE + valve.compressor_off
    return air


def _area(bore: float, discharge: float) -> float:
    """Effective area of a bore [m^2]."""
    return discharge * math.pi / 4.0 * bore**2


def _parameters(consist: Consist, brake: PneumaticBrake) -> Floats:
    area = math.pi / 4.0 * brake.pipe.bore**2
    lengths = [brake.pipe.length_ratio * vehicle.length for vehicle in consist.vehicles]
    locomotives = {locomotive.vehicle for locomotive in consist.locomotives}
    columns = []
    for i, vehicle in enumerate(consist.vehicles):
        numbers = _of_valve(brake.valves[vehicle.name], brake.discharge)
        numbers["pipe_volume"] = area * lengths[i] + brake.pipe.branch_volume
        numbers["face_length"] = (lengths[i] + lengths[min(i + 1, len(lengths) - 1)]) / 2.0
        numbers["cylinder_limit"] = brake.cylinder_limits.get(vehicle.name, math.inf)
        numbers["reference_pressure"] = vehicle.cylinder_pressure
        if i not in locomotives:
            numbers["from_main_reservoir"] = 0.0
        elif numbers["from_main_reservoir"]:
            numbers["auxiliary_volume"] = brake.driver_valve.main_reservoir_volume
        columns.append([numbers[name] for name in air_data.AirParameters._fields])
    return np.ascontiguousarray(np.array(columns, dtype=np.float64).T)


def _of_valve(valve: ControlValve, discharge: float) -> dict[str, float]:
    """Numbers of a valve by their names in `AirParameters`; bores become areas."""
    numbers = {"kind": _KINDS[valve.release]}
    for name in air_data.AirParameters._fields:
        bore = f"{name.removesuffix('_area')}_bore"
        if name.endswith("_area"):
            numbers[name] = _area(getattr(valve, bore), discharge)
        elif hasattr(valve, name):
            numbers[name] = float(getattr(valve, name))
    numbers["bulb_volume"] = numbers["bulb_volume"] or _NO_BULB
    return numbers


def _filled(parameters: air_data.AirParameters, brake: PneumaticBrake, initial: InitialAir, gas: float) -> Floats:
    """Pipe, reservoirs and cylinders at rest, nothing flowing; with air in the cylinder the valve is lapped.

    Emergency chamber, emergency and accelerated-release reservoir have the pressure of the pipe; so has the control
    reservoir of a graduated valve, and what more it takes for its cylinder to be at its target.
    """
    vehicles = len(parameters.kind)
    block = np.zeros((len(air_data.AirState._fields), vehicles))
    state = air_data.AirState(*block)
    for reservoir in (state.pipe, state.accelerated, state.emergency_reservoir, state.chamber, state.control):
        reservoir[:] = initial.pipe + ATMOSPHERE
    supplied = parameters.from_main_reservoir == 1.0
    state.auxiliary[:] = np.where(supplied, brake.driver_valve.compressor_off, initial.auxiliary) + ATMOSPHERE
    graduated = parameters.kind == air_data.GRADUATED_RELEASE
    most = np.where(
        graduated, np.minimum(parameters.cylinder_most, parameters.cylinder_limit), parameters.cylinder_limit
    )
    gauge = np.minimum(initial.cylinder, most)
    applied = gauge > 0.0
    state.position[applied] = air_data.LAPPED
    state.bulb[:] = np.where(graduated & applied, state.pipe, ATMOSPHERE)
    state.control[graduated] += gauge[graduated] / parameters.cylinder_ratio[graduated]
    state.cylinder[:] = state.cylinder_before[:] = gauge + ATMOSPHERE
    out = np.minimum(1.0, gauge / parameters.cylinder_spring)
    volume = parameters.cylinder_clearance + out * parameters.cylinder_displaced
    state.cylinder_air[:] = state.cylinder * volume / gas
    state.cock[:-1] = 1.0
    return block


def _driver_valves(locomotives: int, brake: PneumaticBrake, initial: InitialAir) -> Floats:
    """Brake valves that hold the pipe where the brakes are applied, or else are released, and charge it."""
    block = np.zeros((len(air_data.DriverValveState._fields), locomotives))
    valves = air_data.DriverValveState(*block)
    held = initial.pipe if initial.cylinder > 0.0 else brake.pressure
    valves.target[:] = valves.equalising[:] = held + ATMOSPHERE
    valves.chamber[:] = initial.pipe + ATMOSPHERE
    valves.main_reservoir[:] = brake.driver_valve.compressor_off + ATMOSPHERE
    valves.charged[:] = float(initial.pipe > held - air_data.NEARLY_CHARGED)
    return block


def total_air(parameters: air_data.AirParameters, state: air_data.AirState, gas: float) -> float:
    """Mass of air [kg] in pipe, reservoirs and cylinders of a train; its locomotives' main reservoirs apart."""
    return float(
        np.sum(
            state.pipe * parameters.pipe_volume
            + state.auxiliary * parameters.auxiliary_volume * (1.0 - parameters.from_main_reservoir)
            + state.accelerated * parameters.accelerated_volume
            + state.emergency_reservoir * parameters.emergency_volume
            + state.bulb * parameters.bulb_volume
        )
        / gas
        + np.sum(state.cylinder_air)
    )
