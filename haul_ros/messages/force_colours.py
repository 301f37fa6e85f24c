"""Colours of coupler forces: red is compression (buff), blue tension (draft), nearly white none."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_ANCHORS = (
    (0x05, 0x30, 0x61),
    (0x21, 0x66, 0xAC),
    (0x43, 0x93, 0xC3),
    (0x92, 0xC5, 0xDE),
    (0xD1, 0xE5, 0xF0),
    (0xF7, 0xF7, 0xF7),
    (0xFD, 0xDB, 0xC7),
    (0xF4, 0xA5, 0x82),
    (0xD6, 0x60, 0x4D),
    (0xB2, 0x18, 0x2B),
    (0x67, 0x00, 0x1F),
)
"""RdBu of ColorBrewer (Brewer 2003), reversed: safe for the colour-blind, and as in the figures of `analysis`."""
_SHADES = 255


def _palette() -> NDArray[np.uint8]:
    at = np.linspace(0.0, len(_ANCHORS) - 1.0, _SHADES)
    channels = [np.interp(at, range(len(_ANCHORS)), channel) for channel in zip(*_ANCHORS, strict=True)]
    shades: NDArray[np.uint8] = np.rint(np.stack(channels, axis=-1)).astype(np.uint8)
    return shades


_PALETTE = _palette()


def force_colours(force: ArrayLike, limit: float) -> NDArray[np.uint8]:
    """Red, green and blue (..., 3) of forces (...) [N], compression positive; all beyond ``limit`` [N] look alike."""
    share = np.clip(np.asarray(force, np.float64) / limit, -1.0, 1.0)
    return _PALETTE[np.rint((share + 1.0) * ((_SHADES - 1) / 2)).astype(np.intp)]
