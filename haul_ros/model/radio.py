"""Radio links from the master to the slave locomotives."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RadioLink:
    """One link: a telegram arrives ``delay`` plus a uniform 0..``jitter`` [s] later, in order, or is
    lost with ``loss_probability``; over a link that is not ``connected`` nothing arrives, and the
    slave holds its last demand and brakes when the wave in the brake pipe reaches it."""

    delay: float = 0.0
    jitter: float = 0.0
    loss_probability: float = 0.0
    connected: bool = True

    def __post_init__(self) -> None:
        if not (0.0 <= self.delay < math.inf and 0.0 <= self.jitter < math.inf and 0.0 <= self.loss_probability <= 1.0):
            raise ValueError(f"{self}: delay and jitter must be finite and at least 0, loss_probability 0 to 1")


@dataclass(frozen=True, slots=True)
class TimedLink:
    """The link to a slave from ``time`` [s] of the simulation on: its ``delay`` [s], up or down."""

    time: float
    slave: str
    delay: float
    connected: bool
