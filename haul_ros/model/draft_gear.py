"""Draft gears: loading and unloading curves of one coupler connection."""

from __future__ import annotations

from dataclasses import dataclass

Curve = tuple[tuple[float, float], ...]
"""Points (stroke [m], force [N]) of rising stroke, the first at stroke 0; straight between the points
and beyond the last one. A force above 0 at stroke 0 is a preload."""


@dataclass(frozen=True, slots=True)
class SideCurves:
    """Loading curve ``fu`` and unloading curve ``fl`` for one direction, with ``fl <= fu`` everywhere."""

    loading: Curve
    unloading: Curve


@dataclass(frozen=True, slots=True)
class DraftGear:
    """One equivalent draft gear per connection, by the velocity method (paper sec. 2.4, eq. 5).

    ``transition_speed`` Ve [m/s]; ``slack`` [m] is the whole free play, half on each side of
    stroke 0; past ``maximum_stroke`` [m] (counted without slack; infinite: never) the closed gear
    adds ``bottoming_stiffness`` [N/m] to both curves; ``solid_stiffness`` [N/m] is the slope on
    which a preload is taken up: neither curve of a preloaded side is ever above it. ``strength`` [N] is the tension
    at which the coupler breaks (infinite: never).
    """

    name: str
    compression: SideCurves
    tension: SideCurves
    transition_speed: float
    slack: float = 0.0
    maximum_stroke: float = float("inf")
    bottoming_stiffness: float = 0.0
    solid_stiffness: float = 0.0
    strength: float = float("inf")

    @property
    def preloaded(self) -> bool:
        """Whether there is a preload in buff or in draft."""
        return self.compression.loading[0][1] > 0.0 or self.tension.loading[0][1] > 0.0
