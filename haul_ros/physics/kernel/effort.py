"""What a locomotive gives of the traction and electric braking that is asked for: curves, power, adhesion, rates."""

from __future__ import annotations

import numpy as np

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.data import Floats, Ints, MassState, VehicleParameters, VehicleState, VehicleTrial


@inner
def limited_effort(demand: float, max_power: float, speed: float) -> float:
    """Effort [N]: what is asked for, or what the power [W] gives at a speed [m/s] of either sign."""
    speed = abs(speed)
    return demand if demand * speed <= max_power else max_power / speed


@inner
def _adhesion(parameters: VehicleParameters, i: int, speed: float) -> float:
    """What the rails can take at a speed [N]."""
    coefficient = parameters.adhesion_constant[i] + parameters.adhesion_numerator[i] / (
        parameters.adhesion_offset[i] + speed
    )
    return coefficient * parameters.weight[i]


@inner
def effort_at(parameters: VehicleParameters, i: int, demand: float, velocity: float) -> float:
    """Tractive effort, or negative electric brake, that a vehicle gives at a velocity [N], forward positive.

    Traction: at most curve, power over speed, adhesion. Electric brake: at most its force, power over speed, adhesion,
    fading linearly to nothing at rest; it opposes motion.
    """
    speed = abs(velocity)
    adhesion = _adhesion(parameters, i, speed)
    if demand >= 0.0:
        curve = parameters.max_effort[i] - parameters.effort_slope[i] * min(speed, parameters.effort_speed[i])
        return limited_effort(min(demand, curve, adhesion), parameters.max_power[i], speed)
    force = limited_effort(min(-demand, parameters.max_electric_brake[i]), parameters.electric_power[i], speed)
    force = min(force, adhesion)
    fade = parameters.electric_fade_speed[i]
    if speed < fade:
        force *= speed / fade
    return -force if velocity >= 0.0 else force


@inner
def _followed(parameters: VehicleParameters, vehicles: VehicleState, i: int, h: float) -> float:
    """Demand at the end of a step: what is asked for, as fast as the vehicle follows."""
    asked, demand = vehicles.effort_asked[i], vehicles.traction_demand[i]
    if asked == demand or parameters.effort_rate[i] == np.inf:
        return demand
    if asked * vehicles.effort_sense[i] < 0.0 and demand * vehicles.effort_sense[i] <= 0.0:
        goal = asked if vehicles.changeover_left[i] <= 0.0 else 0.0
    else:
        goal = 0.0 if asked * demand < 0.0 else asked
    change = parameters.effort_rate[i] * h
    return max(goal, demand - change) if goal < demand else min(goal, demand + change)


@inner
def tractive_efforts(
    parameters: VehicleParameters,
    vehicles: VehicleState,
    masses: MassState,
    mass_index: Ints,
    trial: VehicleTrial,
    h: float,
) -> None:
    """Efforts of every vehicle at the end of a step, at the speed that the acceleration predicts."""
    effort, demand = trial.traction, trial.traction_demand
    for i in range(effort.shape[0]):
        m = mass_index[i]
        speed = masses.velocity[m] + h * masses.acceleration[m]
        demand[i] = _followed(parameters, vehicles, i, h)
        effort[i] = effort_at(parameters, i, demand[i], speed) if demand[i] != 0.0 else 0.0


@inner
def commit_efforts(
    parameters: VehicleParameters,
    vehicles: VehicleState,
    trial: VehicleTrial,
    velocity: Floats,
    mass_index: Ints,
    h: float,
) -> None:
    """Work of the efforts that a step was done with, by the trapezoidal rule, and the efforts at its end.

    The step was done at a speed that was predicted, so that efforts do not change while Newton iterates; contacts may
    have made the locomotive faster. The next step starts from what is given at the ``velocity`` (m,) found.
    """
    for i in range(vehicles.traction.shape[0]):
        demand = trial.traction_demand[i]
        if vehicles.traction[i] == 0.0 and demand == 0.0:
            vehicles.changeover_left[i] -= h
            vehicles.traction_in_force[i] = 0.0
            continue
        work = 0.5 * (vehicles.traction[i] + trial.traction[i]) * trial.displacement_change[i]
        if vehicles.traction_in_force[i] < 0.0 or demand < 0.0:  # an emergency may have ended the demand meanwhile
            vehicles.electric_work[i] -= work
        else:
            vehicles.traction_work[i] += work
        vehicles.traction[i] = effort_at(parameters, i, demand, velocity[mass_index[i]]) if demand != 0.0 else 0.0
        vehicles.traction_demand[i] = demand
        vehicles.traction_in_force[i] = demand
        if demand != 0.0:
            vehicles.effort_sense[i] = np.sign(demand)
            vehicles.changeover_left[i] = parameters.changeover_time[i]


@inner
def stop_pulling(vehicles: VehicleState, i: int) -> None:
    """A vehicle gives no tractive effort any more; an electric brake stays."""
    vehicles.effort_asked[i] = min(vehicles.effort_asked[i], 0.0)
    vehicles.traction_demand[i] = min(vehicles.traction_demand[i], 0.0)


@inner
def drop_efforts(parameters: VehicleParameters, vehicles: VehicleState, i: int) -> None:
    """An emergency has reached a vehicle: traction ends at once, the electric brake too unless it is to stay."""
    stays = parameters.electric_in_emergency[i] == 1.0
    vehicles.effort_asked[i] = min(vehicles.effort_asked[i], 0.0) if stays else 0.0
    vehicles.traction_demand[i] = min(vehicles.traction_demand[i], 0.0) if stays else 0.0
