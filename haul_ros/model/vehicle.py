"""Vehicles: mass, length, running resistance and brake rigging."""

from __future__ import annotations

import math
from dataclasses import dataclass

from haul_ros.units import kmh_to_mps


@dataclass(frozen=True, slots=True)
class RunningResistance:
    """Specific running resistance ``w(v) = constant + linear v + quadratic v^2`` (TB/T 1407-1998).

    Force per weight [N/N]; ``v`` is the speed's magnitude [m/s], not below ``minimum_speed``.
    ``starting`` [N/N] is what has to be overcome to set a standing vehicle in motion.
    """

    constant: float
    linear: float
    quadratic: float
    starting: float
    minimum_speed: float = kmh_to_mps(10.0)


@dataclass(frozen=True, slots=True)
class ShoeFriction:
    """Friction coefficient of a brake shoe, the form shared by all shoes of TB/T 1407-1998 (paper eq. 3).

    ``phi = scale (K + k_offset)/(k_gain K + k_offset) (n_slope v + n_offset)/(d_slope v + d_offset)
    + v0_slope (v0_reference - v0)`` with the shoe force K [N], the speed v and the speed v0 at
    which this brake application began [m/s].
    """

    scale: float
    k_offset: float
    k_gain: float
    n_slope: float
    n_offset: float
    d_slope: float
    d_offset: float
    v0_slope: float = 0.0
    v0_reference: float = 0.0

    def coefficient(self, shoe_force: float, speed: float, initial_speed: float) -> float:
        """Friction coefficient [-] at a shoe force [N], a speed and an initial speed [m/s]."""
        pressure = self.scale * (shoe_force + self.k_offset) / (self.k_gain * shoe_force + self.k_offset)
        by_speed = (self.n_slope * speed + self.n_offset) / (self.d_slope * speed + self.d_offset)
        return pressure * by_speed + self.v0_slope * (self.v0_reference - initial_speed)


def shoe_force_from_cylinder(
    diameter: float, pressure: float, efficiency: float, leverage_ratio: float, cylinders: int, shoes: int
) -> float:
    """Force on one brake shoe [N]: ``K = (pi/4) d^2 p eta gamma n_cyl / n_shoes`` (paper eq. 4).

    ``diameter`` [m] and ``pressure`` [Pa] are those of the brake cylinder.
    """
    return math.pi / 4.0 * diameter**2 * pressure * efficiency * leverage_ratio * cylinders / shoes


@dataclass(frozen=True, slots=True)
class Adhesion:
    """Adhesion coefficient ``constant + numerator / (offset + v)`` with v, numerator and offset in m/s."""

    constant: float
    numerator: float
    offset: float

    def coefficient(self, speed: float) -> float:
        """At a speed [m/s]."""
        return self.constant + self.numerator / (self.offset + speed)


@dataclass(frozen=True, slots=True)
class ElectricBrake:
    """Electric brake of a locomotive.

    At most ``max_force`` [N] and ``max_power`` [W]; below ``fade_speed`` [m/s] it fades linearly to nothing at rest.
    ``stays_in_emergency``: an emergency does not end it; ``interlock``: while it acts, the locomotive's own air brake
    is held off, but in an emergency.
    """

    max_force: float = 0.0
    max_power: float = math.inf
    fade_speed: float = kmh_to_mps(10.0)
    stays_in_emergency: bool = False
    interlock: bool = False


@dataclass(frozen=True, slots=True)
class VehicleType:
    """One kind of wagon or locomotive.

    Mass [kg], length over couplers [m]; ``shoe_force`` [N] is the force on each of the ``shoes``
    brake shoes and ``cylinder_pressure`` [Pa] the brake cylinder pressure, both in a fully
    developed emergency application; ``max_tractive_effort`` [N] is 0 for a wagon, ``max_power`` [W] that of its
    traction, infinite: without a limit. Tractive effort falls linearly from the largest, at rest, to
    ``continuous_effort`` [N] at ``continuous_speed`` [m/s] (0: it does not). An effort takes ``effort_rise_time`` [s]
    from nothing to the largest (0: at once); between traction and electric braking ``changeover_time`` [s] pass.
    ``adhesion`` None: the rails take everything.
    """

    name: str
    mass: float
    length: float
    resistance: RunningResistance
    shoes: int
    shoe_force: float
    friction: ShoeFriction
    cylinder_pressure: float
    max_tractive_effort: float = 0.0
    max_power: float = math.inf
    continuous_effort: float = 0.0
    continuous_speed: float = 0.0
    effort_rise_time: float = 0.0
    changeover_time: float = 0.0
    electric_brake: ElectricBrake = ElectricBrake()
    adhesion: Adhesion | None = None
