"""What is known of a train at one instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """State of the train at one instant; arrays are copies, compression positive.

    ``time_ns`` is the simulation time in whole nanoseconds, from the step counter.
    Couplers (n_couplers,): stroke [m], stroke rate [m/s], force [N]. A rigid drawbar has stroke 0.
    Vehicles (n_vehicles,): chainage of the centre [m], speed [m/s], brake force [N] (against
    forward motion positive), brake cylinder pressure [Pa]. With a pneumatic brake also the gauge pressures of brake
    pipe and auxiliary reservoir [Pa], else None.
    """

    step: int
    time_ns: int
    stroke: FloatArray
    stroke_rate: FloatArray
    coupler_force: FloatArray
    chainage: FloatArray
    speed: FloatArray
    brake_force: FloatArray
    cylinder_pressure: FloatArray
    pipe_pressure: FloatArray | None = None
    auxiliary_pressure: FloatArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class CouplerExtremes:
    """Largest values per coupler since the start, of every time step.

    Arrays (n_couplers,): ``compression`` and ``tension`` are the largest buff and draft forces
    [N] as magnitudes (0 if the coupler never bore any), ``*_time`` when they occurred [s],
    ``compression_stroke`` and ``tension_stroke`` the largest strokes [m] as magnitudes,
    ``bottomed_time`` [s] when the gear first closed fully (NaN: never).
    """

    compression: FloatArray
    compression_time: FloatArray
    tension: FloatArray
    tension_time: FloatArray
    compression_stroke: FloatArray
    tension_stroke: FloatArray
    bottomed_time: FloatArray
