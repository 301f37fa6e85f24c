"""Flow of air: through an orifice, and along the brake pipe.

One-dimensional, isothermal; pressures are absolute. Mass that leaves one volume enters another or the atmosphere, so
what is in the train changes by nothing else.
"""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.air_data import AirParameters, AirState
from haul_ros.physics.kernel.data import Record

FLOW_FACTOR = 0.6847
"""sqrt(kappa (2/(kappa + 1))^((kappa + 1)/(kappa - 1))) of air: choked flow is this times area, pressure over c."""

CHOKED = 0.528
"""Ratio of pressures at which the flow through an orifice is choked [-]."""

NEARLY_EQUAL = 0.998
"""Ratio of pressures above which flow is taken as linear: a root of nothing would chatter."""

LAMINAR = 2300.0
"""Reynolds number below which flow in a pipe is laminar."""


@inner
def orifice_flow(area: float, first: float, second: float, root_gas: float) -> float:
    """Mass flow through an orifice between two pressures, from the first to the second positive [kg/s]."""
    high, low = max(first, second), min(first, second)
    ratio = low / high
    if ratio <= CHOKED:
        share = 1.0
    elif ratio <= NEARLY_EQUAL:
        share = (1.0 - ((ratio - CHOKED) / (1.0 - CHOKED)) ** 2) ** 0.5
    else:
        at_limit = (1.0 - ((NEARLY_EQUAL - CHOKED) / (1.0 - CHOKED)) ** 2) ** 0.5
        share = at_limit * (1.0 - ratio) / (1.0 - NEARLY_EQUAL)
    flow = FLOW_FACTOR * area * high / root_gas * share
    return flow if first >= second else -flow


@inner
def exchanged(
    air: Record, area: float, first: float, first_volume: float, second: float, second_volume: float
) -> float:
    """Mass that goes from the first to the second volume in an air step [kg], at most what makes them equal."""
    if area == 0.0 or first == second:
        return 0.0
    mass = orifice_flow(area, first, second, air.root_gas) * air.step
    most = (first - second) / (air.gas * (1.0 / first_volume + 1.0 / second_volume))
    return mass if abs(mass) <= abs(most) else most


@inner
def vented(air: Record, area: float, pressure: float, volume: float) -> float:
    """Mass that a volume loses to the atmosphere in an air step [kg], or draws from it if negative."""
    if area == 0.0:
        return 0.0
    mass = orifice_flow(area, pressure, air.atmosphere, air.root_gas) * air.step
    most = (pressure - air.atmosphere) * volume / air.gas
    return mass if abs(mass) <= abs(most) else most


@inner
def pipe_flow(air: Record, parameters: AirParameters, state: AirState) -> None:
    """Flow through every face at the end of an air step, from the pressures at its start; friction is implicit.

    ``dG/dt = A (p1 - p2)/dx - f G |G| / (2 D A rho) - d(G^2 / (rho A))/dx``, the last upwind.
    """
    pipe, flow, momentum, cock = state.pipe, state.flow, state.momentum, state.cock
    last = pipe.shape[0] - 1
    area, step, gas = air.pipe_area, air.step, air.gas
    viscous = area * air.viscosity / air.pipe_bore  # flow over its Reynolds number
    momentum[0] = 0.0
    momentum[last] = 0.0
    for i in range(1, last):
        mean = 0.5 * (flow[i - 1] + flow[i])
        upwind = flow[i - 1] if mean > 0.0 else flow[i]
        momentum[i] = mean * upwind * gas / (pipe[i] * area)
    per_density = gas / (air.pipe_bore * area)
    for i in range(last):
        length = parameters.face_length[i]
        slope = area * (pipe[i] - pipe[i + 1]) + momentum[i] - momentum[i + 1]
        size = abs(flow[i])
        # f |G|: 64 over the Reynolds number while laminar
        drag = 64.0 * viscous if size < LAMINAR * viscous else air.pipe_friction * size
        drag = drag if air.pipe_friction > 0.0 else 0.0
        damping = step * drag * per_density / (pipe[i] + pipe[i + 1])
        flow[i] = cock[i] * (flow[i] + step * slope / length) / (1.0 + damping)


@inner
def pipe_pressure(air: Record, parameters: AirParameters, state: AirState) -> None:
    """Pressure of every cell at the end of an air step, from the flows through its faces and what came in besides."""
    pipe, flow, inflow = state.pipe, state.flow, state.inflow
    last = pipe.shape[0] - 1
    step, gas = air.step, air.gas
    pipe[0] += gas / parameters.pipe_volume[0] * (inflow[0] - step * flow[0])
    for i in range(1, last):
        gain = step * (flow[i - 1] - flow[i]) + inflow[i]
        pipe[i] += gas / parameters.pipe_volume[i] * gain
    pipe[last] += gas / parameters.pipe_volume[last] * (inflow[last] + step * flow[last - 1])
