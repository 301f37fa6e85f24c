"""What a recording gives back: quantities of the train over time, as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.sample import CouplerExtremes, FloatArray

TimeArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class CouplerSeries:
    """The k couplers ``names`` at ``time_ns`` (n,): stroke [m], stroke rate [m/s], force [N] (n, k).

    Compression is positive.
    """

    time_ns: TimeArray
    names: tuple[str, ...]
    stroke: FloatArray
    stroke_rate: FloatArray
    force: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class VehicleSeries:
    """The k vehicles ``names`` at ``time_ns`` (n,): chainage [m], speed [m/s], brake force [N] (n, k)."""

    time_ns: TimeArray
    names: tuple[str, ...]
    chainage: FloatArray
    speed: FloatArray
    brake_force: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class PressureSeries:
    """A pressure of the brake [Pa] (n, k) of the k vehicles ``names`` at ``time_ns`` (n,)."""

    time_ns: TimeArray
    names: tuple[str, ...]
    pressure: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredSeries:
    """What the sensors of the k couplers ``names`` showed at ``time_ns`` (n,): stroke [m] and force [N] (n, k).

    ``stroke`` is None where none is measured. Compression is positive.
    """

    time_ns: TimeArray
    names: tuple[str, ...]
    stroke: FloatArray | None
    force: FloatArray


class ScalarSeries(NamedTuple):
    """A number over time: ``time_ns`` (n,) and ``values`` (n,); a Bool is 0 or 1."""

    time_ns: TimeArray
    values: FloatArray


class Samples(NamedTuple):
    """What was sampled of the train."""

    couplers: CouplerSeries
    vehicles: VehicleSeries
    pressure: PressureSeries


class RecordedExtremes(NamedTuple):
    """Largest values per coupler as recorded at ``time_ns``; ``bottomed_time`` is not recorded and NaN throughout."""

    time_ns: int
    extremes: CouplerExtremes
