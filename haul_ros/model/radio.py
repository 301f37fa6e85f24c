"""Radio links from the master to the slave locomotives."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

LONGEST_DELAY = 3600.0
"""Longest delay, and longest jitter, of a telegram [s]."""


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
        times = 0.0 <= self.delay <= LONGEST_DELAY and 0.0 <= self.jitter <= LONGEST_DELAY
        if not (times and 0.0 <= self.loss_probability <= 1.0):
            expected = f"delay and jitter must be 0 to {LONGEST_DELAY:g} s, loss_probability 0 to 1"
            raise ValueError(f"delay {self.delay}, jitter {self.jitter}, loss {self.loss_probability}: {expected}")


@dataclass(frozen=True, slots=True)
class RadioLinkChange:
    """A change of the link to a slave: new values of its fields, None where a field stays as it is."""

    slave: str
    delay: float | None = None
    jitter: float | None = None
    loss_probability: float | None = None
    connected: bool | None = None

    @classmethod
    def to(cls, slave: str, link: RadioLink) -> RadioLinkChange:
        """The change that makes the link to a slave this one, whatever it was."""
        return cls(slave, link.delay, link.jitter, link.loss_probability, link.connected)

    def values(self) -> dict[str, Any]:
        """The new values by the names of their fields."""
        return {field.name: value for field in fields(RadioLink) if (value := getattr(self, field.name)) is not None}

    def applied_to(self, link: RadioLink) -> RadioLink:
        """The link after this change.

        Raises
        ------
        ValueError
            There can be no such link.
        """
        return replace(link, **self.values())
