"""Samples rounded as they are published and recorded; the simulation goes on with all bits."""

from __future__ import annotations

from dataclasses import replace
from typing import overload

import numpy as np

from haul_ros.model.recording_plan import Rounding
from haul_ros.model.sample import FloatArray, Sample


@overload
def _to(values: FloatArray, resolution: float) -> FloatArray: ...
@overload
def _to(values: None, resolution: float) -> None: ...
def _to(values: FloatArray | None, resolution: float) -> FloatArray | None:
    if values is None or resolution == 0.0:
        return values
    # By a power of two nothing but the rounding to a whole number is inexact; + 0 makes 0 of -0
    return np.rint(values / resolution) * resolution + 0.0


def rounded(sample: Sample, rounding: Rounding) -> Sample:
    """The sample with each quantity as the nearest multiple of its resolution, half-way the even one."""
    if not rounding.resolutions():
        return sample
    return replace(
        sample,
        stroke=_to(sample.stroke, rounding.stroke),
        stroke_rate=_to(sample.stroke_rate, rounding.stroke_rate),
        coupler_force=_to(sample.coupler_force, rounding.coupler_force),
        chainage=_to(sample.chainage, rounding.chainage),
        speed=_to(sample.speed, rounding.speed),
        brake_force=_to(sample.brake_force, rounding.brake_force),
        cylinder_pressure=_to(sample.cylinder_pressure, rounding.pressure),
        pipe_pressure=_to(sample.pipe_pressure, rounding.pressure),
        auxiliary_pressure=_to(sample.auxiliary_pressure, rounding.pressure),
    )
