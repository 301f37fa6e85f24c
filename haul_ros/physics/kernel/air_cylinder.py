"""Brake cylinder of the pneumatic brake: its pressure from the air in it, while the piston moves out and after."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.air_data import AirParameters, AirState
from haul_ros.physics.kernel.data import Record


@inner
def cylinder_volume(air: Record, parameters: AirParameters, i: int, pressure: float) -> float:
    """Volume at a pressure [m^3]: the piston moves out as its spring yields, linearly up to ``cylinder_spring``."""
    out = (pressure - air.atmosphere) / parameters.cylinder_spring[i]
    out = min(1.0, max(0.0, out))
    return parameters.cylinder_clearance[i] + out * parameters.cylinder_displaced[i]


@inner
def cylinder_capacity(air: Record, parameters: AirParameters, i: int, pressure: float) -> float:
    """Volume that takes in as much air per pressure as the cylinder does [m^3]: d(p V)/dp."""
    volume = cylinder_volume(air, parameters, i, pressure)
    gauge = pressure - air.atmosphere
    if 0.0 <= gauge < parameters.cylinder_spring[i]:
        volume += pressure * parameters.cylinder_displaced[i] / parameters.cylinder_spring[i]
    return volume


@inner
def cylinder_pressure(air: Record, parameters: AirParameters, i: int, mass: float) -> float:
    """Pressure of the cylinder with a mass of air in it [Pa]."""
    clearance, displaced = parameters.cylinder_clearance[i], parameters.cylinder_displaced[i]
    product = air.gas * mass  # p V
    if product <= air.atmosphere * clearance:
        return product / clearance
    out = air.atmosphere + parameters.cylinder_spring[i]
    if displaced == 0.0 or product >= out * (clearance + displaced):
        return product / (clearance + displaced)
    # p (clearance + slope (p - atmosphere)) = p V
    slope = displaced / parameters.cylinder_spring[i]
    offset = clearance - slope * air.atmosphere
    root = (offset * offset + 4.0 * slope * product) ** 0.5
    return 2.0 * product / (root + offset) if offset > 0.0 else (root - offset) / (2.0 * slope)


@inner
def fill_cylinder(air: Record, parameters: AirParameters, state: AirState, i: int, mass: float) -> None:
    """Let a mass [kg] into the cylinder, or out of it if negative."""
    state.cylinder_air[i] += mass
    state.cylinder[i] = cylinder_pressure(air, parameters, i, state.cylinder_air[i])
