"""Radio links from the master to the slave locomotives."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

LONGEST_DELAY = 3600.0
"""Longest delay, jitter and other time of a link [s]."""
MOST_RETRIES = 16
SHORTEST_RETRY_INTERVAL = 0.01
"""Shortest time between two attempts [s]."""

JITTER_LAWS = ("uniform", "exponential", "normal", "gamma", "empirical")
FAILURES = ("none", "to_slave", "from_slave")
LOST_ACTIONS = ("hold", "idle", "apply")

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class RadioLink:
    """One link: a telegram arrives ``delay`` plus a random addition [s] later, or is lost with ``loss_probability``;
    over a link that is not ``connected`` nothing arrives, and the slave holds its last demand and brakes when the wave
    in the brake pipe reaches it.

    The addition, by ``jitter_law``: ``uniform`` from 0 to ``jitter``; ``exponential``, or ``gamma`` (of the shape
    ``jitter_shape``), with the mean ``jitter``; ``normal`` about ``delay`` with the standard deviation ``jitter``, no
    telegram arriving before it was sent; ``empirical``: ``jitter`` times a value between ``jitter_quantiles``, which
    are of equal steps of probability from 0 to 1. Telegrams arrive ``in_order`` or may overtake each other.

    With ``retries`` the slave acknowledges, and what is not acknowledged is sent again so often, ``retry_interval`` [s]
    apart. With ``duplicate_probability`` a telegram arrives twice. With ``fails`` one direction is dead.

    In bursts of the mean length ``burst_length`` [s] (0: none), with ``burst_spacing`` [s] between them in the mean,
    ``burst_loss_probability`` takes the place of ``loss_probability``. The link is out in ``outages`` [s] and while
    master or slave are in ``tunnels`` [m of chainage].

    A status telegram goes out every ``heartbeat`` [s] (0: none); a slave that hears nothing for ``link_timeout`` [s]
    (0: never) does what ``link_lost`` says: holds, idles, or applies full service.
    """

    delay: float = 0.0
    jitter: float = 0.0
    loss_probability: float = 0.0
    connected: bool = True
    jitter_law: str = "uniform"
    retries: int = 0
    retry_interval: float = 0.5
    duplicate_probability: float = 0.0
    in_order: bool = True
    fails: str = "none"
    burst_length: float = 0.0
    burst_spacing: float = 60.0
    burst_loss_probability: float = 1.0
    jitter_shape: float = 2.0
    jitter_quantiles: tuple[float, ...] = (0.0, 1.0)
    outages: tuple[Interval, ...] = ()
    tunnels: tuple[Interval, ...] = ()
    heartbeat: float = 0.0
    link_lost: str = "hold"
    link_timeout: float = 0.0

    def __post_init__(self) -> None:
        times = 0.0 <= self.delay <= LONGEST_DELAY and 0.0 <= self.jitter <= LONGEST_DELAY
        if not (times and 0.0 <= self.loss_probability <= 1.0):
            expected = f"delay and jitter must be 0 to {LONGEST_DELAY:g} s, loss_probability 0 to 1"
            raise ValueError(f"delay {self.delay}, jitter {self.jitter}, loss {self.loss_probability}: {expected}")
        self._check_number("retries", 0, MOST_RETRIES)
        self._check_number("retry_interval", SHORTEST_RETRY_INTERVAL, LONGEST_DELAY)
        self._check_number("duplicate_probability", 0, 1)
        self._check_number("burst_length", 0, LONGEST_DELAY)
        self._check_number("burst_spacing", SHORTEST_RETRY_INTERVAL, LONGEST_DELAY)
        self._check_number("burst_loss_probability", 0, 1)
        self._check_choice("jitter_law", JITTER_LAWS)
        self._check_choice("fails", FAILURES)
        self._check_choice("link_lost", LOST_ACTIONS)

    def _check_number(self, name: str, least: float, most: float) -> None:
        if not least <= (value := getattr(self, name)) <= most:  # NaN too
            raise ValueError(f"{name} {value}: must be {least:g} to {most:g}")

    def _check_choice(self, name: str, choices: tuple[str, ...]) -> None:
        if (value := getattr(self, name)) not in choices:
            raise ValueError(f"{name} {value!r:.80}: must be one of {', '.join(choices)}")

    @property
    def reaches(self) -> bool:
        """Whether telegrams get to the slave, where no chance and no outage is against it."""
        return self.connected and self.fails != "to_slave"

    @property
    def answers(self) -> bool:
        """Whether acknowledgements get back, likewise."""
        return self.connected and self.fails != "from_slave"


@dataclass(frozen=True, slots=True)
class RadioLinkChange:
    """A change of the link to a slave: new values of its fields, None where a field stays as it is.

    What has no field here stays as it is for a whole run.
    """

    slave: str
    delay: float | None = None
    jitter: float | None = None
    loss_probability: float | None = None
    connected: bool | None = None
    jitter_law: str | None = None
    retries: int | None = None
    retry_interval: float | None = None
    duplicate_probability: float | None = None
    in_order: bool | None = None
    fails: str | None = None
    burst_length: float | None = None
    burst_spacing: float | None = None
    burst_loss_probability: float | None = None

    @classmethod
    def to(cls, slave: str, link: RadioLink) -> RadioLinkChange:
        """The change that makes the link to a slave this one, whatever it was, but for what stays for a whole run."""
        return cls(slave, *(getattr(link, name) for name in CHANGEABLE))

    def values(self) -> dict[str, Any]:
        """The new values by the names of their fields."""
        return {name: value for name in CHANGEABLE if (value := getattr(self, name)) is not None}

    def applied_to(self, link: RadioLink) -> RadioLink:
        """The link after this change.

        Raises
        ------
        ValueError
            There can be no such link.
        """
        return replace(link, **self.values())


CHANGEABLE = tuple(field.name for field in fields(RadioLinkChange) if field.name != "slave")
"""The fields of a link that may change during a run."""
