"""Arrays as text in a page: whole multiples of a step in 16 bit, differenced, deflated, base64."""

from __future__ import annotations

import base64
import zlib

import numpy as np

from haul_ros.model.sample import FloatArray

_LARGEST = 32767
_NO_NUMBER = -32768
_LEVEL = 6


def packed_numbers(values: FloatArray) -> str:
    """Values (n,) with all their bits, for few of them."""
    return _text(np.ascontiguousarray(values, "<f8").tobytes())


def packed_multiples(values: FloatArray) -> dict[str, object]:
    """Values (n, k) as their nearest multiples of `packing_step`; what is not finite is NaN.

    Differences from one row to the next are taken modulo 2^16, and their low bytes stand before all high bytes, for
    that is what compresses.
    """
    finite, step = np.isfinite(values), packing_step(values)
    whole = np.where(finite, np.rint(np.where(finite, values, 0.0) / step), _NO_NUMBER).astype(np.int16)
    differences = whole.astype("<u2", casting="unsafe")
    differences[1:] -= differences[:-1].copy()
    planes = differences.reshape(-1, 1).view(np.uint8).T
    return {"step": step, "rows": values.shape[1], "packed": _text(np.ascontiguousarray(planes).tobytes())}


def packing_step(values: FloatArray) -> float:
    """The resolution of packed values: the largest has 32767 steps."""
    largest = float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0))
    return largest / _LARGEST if largest > 0.0 else 1.0


def _text(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, _LEVEL)).decode("ascii")
