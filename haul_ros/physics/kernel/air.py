"""The pneumatic brake beside the time steps: when its own steps are due, and what brake the cylinders give.

Air steps and time steps lie on one grid: an air step takes a whole number of time steps, or a time step a whole
number of air steps. While an air step is under way the cylinder pressure is taken as linear in time.
"""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner, outer
from haul_ros.physics.kernel.air_data import AirParameters, AirState, DriverValveParameters, DriverValveState
from haul_ros.physics.kernel.air_driver_valve import add_vented, driver_valve, told_by_pipe
from haul_ros.physics.kernel.air_flow import pipe_flow, pipe_pressure
from haul_ros.physics.kernel.air_valves import control_valves
from haul_ros.physics.kernel.blocks import (
    Blocks,
    air_parameters_of,
    air_state_of,
    brakes_of,
    driver_valve_parameters_of,
    driver_valves_of,
    masses_of,
    vehicle_parameters_of,
    vehicles_of,
)
from haul_ros.physics.kernel.brake_force import set_coefficients
from haul_ros.physics.kernel.data import Floats, Ints, Record, VehicleParameters, VehicleState
from haul_ros.physics.kernel.effort import drop_efforts, stop_pulling

OFF = 0.01
"""Fraction of full cylinder pressure below which a brake counts as released: a new application begins there."""


VENTED = 100e3
"""Gauge pressure of the pipe [Pa] below which an emergency has vented it: no electric brake holds an air brake off."""


@inner
def _held_off(
    air: Record, parameters: VehicleParameters, vehicles: VehicleState, i: int, speed: float, pipe: float
) -> float:
    """1 while the electric brake of a locomotive holds its own air brake off."""
    fast = speed >= parameters.electric_fade_speed[i]  # below it there is no full electric brake any more
    braking = parameters.interlock[i] == 1.0 and vehicles.traction_demand[i] < 0.0 and fast
    return 1.0 if braking and pipe > air.atmosphere + VENTED else 0.0


@outer
def _air_step(
    air: Record,
    account: Record,
    parameters: AirParameters,
    state: AirState,
    driver_parameters: DriverValveParameters,
    driver_valves: DriverValveState,
    vehicle_parameters: VehicleParameters,
    vehicles: VehicleState,
    velocity: Floats,
    mass_index: Ints,
) -> None:
    """One step of the air in the train; locomotives that it tells to do so stop pulling."""
    for k in range(driver_valves.target.shape[0]):
        i = int(driver_parameters.vehicle[k])
        speed = abs(velocity[mass_index[i]])
        state.held_off[i] = _held_off(air, vehicle_parameters, vehicles, i, speed, state.pipe[i])
    add_vented(account, control_valves(air, parameters, state))
    for k in range(driver_valves.target.shape[0]):
        i = int(driver_parameters.vehicle[k])
        link_down = vehicles.link_down[i]
        driver_valve(air, account, parameters, state, driver_parameters, driver_valves, k, link_down)
        vented = driver_valves.tripped[k] == 1.0 or driver_valves.emergency[k] == 1.0
        if vented:
            drop_efforts(vehicle_parameters, vehicles, i)
        elif link_down == 1.0 and told_by_pipe(air, driver_valves, k, state.pipe[i]):
            stop_pulling(vehicles, i)
    pipe_flow(air, parameters, state)
    pipe_pressure(air, parameters, state)


@outer
def brakes_of_cylinders(blocks: Blocks, part: float) -> None:
    """Set the brake coefficients for the cylinder pressures at a part 0..1 of the air step under way."""
    air = blocks.air[0]
    parameters, state = air_parameters_of(blocks.air_parameters), air_state_of(blocks.air_state)
    vehicle_parameters, brakes = vehicle_parameters_of(blocks.vehicle_parameters), brakes_of(blocks.vehicles)
    velocity = masses_of(blocks.masses).velocity
    for i in range(brakes.fraction.shape[0]):
        pressure = state.cylinder_before[i] + part * (state.cylinder[i] - state.cylinder_before[i])
        if brakes.fraction[i] < OFF:
            brakes.initial_speed[i] = abs(velocity[blocks.mass_index[i]])
        brakes.fraction[i] = max(0.0, (pressure - air.atmosphere) / parameters.reference_pressure[i])
        brakes.gain_start[i] = brakes.gain_end[i]
        brakes.offset_start[i] = brakes.offset_end[i]
        set_coefficients(blocks.settings[0], vehicle_parameters, brakes, i)
        brakes.gain[i] = brakes.gain_end[i]
        brakes.offset[i] = brakes.offset_end[i]


@inner
def advance_air(blocks: Blocks) -> None:
    """Bring the air to the end of the present time step, and set the brake coefficients for it."""
    air = blocks.air[0]
    parameters, state = air_parameters_of(blocks.air_parameters), air_state_of(blocks.air_state)
    phase = blocks.counters[0].step % air.every
    if phase == 0:
        for _ in range(air.substeps):
            _air_step(
                air,
                blocks.air_account[0],
                parameters,
                state,
                driver_valve_parameters_of(blocks.driver_valve_parameters),
                driver_valves_of(blocks.driver_valves),
                vehicle_parameters_of(blocks.vehicle_parameters),
                vehicles_of(blocks.vehicles),
                masses_of(blocks.masses).velocity,
                blocks.mass_index,
            )
    brakes_of_cylinders(blocks, (phase + 1.0) / air.every)
