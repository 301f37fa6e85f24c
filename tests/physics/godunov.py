"""Isothermal flow in a pipe that is closed at one end and has a hole at the other: a reference for the brake pipe.

Conservative variables, HLL fluxes, forward Euler at a Courant number of 0.4, friction implicit. Nothing of it is taken
from the package: neither scheme nor mesh nor formulas.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_GAS = 287.0 * 293.0
_ATMOSPHERE = 101_325.0


class OpenPipe:
    """Cells of given lengths [m], each divided ``refinement`` times; a hole of an effective area [m^2] in the first."""

    def __init__(
        self,
        lengths: NDArray[np.float64],
        *,
        bore: float,
        friction: float,
        pressure: float,
        hole: float,
        refinement: int,
    ) -> None:
        self._sizes = np.repeat(lengths / refinement, refinement)
        self._refinement = refinement
        self._lengths = lengths
        self._bore, self._friction, self._hole = bore, friction, hole
        self._area = np.pi / 4.0 * bore**2
        self._density = np.full(len(self._sizes), pressure / _GAS)
        self._momentum = np.zeros(len(self._sizes))  # rho u
        self._time = 0.0

    def pressures_at(self, seconds: float) -> NDArray[np.float64]:
        """Mean pressure of every given cell [Pa]."""
        sound = np.sqrt(_GAS)
        while self._time < seconds:
            velocity = self._momentum / self._density
            step = min(0.4 * float((self._sizes / (np.abs(velocity) + sound)).min()), seconds - self._time)
            self._advance(step)
            self._time += step
        weights = (self._density * self._sizes).reshape(len(self._lengths), self._refinement).sum(axis=1)
        return np.asarray(_GAS * weights / self._lengths)

    def _advance(self, step: float) -> None:
        sound = np.sqrt(_GAS)
        # closed ends: the gas beyond them is the mirror image
        density = np.concatenate(([self._density[0]], self._density, [self._density[-1]]))
        momentum = np.concatenate(([-self._momentum[0]], self._momentum, [-self._momentum[-1]]))
        velocity = momentum / density
        slow = np.minimum(velocity[:-1], velocity[1:]) - sound
        fast = np.maximum(velocity[:-1], velocity[1:]) + sound

        def between(quantity: NDArray[np.float64], flux: NDArray[np.float64]) -> NDArray[np.float64]:
            mixed = (fast * flux[:-1] - slow * flux[1:] + fast * slow * (quantity[1:] - quantity[:-1])) / (fast - slow)
            return np.where(slow > 0.0, flux[:-1], np.where(fast < 0.0, flux[1:], mixed))

        of_mass = between(density, momentum)
        of_momentum = between(momentum, momentum * velocity + _GAS * density)
        self._density = self._density - step / self._sizes * np.diff(of_mass)
        self._momentum = self._momentum - step / self._sizes * np.diff(of_momentum)
        # what leaves through the hole of the first given cell, shared among its parts, takes its momentum along
        part = slice(0, self._refinement)
        pressure = _GAS * self._density[part]
        ratio = _ATMOSPHERE / pressure
        subsonic = np.sqrt(np.maximum(0.0, 1.0 - ((ratio - 0.528) / 0.472) ** 2))
        flow = 0.6847 * (self._hole / self._refinement) * pressure / sound * np.where(ratio <= 0.528, 1.0, subsonic)
        left = 1.0 - step * flow / (self._area * self._sizes[part]) / self._density[part]
        self._density[part] *= left
        self._momentum[part] *= left
        drag = self._friction * np.abs(self._momentum) / (2.0 * self._bore * self._density)
        self._momentum = self._momentum / (1.0 + step * drag)
