"""Status telegrams that tell the slaves that their links are alive, and who has heard nothing for too long."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from haul_ros.model.radio import RadioLink


@dataclass(slots=True)
class _Watch:
    """One slave: number of the next status telegram, times [s] of what is to be heard and was heard last."""

    period: float
    timeout: float
    number: int = 0
    coming: list[float] = field(default_factory=list)
    heard: float = 0.0
    lost: bool = False

    @property
    def next(self) -> tuple[float, int]:
        """When something happens next [s], and what: 0 a telegram is sent, 1 one is heard, 2 the patience ends."""
        found = [(self.number * self.period, 0)]
        found += [(self.coming[0], 1)] if self.coming else []
        found += [(self.heard + self.timeout, 2)] if self.timeout and not self.lost else []
        return min(found)


class Heartbeats:
    """The status telegrams of all links that have them.

    Parameters
    ----------
    links
        By slave.
    send
        Called with slave, number and time [s]; returns when that status telegram is heard, None: never.
    act
        Called with a slave and True when it has heard nothing for too long, False when it hears something again.
    """

    def __init__(
        self,
        links: Mapping[str, RadioLink],
        send: Callable[[str, int, float], float | None],
        act: Callable[[str, bool], None],
    ) -> None:
        self._send = send
        self._act = act
        self._watches = {
            slave: _Watch(link.heartbeat, link.link_timeout) for slave, link in links.items() if link.heartbeat
        }

    @property
    def next_time(self) -> float:
        """When something happens next [s]; infinite: never."""
        return min((watch.next[0] for watch in self._watches.values()), default=math.inf)

    def lost(self, slave: str) -> bool:
        """Whether a slave has heard nothing for too long."""
        return slave in self._watches and self._watches[slave].lost

    def heard(self, slave: str, time: float) -> None:
        """A slave hears something else at a time [s], which may lie ahead by less than a time step."""
        if slave in self._watches:
            heapq.heappush(self._watches[slave].coming, time)

    def carry_out_due(self, time: float) -> None:
        """Let happen what is due up to a time [s], in order."""
        while self.next_time <= time:
            slave = min(self._watches, key=lambda name: self._watches[name].next)
            watch = self._watches[slave]
            at, what = watch.next
            if what == 0:
                arrival = self._send(slave, watch.number, at)
                watch.number += 1
                if arrival is not None:
                    heapq.heappush(watch.coming, arrival)
            elif what == 1:
                watch.heard = max(heapq.heappop(watch.coming), watch.heard)
                if watch.lost:
                    watch.lost = False
                    self._act(slave, False)
            else:
                watch.lost = True
                self._act(slave, True)
