"""Radio links to the slave locomotives: when a telegram arrives, if it does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from haul_ros.model.radio import RadioLink


@dataclass(frozen=True, slots=True)
class LinkStatus:
    """``connected``: the link is up and the last telegram got through; telegrams ``sent`` and ``lost``."""

    connected: bool
    delay: float
    sent: int
    lost: int


class Radio:
    """All links, with jitter and loss drawn from one seeded generator per slave.

    What happens on one link does not change the draws on another, and the same telegrams at the
    same times always fare the same.
    """

    def __init__(self, links: Mapping[str, RadioLink], seed: int) -> None:
        self._links = dict(links)
        self._random = {slave: np.random.default_rng([seed, n]) for n, slave in enumerate(self._links)}
        self._last_arrival = dict.fromkeys(self._links, 0.0)
        self._sent = dict.fromkeys(self._links, 0)
        self._lost = dict.fromkeys(self._links, 0)
        self._last_lost = dict.fromkeys(self._links, False)

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
        link = self._links[slave]
        # Both numbers are drawn for every telegram, so a change of the link leaves later draws alone.
        late, luck = self._random[slave].random(2)
        self._sent[slave] += 1
        self._last_lost[slave] = not link.connected or luck < link.loss_probability
        if self._last_lost[slave]:
            self._lost[slave] += 1
            return None
        arrival = max(time + link.delay + link.jitter * float(late), self._last_arrival[slave])
        self._last_arrival[slave] = arrival
        return arrival

    def status(self) -> dict[str, LinkStatus]:
        """State of every link, by slave."""
        return {
            slave: LinkStatus(
                connected=link.connected and not self._last_lost[slave],
                delay=link.delay,
                sent=self._sent[slave],
                lost=self._lost[slave],
            )
            for slave, link in self._links.items()
        }
