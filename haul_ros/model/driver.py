"""A driver as data: what he holds, when he brakes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CyclicBraking:
    """Air brake on a long descent: applied above ``apply_speed``, released below ``release_speed`` [m/s].

    ``demand`` of a normal application; after a release the reservoirs get ``recharge_time`` [s] before the next one,
    whatever the speed, but above ``full_service_speed`` [m/s] the driver takes full service at once.
    """

    apply_speed: float
    release_speed: float
    demand: float
    recharge_time: float
    full_service_speed: float


@dataclass(frozen=True, slots=True)
class DriverPlan:
    """A driver who looks at the speed of the head every ``reaction_time`` [s].

    ``speed`` [m/s] is held by traction of at most ``traction`` [N] and electric brake of at most ``electric_brake`` [N]
    at each locomotive, both in full from ``band`` [m/s] off it. ``cyclic`` None: no air brake, but where a speed limit
    asks for it: on a line with limits he keeps them, whatever his plan.
    """

    speed: float
    traction: float
    electric_brake: float
    band: float
    reaction_time: float
    cyclic: CyclicBraking | None = None
