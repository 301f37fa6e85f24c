"""What a page's arrays give when they are taken apart as its scripts do it."""

from __future__ import annotations

import base64
import zlib

import numpy as np

from haul_ros.model.sample import FloatArray
from haul_ros.page.packing import packed_multiples, packed_numbers


def unpacked(packed: dict[str, object]) -> FloatArray:
    """As unpacking.js: low bytes, then high bytes of differences modulo 2^16, row by row."""
    data = np.frombuffer(zlib.decompress(base64.b64decode(str(packed["packed"]))), np.uint8).astype(np.int64)
    rows, step = packed["rows"], packed["step"]
    assert isinstance(rows, int)
    assert isinstance(step, float)
    half = len(data) // 2
    differences = (data[:half] + 256 * data[half:]).reshape(-1, rows)
    whole = np.cumsum(differences, axis=0).astype(np.uint16).view(np.int16)
    return np.where(whole == -32768, np.nan, whole * step)


def test_every_value_comes_back_to_half_a_step() -> None:
    values = np.random.default_rng(1).normal(scale=700.0, size=(50, 7))
    values[3, 2], values[4, 2] = 3e3, -3e3  # from end to end of 16 bit
    packed = packed_multiples(values)
    assert packed["step"] == 3e3 / 32767
    np.testing.assert_allclose(unpacked(packed), values, rtol=0.0, atol=0.5 * 3e3 / 32767 * (1 + 1e-9))


def test_what_is_no_number_is_none_in_the_page_and_spoils_no_other() -> None:
    values = np.array([[1.0, 2.0], [np.nan, np.inf], [3.0, -4.0]])
    found = unpacked(packed_multiples(values))
    assert np.isnan(found[1]).all()
    np.testing.assert_allclose(found[[0, 2]], values[[0, 2]], atol=1e-4)


def test_zeros_stay_zeros() -> None:
    assert not unpacked(packed_multiples(np.zeros((3, 2)))).any()


def test_times_keep_all_their_bits() -> None:
    times = np.array([0.0, 0.1, 1e9 / 3])
    data = zlib.decompress(base64.b64decode(packed_numbers(times)))
    assert np.frombuffer(data, "<f8").tolist() == times.tolist()
