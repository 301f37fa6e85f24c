"""The pneumatic brake: pipe, control valves of the vehicles, brake valves of the locomotives. Gauge pressures."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass

ATMOSPHERE = 101_325.0
"""Absolute pressure of the atmosphere [Pa]."""


class Release(enum.Enum):
    """How a control valve releases."""

    DIRECT = "direct"
    """All at once when the pipe rises, as the 120 and AAR valves."""
    GRADUATED = "graduated"
    """By as much as the pipe rises, as a UIC distributor."""


@dataclass(frozen=True, slots=True)
class BrakePipe:
    """The brake pipe: bore [m], its length over that of the vehicle [-], volume of a vehicle's branch [m^3],
    friction factor of turbulent flow [-] (0: no friction at all), temperature of the air [K]."""

    bore: float
    length_ratio: float
    branch_volume: float
    friction_factor: float
    temperature: float


@dataclass(frozen=True, slots=True)
class ControlValve:
    """Control valve of a vehicle with its reservoirs and brake cylinder.

    ``from_main_reservoir``: of a locomotive with a brake valve (graduated release), whose cylinder its main reservoir
    fills in the place of an auxiliary one. Volumes [m^3]; bores [m], 0: there is none; differences and ends of stages
    are pressures [Pa]. What each is for, and which of the two kinds of valve uses it:
    `haul_ros.physics.kernel.air_data.AirParameters`, by the same names.
    """

    release: Release
    auxiliary_volume: float
    cylinder_clearance: float
    cylinder_displaced: float
    cylinder_spring: float
    charge_bore: float
    service_bore: float
    exhaust_bore: float
    apply_difference: float
    release_difference: float
    opening_difference: float
    bulb_volume: float = 0.0
    bulb_fill_bore: float = 0.0
    bulb_vent_bore: float = 0.0
    lap_difference: float = 0.0
    reapply_difference: float = 0.0
    quick_service_difference: float = math.inf
    quick_service_bore: float = 0.0
    quick_service_end: float = 0.0
    emergency_difference: float = math.inf
    emergency_lag: float = 0.0
    vent_bore: float = 0.0
    vent_time: float = 0.0
    fast_bore: float = 0.0
    fast_end: float = 0.0
    slow_bore: float = 0.0
    emergency_volume: float = 0.0
    accelerated_volume: float = 0.0
    accelerated_bore: float = 0.0
    accelerated_end: float = 0.0
    cylinder_ratio: float = 0.0
    cylinder_most: float = 0.0
    inshot: float = 0.0
    control_lag: float = 0.0
    from_main_reservoir: bool = False


@dataclass(frozen=True, slots=True)
class DriverValve:
    """Brake valve, main reservoir and compressor of every locomotive.

    ``equalising_down``, ``equalising_up``: rates of the equalising reservoir [Pa/s]; relay with a ``dead_band`` and
    fully open ``relay_span`` beyond it [Pa]; bores [m]; an emergency felt as by a control valve;
    ``feed_cut_difference``: of a charged pipe below the equalising reservoir, at which the feed is closed [Pa];
    ``maintaining``: the feed stays open in a service application. Main reservoir [m^3]; the compressor runs from
    ``compressor_on`` to ``compressor_off`` [Pa] and gives ``compressor_flow`` of free air [m^3/s].
    """

    equalising_down: float
    equalising_up: float
    dead_band: float
    relay_span: float
    exhaust_bore: float
    feed_bore: float
    emergency_bore: float
    emergency_difference: float
    emergency_lag: float
    vent_time: float
    feed_cut_difference: float
    maintaining: bool
    main_reservoir_volume: float
    compressor_flow: float
    compressor_on: float
    compressor_off: float


@dataclass(frozen=True)
class PneumaticBrake:
    """The brake of a whole train.

    ``pressure``: of the charged pipe [Pa]; a brake demand asks for a reduction of it, from ``least_reduction`` to
    ``full_reduction`` [Pa]; ``step`` [s] of the flow in the pipe; ``discharge`` coefficient of all bores [-];
    ``valves`` by the name of the vehicle type, and ``cylinder_limits`` [Pa] of those with a load device.
    """

    pressure: float
    least_reduction: float
    full_reduction: float
    step: float
    discharge: float
    pipe: BrakePipe
    driver_valve: DriverValve
    valves: Mapping[str, ControlValve]
    cylinder_limits: Mapping[str, float]

    def pressure_for(self, demand: float) -> float:
        """Pressure of the equalising reservoir [Pa] for a brake demand 0 (released) to 1 (full service)."""
        if demand <= 0.0:
            return self.pressure
        return self.pressure - self.least_reduction - demand * (self.full_reduction - self.least_reduction)

    def demand_at(self, pressure: float) -> float:
        """The demand, 0 to 1, that asks for a pressure of the equalising reservoir [Pa], or the nearest to it."""
        if pressure >= self.pressure:
            return 0.0
        asked = (self.pressure - self.least_reduction - pressure) / (self.full_reduction - self.least_reduction)
        return min(1.0, max(0.0, asked))
