"""Radio links to the slave locomotives: when a telegram arrives, if it does."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from haul_ros.model.radio import RadioLink
from haul_ros.simulation.jitter import arrival_time

_ATTEMPT, _HEARTBEAT, _GAMMA = 1, 2, 3
"""What numbers are drawn for; the first two of every telegram come from the generator of its slave."""


@dataclass(frozen=True, slots=True)
class LinkStatus:
    """How the master sees a link, and what went over it.

    ``connected``: the link is up, in both directions and out of tunnels, and the last telegram got through. Telegrams
    ``sent``; ``lost`` on their way, attempts counted singly; sent again (``retried``) and ``given_up``; ignored by the
    slave as ``duplicates`` or as ``out_of_order``.
    """

    connected: bool
    delay: float
    sent: int
    lost: int
    retried: int = 0
    given_up: int = 0
    duplicates: int = 0
    out_of_order: int = 0


class Attempt(NamedTuple):
    """When a telegram arrives [s], None: it does not; and when its duplicate does, if there is one."""

    arrival: float | None
    duplicate: float | None = None


@dataclass(slots=True)
class Counts:
    """What went over one link since the start."""

    sent: int = 0
    lost: int = 0
    retried: int = 0
    given_up: int = 0
    duplicates: int = 0
    out_of_order: int = 0


@dataclass(slots=True)
class _Burst:
    """Whether there was a burst when somebody last looked, at a time [s]."""

    time: float = -math.inf
    present: bool = False


class Radio:
    """All links, with every chance drawn from seeded generators of each slave.

    What happens on one link does not change the draws on another, and the same telegrams at the
    same times always fare the same. ``out`` says whether the link to a slave is out at a time [s].
    """

    def __init__(
        self, links: Mapping[str, RadioLink], seed: int, out: Callable[[str, float], bool] | None = None
    ) -> None:
        self._links = dict(links)
        self._seed = seed
        self._out = out or _never
        self._number = {slave: n for n, slave in enumerate(self._links)}
        self._random = {slave: np.random.default_rng([seed, n]) for slave, n in self._number.items()}
        self._last_arrival = dict.fromkeys(self._links, 0.0)
        self._bursts = {slave: _Burst() for slave in self._links}
        self._last_lost = dict.fromkeys(self._links, False)
        self.counts = {slave: Counts() for slave in self._links}
        """By slave."""

    def link(self, slave: str) -> RadioLink:
        """The link to a slave."""
        return self._links[slave]

    def set_link(self, slave: str, link: RadioLink) -> None:
        """Change a link; telegrams on their way are not affected."""
        if slave not in self._links:
            raise KeyError(slave)
        self._links[slave] = link
        self._last_lost[slave] = False

    def send(self, slave: str, time: float) -> float | None:
        """Send a telegram at ``time`` [s]; the time of its arrival, not before earlier ones', or None if lost."""
        return self.first_attempt(slave, time).arrival

    def first_attempt(self, slave: str, time: float) -> Attempt:
        """Send a new telegram at a time [s]; its number is the count of those sent to the slave before."""
        # Both numbers are drawn for every telegram, so a change of the link leaves later draws alone.
        late, luck = map(float, self._random[slave].random(2))
        number = self.counts[slave].sent
        self.counts[slave].sent += 1
        return self._attempt(slave, number, 0, time, late, luck)

    def retry(self, slave: str, number: int, attempt: int, time: float) -> Attempt:
        """Send a telegram again, for the ``attempt``-th time, at a time [s]."""
        self.counts[slave].retried += 1
        late, luck = self._draws(slave, _ATTEMPT, number, attempt)[:2]
        return self._attempt(slave, number, attempt, time, late, luck)

    def acknowledge(self, slave: str, number: int, attempt: int, copy: int, time: float) -> float | None:
        """When the answer to a copy (0, or 1: the duplicate) that arrived at a time [s] is back; None: it is lost."""
        link = self._links[slave]
        late, luck, burst = self._draws(slave, _ATTEMPT, number, attempt)[5 + 3 * copy : 8 + 3 * copy]
        lost = luck < self._loss(slave, time, burst)
        if lost or not link.answers or self._out(slave, time):
            return None
        return arrival_time(link, time, late, self._gamma(slave, number, attempt, 2 + copy))

    def heartbeat(self, slave: str, number: int, time: float) -> float | None:
        """When the ``number``-th status telegram, sent at a time [s], is heard; None: it is lost. It is not counted."""
        link = self._links[slave]
        late, luck, burst = self._draws(slave, _HEARTBEAT, number, 0)[:3]
        lost = luck < self._loss(slave, time, burst)
        if lost or not link.reaches or self._out(slave, time):
            return None
        return arrival_time(link, time, late, self._gamma(slave, number, 0, 4))

    def told(self, slave: str, lost: bool) -> None:
        """Note what has become of the last telegram as the master sees it: it got through, or was given up."""
        self._last_lost[slave] = lost

    def status(self, time: float = 0.0) -> dict[str, LinkStatus]:
        """State of every link at a time [s], by slave."""
        found = {}
        for slave, link in self._links.items():
            counts = self.counts[slave]
            up = link.reaches and link.answers and not self._out(slave, time)
            found[slave] = LinkStatus(
                connected=up and not self._last_lost[slave],
                delay=link.delay,
                sent=counts.sent,
                lost=counts.lost,
                retried=counts.retried,
                given_up=counts.given_up,
                duplicates=counts.duplicates,
                out_of_order=counts.out_of_order,
            )
        return found

    def _attempt(self, slave: str, number: int, attempt: int, time: float, late: float, luck: float) -> Attempt:
        link = self._links[slave]
        draws = self._draws(slave, _ATTEMPT, number, attempt) if _draws_more(link) else [1.0] * 5
        lost = luck < self._loss(slave, time, draws[2])
        self._last_lost[slave] = lost or not link.reaches or self._out(slave, time)
        if self._last_lost[slave]:
            self.counts[slave].lost += 1
            return Attempt(None)
        arrival = self._arrival(slave, arrival_time(link, time, late, self._gamma(slave, number, attempt, 0)))
        if not draws[3] < link.duplicate_probability:
            return Attempt(arrival)
        copy = arrival_time(link, time, draws[4], self._gamma(slave, number, attempt, 1))
        return Attempt(arrival, self._arrival(slave, copy))

    def _arrival(self, slave: str, arrival: float) -> float:
        if not self._links[slave].in_order:
            return arrival
        self._last_arrival[slave] = max(arrival, self._last_arrival[slave])
        return self._last_arrival[slave]

    def _loss(self, slave: str, time: float, luck: float) -> float:
        """The probability of loss at a time [s]: bursts come and go as a Markov chain in continuous time.

        Who looks again after a while finds it in a state that depends on the one that he has seen, and on the time
        between, as the chain's law says; so one draw for each look is all it takes.
        """
        link, burst = self._links[slave], self._bursts[slave]
        if link.burst_length == 0.0:
            return link.loss_probability
        share = link.burst_length / (link.burst_length + link.burst_spacing)
        rate = 1.0 / link.burst_length + 1.0 / link.burst_spacing
        memory = math.exp(-max(0.0, time - burst.time) * rate)
        burst.present = luck < share + (float(burst.present) - share) * memory
        burst.time = max(time, burst.time)
        return link.burst_loss_probability if burst.present else link.loss_probability

    def _draws(self, slave: str, purpose: int, number: int, attempt: int) -> list[float]:
        """Numbers from 0 to 1 that depend on nothing but the telegram.

        They are late, luck, burst, duplicate or not, its late, then late, luck and burst of the answers to both.
        """
        # What becomes of other telegrams, and so how often they are sent again, changes nothing here.
        found: list[float] = self._generator(slave, purpose, number, attempt).random(11).tolist()
        return found

    def _gamma(self, slave: str, number: int, attempt: int, what: int) -> Callable[[], np.random.Generator]:
        return partial(self._generator, slave, _GAMMA, number, attempt, what)

    def _generator(self, slave: str, *key: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, self._number[slave], *key])


def _never(_slave: str, _time: float) -> bool:
    return False


def _draws_more(link: RadioLink) -> bool:
    return link.duplicate_probability > 0.0 or link.burst_length > 0.0
