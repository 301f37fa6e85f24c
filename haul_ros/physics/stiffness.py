"""What time step the stiffest contact of a train allows."""

from __future__ import annotations

import numpy as np

from haul_ros.model.consist import Consist
from haul_ros.model.draft_gear import DraftGear
from haul_ros.physics.hinges import side_hinges
from haul_ros.physics.kernel.data import LARGEST_SWING, PARTS
from haul_ros.physics.lumping import lump


def steepest_slope(gear: DraftGear) -> float:
    """Largest stiffness of a draft gear in buff or draft [N/m], its stop and the slope of its preload included."""
    sides = [side_hinges(gear, side) for side in (gear.compression, gear.tension)]
    return max(float(np.max(np.cumsum(loading))) for _, loading, _ in sides)


def largest_time_step(consist: Consist) -> tuple[float, str]:
    """Largest time step [s] whose smallest parts follow every contact of two masses, and the coupler that sets it.

    Infinite, with an empty name, for a train without draft gears.
    """
    lumped = lump(consist)
    slopes = {gear: steepest_slope(gear) for gear in set(lumped.gears)}
    names = [name for name, rigid in zip(consist.coupler_names, lumped.rigid, strict=True) if not rigid]
    steps = [
        (PARTS * LARGEST_SWING / float(np.sqrt(slopes[gear] * (1.0 / ahead + 1.0 / behind))), name)
        for gear, name, ahead, behind in zip(lumped.gears, names, lumped.mass[:-1], lumped.mass[1:], strict=True)
    ]
    return min(steps, default=(float("inf"), ""))
