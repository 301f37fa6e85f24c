"""Samples rounded to multiples of powers of two, exactly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.messages.rounding import rounded
from haul_ros.model.consist import Consist
from haul_ros.model.recording_plan import UNITS, Rounding
from haul_ros.model.sample import CouplerExtremes, Sample

ARRAYS = {
    "stroke": "stroke",
    "stroke_rate": "stroke_rate",
    "coupler_force": "coupler_force",
    "chainage": "chainage",
    "speed": "speed",
    "brake_force": "brake_force",
    "cylinder_pressure": "pressure",
    "pipe_pressure": "pressure",
    "auxiliary_pressure": "pressure",
}
"""The quantity of every array of a sample."""


def sample_of(value: float) -> Sample:
    return Sample(3, 60_000_000, **{name: np.array([value, -value]) for name in ARRAYS})


def test_every_array_of_a_sample_is_tried_here() -> None:
    assert set(ARRAYS) == {field.name for field in fields(Sample)} - {"step", "time_ns"}
    assert set(ARRAYS.values()) == set(UNITS)


@given(st.floats(-1e9, 1e9), st.integers(-30, 15))
def test_a_value_becomes_the_nearest_multiple_with_nothing_else_lost(value: float, exponent: int) -> None:
    resolution = 2.0**exponent
    found = rounded(sample_of(value), Rounding(**dict.fromkeys(UNITS, resolution)))
    for name in ARRAYS:
        for got, given_value in zip(getattr(found, name).tolist(), (value, -value), strict=True):
            exact = round(Fraction(given_value) / Fraction(resolution)) * Fraction(resolution)  # half to even
            assert Fraction(got) == exact, name
            assert not (got == 0.0 and np.signbit(got)), name


@pytest.mark.parametrize("quantity", UNITS)
def test_one_quantity_is_rounded_and_no_other(quantity: str) -> None:
    found = rounded(sample_of(0.7), Rounding(**{quantity: 0.5}))
    for name, of in ARRAYS.items():
        assert getattr(found, name).tolist() == ([0.5, -0.5] if of == quantity else [0.7, -0.7]), name
    assert (found.step, found.time_ns) == (3, 60_000_000)


def test_without_a_resolution_the_sample_stays_as_it_is() -> None:
    sample = sample_of(-0.0)
    assert rounded(sample, Rounding()) is sample
    assert rounded(sample, Rounding(speed=1.0)).stroke is sample.stroke


def test_an_encoder_rounds_samples_and_leaves_them_and_extremes_alone(
    consist: Consist, make_sample: Callable[[int], Sample], extremes: CouplerExtremes
) -> None:
    exact = TelemetryEncoder(consist)
    coarse = TelemetryEncoder(consist, rounding=Rounding(coupler_force=0.25, pressure=2.0))
    sample = make_sample(1)
    before = sample.coupler_force.tobytes()
    message, _, pressure = coarse.sample(sample)
    assert sample.coupler_force.tobytes() == before
    expected = np.array([round(Fraction(x) * 4) / 4 for x in sample.coupler_force.tolist()])
    assert coarse.decode_state(message)["force [N]"].tolist() == expected.tolist()
    assert set(coarse.decode_state(pressure)["pressure [Pa]"].tolist()) <= {-2.0, 0.0, 2.0}
    assert coarse.sample(replace(sample, coupler_force=expected))[0].data == message.data
    uneven = replace(extremes, compression=extremes.compression + 0.1)
    assert coarse.extremes(0, uneven) == exact.extremes(0, uneven)
