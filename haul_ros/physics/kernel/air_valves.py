"""Control valves of the vehicles: they compare the brake pipe with a reservoir, and fill or empty the brake cylinder.

All exchange air with the cell of the pipe at their vehicle; what they take or give is added to ``inflow``.
"""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.air_cylinder import cylinder_capacity, fill_cylinder
from haul_ros.physics.kernel.air_data import (
    APPLYING,
    DIRECT_RELEASE,
    GRADUATED_RELEASE,
    LAPPED,
    RELEASED,
    AirParameters,
    AirState,
)
from haul_ros.physics.kernel.air_flow import exchanged, vented
from haul_ros.physics.kernel.data import Record


@inner
def _to_cylinder(
    air: Record, parameters: AirParameters, state: AirState, i: int, area: float, source: float, volume: float
) -> float:
    """Mass that goes from a volume into the cylinder [kg]; nothing returns, and nothing passes the load device.

    Nor does anything go into one that an electric brake holds off.
    """
    cylinder = state.cylinder[i]
    limit = air.atmosphere + parameters.cylinder_limit[i]
    if source <= cylinder or cylinder >= limit or area == 0.0 or state.held_off[i] == 1.0:
        return 0.0
    capacity = cylinder_capacity(air, parameters, i, cylinder)
    mass = exchanged(air, area, source, volume, cylinder, capacity)
    mass = min(mass, (limit - cylinder) * capacity / air.gas)
    fill_cylinder(air, parameters, state, i, mass)
    return mass


@inner
def _exhaust(air: Record, parameters: AirParameters, state: AirState, i: int, area: float) -> float:
    """Mass that the cylinder loses to the atmosphere [kg]."""
    mass = vented(air, area, state.cylinder[i], cylinder_capacity(air, parameters, i, state.cylinder[i]))
    fill_cylinder(air, parameters, state, i, -mass)
    return mass


@inner
def _feel_emergency(air: Record, parameters: AirParameters, state: AirState, i: int) -> None:
    """The chamber follows the pipe; where that falls faster than it can, the valve trips."""
    pipe, chamber = state.pipe[i], state.chamber[i]
    if chamber - pipe > parameters.emergency_difference[i] and state.emergency[i] == 0.0:
        state.emergency[i] = 1.0
        state.vent_left[i] = parameters.vent_time[i]
        state.position[i] = APPLYING
        state.quick_service[i] = 0.0
    state.chamber[i] = chamber + (pipe - chamber) * air.step / (parameters.emergency_lag[i] + air.step)


@inner
def _direct_position(parameters: AirParameters, state: AirState, i: int) -> None:
    """Position of a direct-release valve, by auxiliary reservoir over pipe."""
    difference, position = state.auxiliary[i] - state.pipe[i], state.position[i]
    if position == RELEASED:
        if difference > parameters.quick_service_difference[i]:
            state.quick_service[i] = 1.0
        elif difference < parameters.lap_difference[i]:
            state.quick_service[i] = 0.0
        if difference > parameters.apply_difference[i]:
            state.position[i] = APPLYING
            state.quick_service[i] = 0.0  # the slide valve moves on
    elif difference < -parameters.release_difference[i]:
        state.position[i] = RELEASED
        state.emergency[i] = 0.0
        state.boosting[i] = 1.0
    elif position == APPLYING and difference < parameters.lap_difference[i] and state.emergency[i] == 0.0:
        state.position[i] = LAPPED
    elif position == LAPPED and difference > parameters.reapply_difference[i]:
        state.position[i] = APPLYING


@inner
def _join_emergency_reservoir(air: Record, parameters: AirParameters, state: AirState, i: int) -> None:
    """In an emergency both reservoirs are one."""
    first, second = parameters.auxiliary_volume[i], parameters.emergency_volume[i]
    mass = exchanged(air, parameters.fast_area[i], state.emergency_reservoir[i], second, state.auxiliary[i], first)
    state.emergency_reservoir[i] -= air.gas * mass / second
    state.auxiliary[i] += air.gas * mass / first


@inner
def _direct_release(air: Record, parameters: AirParameters, state: AirState, i: int) -> float:
    """A direct-release valve such as the 120 for an air step; mass that left to the atmosphere [kg]."""
    gas, lost, into_pipe = air.gas, 0.0, 0.0
    pipe, volume, auxiliary_volume = state.pipe[i], parameters.pipe_volume[i], parameters.auxiliary_volume[i]
    _feel_emergency(air, parameters, state, i)
    _direct_position(parameters, state, i)
    if state.vent_left[i] > 0.0:
        mass = vented(air, parameters.vent_area[i], pipe, volume)
        lost += mass
        into_pipe -= mass
        state.vent_left[i] -= air.step
    elif state.quick_service[i] == 1.0 and pipe > state.bulb[i]:
        mass = exchanged(air, parameters.bulb_fill_area[i], pipe, volume, state.bulb[i], parameters.bulb_volume[i])
        state.bulb[i] += gas * mass / parameters.bulb_volume[i]
        into_pipe -= mass
    elif state.quick_service[i] == 0.0 and state.bulb[i] > air.atmosphere:
        mass = vented(air, parameters.bulb_vent_area[i], state.bulb[i], parameters.bulb_volume[i])
        state.bulb[i] -= gas * mass / parameters.bulb_volume[i]
        lost += mass
    pipe = state.pipe[i] + gas * into_pipe / volume
    if state.position[i] == RELEASED:
        lost += _exhaust(air, parameters, state, i, parameters.exhaust_area[i])
        mass = exchanged(air, parameters.charge_area[i], pipe, volume, state.auxiliary[i], auxiliary_volume)
        state.auxiliary[i] += gas * mass / auxiliary_volume
        into_pipe -= mass
        into_pipe += _accelerated_release(air, parameters, state, i, pipe - gas * mass / volume)
        if parameters.emergency_volume[i] > 0.0 and pipe > state.emergency_reservoir[i]:
            reservoir = parameters.emergency_volume[i]
            mass = exchanged(air, parameters.charge_area[i], pipe, volume, state.emergency_reservoir[i], reservoir)
            state.emergency_reservoir[i] += gas * mass / reservoir
            into_pipe -= mass
    elif state.emergency[i] == 1.0:
        if parameters.emergency_volume[i] > 0.0:
            _join_emergency_reservoir(air, parameters, state, i)
        fast = state.cylinder[i] < air.atmosphere + parameters.fast_end[i]
        area = parameters.fast_area[i] if fast else parameters.slow_area[i]
        mass = _to_cylinder(air, parameters, state, i, area, state.auxiliary[i], auxiliary_volume)
        state.auxiliary[i] -= gas * mass / auxiliary_volume
    elif state.position[i] == APPLYING:
        over = state.auxiliary[i] - state.pipe[i] - parameters.lap_difference[i]
        area = parameters.service_area[i] * min(1.0, max(0.0, over / parameters.opening_difference[i]))
        mass = _to_cylinder(air, parameters, state, i, area, state.auxiliary[i], auxiliary_volume)
        state.auxiliary[i] -= gas * mass / auxiliary_volume
        if state.cylinder[i] < air.atmosphere + parameters.quick_service_end[i]:
            into_pipe -= _to_cylinder(air, parameters, state, i, parameters.quick_service_area[i], pipe, volume)
    state.inflow[i] += into_pipe
    return lost


@inner
def _accelerated_release(air: Record, parameters: AirParameters, state: AirState, i: int, pipe: float) -> float:
    """Mass that the reservoir of the accelerated release gives to the pipe [kg], or takes from it to be charged."""
    reservoir, volume = state.accelerated[i], parameters.accelerated_volume[i]
    if volume == 0.0:
        return 0.0
    if state.cylinder[i] < air.atmosphere + parameters.accelerated_end[i] or reservoir <= pipe:
        state.boosting[i] = 0.0
    if state.boosting[i] == 0.0 and reservoir >= pipe:
        return 0.0
    area = parameters.accelerated_area[i] if state.boosting[i] == 1.0 else parameters.charge_area[i]
    mass = exchanged(air, area, reservoir, volume, pipe, parameters.pipe_volume[i])
    state.accelerated[i] -= air.gas * mass / volume
    return mass


@inner
def _graduated_target(air: Record, parameters: AirParameters, state: AirState, i: int) -> float:
    """Pressure that the cylinder of an applied graduated valve is to have [Pa]."""
    asked = parameters.cylinder_ratio[i] * (state.control[i] - state.pipe[i])
    most = min(parameters.cylinder_most[i], parameters.cylinder_limit[i])
    return air.atmosphere + min(most, max(parameters.inshot[i], asked))


@inner
def _graduated_release(air: Record, parameters: AirParameters, state: AirState, i: int) -> float:
    """A graduated valve, such as a UIC distributor, for an air step; mass that left to the atmosphere [kg]."""
    gas, lost, into_pipe = air.gas, 0.0, 0.0
    pipe, volume, auxiliary_volume = state.pipe[i], parameters.pipe_volume[i], parameters.auxiliary_volume[i]
    difference = state.control[i] - pipe
    if state.position[i] == RELEASED:
        if difference > parameters.apply_difference[i]:
            state.position[i] = APPLYING
        else:
            lag = parameters.control_lag[i] + air.step
            state.control[i] -= difference * air.step / lag
    elif difference < parameters.release_difference[i]:
        state.position[i] = RELEASED
    if state.position[i] == RELEASED:
        lost += _exhaust(air, parameters, state, i, parameters.exhaust_area[i])
        bulb = vented(air, parameters.bulb_vent_area[i], state.bulb[i], parameters.bulb_volume[i])
        state.bulb[i] -= gas * bulb / parameters.bulb_volume[i]
        lost += bulb
    else:
        if pipe > state.bulb[i]:
            mass = exchanged(air, parameters.bulb_fill_area[i], pipe, volume, state.bulb[i], parameters.bulb_volume[i])
            state.bulb[i] += gas * mass / parameters.bulb_volume[i]
            into_pipe -= mass
        lacking = _graduated_target(air, parameters, state, i) - state.cylinder[i]
        part = min(1.0, abs(lacking) / parameters.opening_difference[i])
        if lacking > 0.0:
            area = part * parameters.service_area[i]
            mass = _to_cylinder(air, parameters, state, i, area, state.auxiliary[i], auxiliary_volume)
            state.auxiliary[i] -= gas * mass / auxiliary_volume
        else:
            lost += _exhaust(air, parameters, state, i, part * parameters.exhaust_area[i])
    pipe += gas * into_pipe / volume
    if pipe > state.auxiliary[i] and parameters.from_main_reservoir[i] == 0.0:
        mass = exchanged(air, parameters.charge_area[i], pipe, volume, state.auxiliary[i], auxiliary_volume)
        state.auxiliary[i] += gas * mass / auxiliary_volume
        into_pipe -= mass
    state.inflow[i] += into_pipe
    return lost


@inner
def _cut_out(air: Record, parameters: AirParameters, state: AirState, i: int) -> float:
    """A valve that is cut out from the pipe: its cylinder empties, its chambers wait where they will find the pipe."""
    state.position[i] = RELEASED
    state.emergency[i] = 0.0
    state.quick_service[i] = 0.0
    state.boosting[i] = 0.0
    state.vent_left[i] = 0.0
    state.chamber[i] = state.pipe[i]
    return _exhaust(air, parameters, state, i, parameters.exhaust_area[i])


@inner
def control_valves(air: Record, parameters: AirParameters, state: AirState) -> float:
    """All control valves, and the openings of the pipe, for an air step; mass that left to the atmosphere [kg]."""
    lost = 0.0
    for i in range(state.pipe.shape[0]):
        state.inflow[i] = 0.0
        state.cylinder_before[i] = state.cylinder[i]
        if state.cut_out[i] == 1.0:
            lost += _cut_out(air, parameters, state, i)
        elif parameters.kind[i] == DIRECT_RELEASE:
            lost += _direct_release(air, parameters, state, i)
        elif parameters.kind[i] == GRADUATED_RELEASE:
            lost += _graduated_release(air, parameters, state, i)
        if state.held_off[i] == 1.0:
            lost += _exhaust(air, parameters, state, i, parameters.exhaust_area[i])
        if state.hole[i] > 0.0:
            mass = vented(air, state.hole[i], state.pipe[i], parameters.pipe_volume[i])
            state.inflow[i] -= mass
            lost += mass
    return lost
