"""What a reduction of the brake pipe asks of the cylinders, in closed form: volumes alone, no time, no flow."""

from __future__ import annotations

import math

import numpy as np

from haul_ros.model.air_brake import ATMOSPHERE, ControlValve, PneumaticBrake, Release
from haul_ros.model.consist import Consist
from haul_ros.model.sample import FloatArray

_BISECTIONS = 60


def cylinder_pressures_for(brake: PneumaticBrake, consist: Consist, pipe_pressure: float) -> FloatArray:
    """Gauge pressure [Pa] that every cylinder (n_vehicles,) is to have with the pipe at a gauge pressure [Pa].

    From a charged train: of a direct-release valve what the auxiliary reservoir gives until it has come down to the
    pipe, or to the cylinder; of a graduated one its law. Quick service only adds to that.
    """
    by_name = {
        name: _asked(valve, brake.pressure, pipe_pressure, brake.cylinder_limits.get(name, math.inf))
        for name, valve in brake.valves.items()
    }
    return np.array([by_name[vehicle.name] for vehicle in consist.vehicles])


def _asked(valve: ControlValve, charged: float, pipe: float, limit: float) -> float:
    if pipe >= charged:
        return 0.0
    if valve.release is Release.GRADUATED:
        law = min(valve.cylinder_most, max(valve.inshot, valve.cylinder_ratio * (charged - pipe)))
        return min(law, limit)
    low, high = pipe, charged  # of the reservoir, which comes down to the pipe unless the cylinder is full before
    if _given(valve, charged - low) > low:
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if _given(valve, charged - middle) > middle else (low, middle)
    return min(_given(valve, charged - low), limit)


def _given(valve: ControlValve, fall: float) -> float:
    """Gauge pressure of a cylinder with what the auxiliary reservoir gives while it falls by a pressure."""
    air = valve.auxiliary_volume * fall + ATMOSPHERE * valve.cylinder_clearance  # p V
    return air / (valve.cylinder_clearance + valve.cylinder_displaced) - ATMOSPHERE
