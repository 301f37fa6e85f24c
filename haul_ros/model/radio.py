"""Radio links from the master to the slave locomotives."""

from __future__ import annotations

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
