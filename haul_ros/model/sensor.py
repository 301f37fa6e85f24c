"""Instrumented couplers: what their sensors make of the true force and stroke."""

from __future__ import annotations

import math
from dataclasses import dataclass

from haul_ros.model.sample import FloatArray


@dataclass(frozen=True, slots=True)
class Transducer:
    """A sensor of one quantity: white Gaussian noise of a standard deviation, then steps of ``quantisation`` (0: none).

    It shows no more than ``span`` in either direction, or the last step within it. All in the unit of the quantity.
    """

    noise: float = 0.0
    quantisation: float = 0.0
    span: float = math.inf


@dataclass(frozen=True, slots=True)
class CouplerSensors:
    """Sensors of force, and of stroke if there are such, at couplers of these indices.

    They measure at every ``every``-th sample; all noise comes from ``seed``.
    """

    couplers: tuple[int, ...]
    every: int
    seed: int
    force: Transducer
    stroke: Transducer | None


@dataclass(frozen=True, slots=True, eq=False)
class CouplerMeasurement:
    """What the k instrumented couplers show at a simulation time [ns]; compression positive.

    Force [N] and stroke [m] (k,), None: no stroke is measured.
    """

    time_ns: int
    force: FloatArray
    stroke: FloatArray | None
