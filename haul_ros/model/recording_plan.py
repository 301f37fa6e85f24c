"""How much of a run is published and recorded: to what resolution, and how often."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType


def power_of_two(resolution: float) -> float:
    """The largest power of two that is not above a resolution; 0 of 0.

    Raises
    ------
    ValueError
        It is negative, infinite or not a number.
    """
    if not 0.0 <= resolution < math.inf:
        raise ValueError(f"resolution {resolution}: expected 0 or a positive number")
    return math.ldexp(0.5, math.frexp(resolution)[1]) if resolution else 0.0


UNITS = MappingProxyType(
    {
        "coupler_force": "N",
        "stroke": "m",
        "stroke_rate": "m/s",
        "chainage": "m",
        "speed": "m/s",
        "brake_force": "N",
        "pressure": "Pa",
    }
)
"""Of the resolutions, by quantity."""


@dataclass(frozen=True, slots=True)
class Rounding:
    """Resolution of each quantity of a sample as it is published and recorded, a power of two; 0: all its bits.

    Force of couplers and brakes [N], stroke [m] and its rate [m/s], chainage [m], speed [m/s] and all pressures [Pa].

    Raises
    ------
    ValueError
        A resolution is no power of two.
    """

    coupler_force: float = 0.0
    stroke: float = 0.0
    stroke_rate: float = 0.0
    chainage: float = 0.0
    speed: float = 0.0
    brake_force: float = 0.0
    pressure: float = 0.0

    def __post_init__(self) -> None:
        for name in UNITS:
            if power_of_two(resolution := getattr(self, name)) != resolution:
                raise ValueError(f"resolution of {name} = {resolution}: expected a power of two")

    def resolutions(self) -> dict[str, float]:
        """Those above 0, by quantity."""
        return {name: value for name in UNITS if (value := getattr(self, name))}


@dataclass(frozen=True, slots=True)
class RecordingPlan:
    """What is published and recorded of the samples: all rounded alike, every ``every``-th in the recording."""

    every: int = 1
    rounding: Rounding = Rounding()
