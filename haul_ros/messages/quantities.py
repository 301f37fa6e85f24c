"""Which quantity of the train is which array of a message, once for writing and for reading."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from haul_ros.messages.cdr import ArrayCodec, JointStateCodec
from haul_ros.model.sample import CouplerExtremes, FloatArray, Sample
from haul_ros.model.sensor import CouplerMeasurement


class CouplerArrays(NamedTuple):
    """Position, velocity and effort of ``~/couplers``: stroke [m], stroke rate [m/s] and force [N]."""

    stroke: FloatArray
    stroke_rate: FloatArray
    force: FloatArray


COUPLER_QUANTITIES = ("stroke [m]", "stroke rate [m/s]", "force [N]")


class VehicleArrays(NamedTuple):
    """Position, velocity and effort of ``~/vehicles``: chainage of the centre [m], speed [m/s] and brake force [N]."""

    chainage: FloatArray
    speed: FloatArray
    brake_force: FloatArray


VEHICLE_QUANTITIES = ("chainage [m]", "speed [m/s]", "brake force [N]")

MEASURED_QUANTITIES = ("measured stroke [m]", "measured stroke rate [m/s]", "measured force [N]")
"""Of ``~/measured_couplers``; the rate is empty, and so is the stroke where it is not measured."""

PRESSURE_QUANTITY = "pressure [Pa]"


class ExtremeArrays(NamedTuple):
    """Extremes of ``~/max_compression`` and its ``_time``, or of ``~/max_tension`` and its ``_time``.

    Largest stroke [m] and largest force [N], both negative in tension, and the simulation time [s] at which that force
    occurred. Older versions had the time in velocity, which has no meaning for an extreme and is 0.
    """

    stroke: FloatArray
    time: FloatArray
    force: FloatArray


EXTREME_QUANTITIES = ("stroke [m]", "velocity", "force [N]")

TIME_QUANTITY = "time [s]"


def coupler_arrays(sample: Sample) -> CouplerArrays:
    """What a message of couplers holds of a sample."""
    return CouplerArrays(stroke=sample.stroke, stroke_rate=sample.stroke_rate, force=sample.coupler_force)


def vehicle_arrays(sample: Sample) -> VehicleArrays:
    """What a message of vehicles holds of a sample."""
    return VehicleArrays(chainage=sample.chainage, speed=sample.speed, brake_force=sample.brake_force)


def measured_codec(names: Sequence[str], *, stroke: bool) -> JointStateCodec:
    """Codec of ``~/measured_couplers`` with or without stroke."""
    return JointStateCodec(names, without=("velocity",) if stroke else ("position", "velocity"))


def measured_arrays(measurement: CouplerMeasurement) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Position, velocity and effort of ``~/measured_couplers``: stroke [m], nothing, and force [N]."""
    none = np.empty(0)
    return (none if measurement.stroke is None else measurement.stroke, none, measurement.force)


def pressure_arrays(sample: Sample) -> tuple[FloatArray, ...]:
    """Pressures of a sample [Pa]: of the cylinders, then of pipe and reservoirs if there are any."""
    every = (sample.cylinder_pressure, sample.pipe_pressure, sample.auxiliary_pressure)
    return tuple(pressure for pressure in every if pressure is not None)


def pressure_codec(vehicles: int) -> ArrayCodec:
    """Codec of ``~/brake_cylinder_pressure``, and of the other pressures, of so many vehicles [Pa]."""
    return ArrayCodec("vehicle", vehicles)


def time_codec(couplers: int) -> ArrayCodec:
    """Codec of ``~/max_compression_time`` and ``~/max_tension_time`` of so many couplers [s]."""
    return ArrayCodec("coupler", couplers)


def extreme_arrays(extremes: CouplerExtremes) -> tuple[ExtremeArrays, ExtremeArrays]:
    """Arrays of the messages of the largest compression and the largest tension."""
    compression = ExtremeArrays(
        stroke=extremes.compression_stroke, time=extremes.compression_time, force=extremes.compression
    )
    # 0 - x rather than -x: a coupler never in tension shows 0, not -0
    tension = ExtremeArrays(
        stroke=0.0 - extremes.tension_stroke, time=extremes.tension_time, force=0.0 - extremes.tension
    )
    return compression, tension


def extremes_of(compression: ExtremeArrays, tension: ExtremeArrays) -> CouplerExtremes:
    """The extremes of which `extreme_arrays` are these; ``bottomed_time`` is in no message and NaN throughout."""
    return CouplerExtremes(
        compression=compression.force,
        compression_time=compression.time,
        tension=0.0 - tension.force,
        tension_time=tension.time,
        compression_stroke=compression.stroke,
        tension_stroke=0.0 - tension.stroke,
        bottomed_time=np.full(len(compression.force), np.nan),
    )
