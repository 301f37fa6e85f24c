"""Natural vibrations of a train: frequencies and modes of the chain linearised about rest (paper eqs. 8 to 12)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.consist import Consist
from haul_ros.model.draft_gear import Curve, DraftGear
from haul_ros.physics.lumping import lump

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Modes:
    """Undamped free vibrations of a train of v vehicles that are m masses (rigid drawbars make one of several).

    ``frequencies`` (m,) [Hz] ascending; the first is 0, the train moving as a whole. ``shapes``
    (m, v): displacement of every vehicle in each mode, as mass-normalised vectors [kg^-1/2], that of the
    head not negative.
    """

    frequencies: Floats
    shapes: Floats


def stiffness_about_rest(gear: DraftGear) -> float:
    """Stiffness of a draft gear for small vibrations about stroke 0 [N/m].

    There the velocity method (paper eq. 5) gives the mean of the loading and the unloading curve, so
    this is the mean of their initial slopes, of buff and draft alike. Slack and preload are left out.
    """
    curves = (gear.compression.loading, gear.compression.unloading, gear.tension.loading, gear.tension.unloading)
    return sum(map(_initial_slope, curves)) / len(curves)


def _initial_slope(curve: Curve) -> float:
    (x0, f0), (x1, f1) = curve[:2]
    return (f1 - f0) / (x1 - x0)


def stiffness_matrix(stiffness: Floats) -> Floats:
    """Matrix K (m, m) [N/m] of a free chain from the stiffness (m - 1,) of its connections (paper eq. 9)."""
    diagonal = np.zeros(len(stiffness) + 1)
    diagonal[:-1] += stiffness
    diagonal[1:] += stiffness
    return np.diag(diagonal) - np.diag(stiffness, 1) - np.diag(stiffness, -1)


def natural_modes(consist: Consist) -> Modes:
    """Solve ``(K - omega^2 M) u = 0`` for the train, couplers near stroke 0 (paper eqs. 8 to 12)."""
    lumped = lump(consist)
    stiffness = np.array([stiffness_about_rest(gear) for gear in lumped.gears])
    # M^-1/2 K M^-1/2 is symmetric and has the same eigenvalues as M^-1 K.
    scale = 1.0 / np.sqrt(lumped.mass)
    eigenvalues, vectors = np.linalg.eigh(scale[:, None] * stiffness_matrix(stiffness) * scale)
    frequencies = np.sqrt(np.maximum(eigenvalues, 0.0)) / (2.0 * np.pi)
    frequencies[0] = 0.0  # nothing holds the train: what is left there is rounding
    shapes = (scale[:, None] * vectors).T
    shapes *= np.where(shapes[:, :1] < 0.0, -1.0, 1.0)
    return Modes(frequencies, shapes[:, lumped.mass_index])
