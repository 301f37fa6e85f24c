"""Which vehicles move as one mass: those joined by rigid drawbars (paper sec. 4.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.consist import Consist
from haul_ros.model.draft_gear import DraftGear


@dataclass(frozen=True, slots=True, eq=False)
class LumpedTrain:
    """A consist of v vehicles as m masses.

    ``mass`` (m,) [kg]; ``first`` and ``end`` (m,): index of the first vehicle of each mass and the one after its
    last; ``mass_index`` (v,): mass of each vehicle; ``gears`` (m - 1,): the draft gears between the masses;
    ``rigid`` (v - 1,): couplers that are drawbars.
    """

    mass: NDArray[np.float64]
    first: NDArray[np.int64]
    end: NDArray[np.int64]
    mass_index: NDArray[np.int64]
    gears: tuple[DraftGear, ...]
    rigid: NDArray[np.bool_]


def lump(consist: Consist) -> LumpedTrain:
    """Lump the vehicles of a consist."""
    behind_gears = [j + 1 for j, gear in enumerate(consist.couplers) if gear is not None]
    bounds = np.array([0, *behind_gears, len(consist.vehicles)], dtype=np.int64)
    sizes = np.diff(bounds)
    return LumpedTrain(
        mass=np.add.reduceat(np.array([vehicle.mass for vehicle in consist.vehicles]), bounds[:-1]),
        first=bounds[:-1],
        end=bounds[1:],
        mass_index=np.repeat(np.arange(len(sizes)), sizes),
        gears=tuple(gear for gear in consist.couplers if gear is not None),
        rigid=np.array([gear is None for gear in consist.couplers], dtype=bool),
    )
