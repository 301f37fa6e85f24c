"""How a train stands, or runs, at t = 0."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from haul_ros.model.consist import Consist


class CouplerState(enum.Enum):
    """Where the draft gears stand in their slack."""

    FREE = "free"
    """In the middle of it."""
    STRETCHED = "stretched"
    """At its end in tension."""
    BUNCHED = "bunched"
    """At its end in compression."""


_SIDES = {CouplerState.FREE: 0.0, CouplerState.STRETCHED: -0.5, CouplerState.BUNCHED: 0.5}


@dataclass(frozen=True, slots=True)
class InitialAir:
    """Pressures of a pneumatic brake in every vehicle, gauge [Pa].

    With air in the cylinders the brakes are applied: control valves lapped, brake valves of the locomotives where they
    hold the pipe. Else all are released, and the locomotives charge the pipe.
    """

    pipe: float
    auxiliary: float
    cylinder: float


@dataclass(frozen=True, slots=True)
class InitialState:
    """What is not as in a train of free couplers and charged, released brakes; ``air`` None: they are so."""

    couplers: CouplerState = CouplerState.FREE
    air: InitialAir | None = None

    def strokes(self, consist: Consist) -> tuple[float, ...]:
        """Stroke of every coupler [m], compression positive; there is no force and no stored energy in it."""
        side = _SIDES[self.couplers]
        return tuple(side * gear.slack if gear else 0.0 for gear in consist.couplers)
