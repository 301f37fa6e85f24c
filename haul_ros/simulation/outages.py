"""Where and when radio links are out: in spans of time, and with the master or the slave in a tunnel."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from itertools import chain

from haul_ros.model.radio import Interval, RadioLink
from haul_ros.simulation.lookout import steps_to_look
from haul_ros.simulation.telegrams import ROUNDING


class Outages:
    """Outages of all links; ``place`` gives where a locomotive is now [m], and its speed [m/s], by name."""

    def __init__(
        self, links: Mapping[str, RadioLink], master: str, place: Callable[[str], tuple[float, float]]
    ) -> None:
        self._links = links
        self._master = master
        self._place = place
        self.slaves = tuple(slave for slave, link in links.items() if link.outages or link.tunnels)
        """Those whose links may be out."""
        self._times = sorted({time for link in links.values() for time in chain(*link.outages)})
        self._mouths = {slave: [*chain(*links[slave].tunnels)] for slave in self.slaves}

    def why(self, slave: str, time: float) -> str:
        """Why the link to a slave is out at a time [s], in words; empty: it is not."""
        link = self._links[slave]
        if link.outages and (span := _containing(link.outages, time)):
            return f"{span[0]:g} to {span[1]:g} s"
        if link.tunnels:
            for name in (self._master, slave):
                if span := _containing(link.tunnels, self._place(name)[0]):
                    return f"{name} in the tunnel from {span[0]:g} to {span[1]:g} m"
        return ""

    def out(self, slave: str, time: float) -> bool:
        """Whether the link to a slave is out at a time [s]."""
        return bool(self.why(slave, time))

    def next_look(self, step: int, time_step: float) -> int:
        """The time step, after the present one, at which to look for the next outage that begins or ends."""
        k = bisect_right(self._times, (step + ROUNDING) * time_step)
        found = [math.ceil(time / time_step - ROUNDING) for time in self._times[k : k + 1]]
        for slave, mouths in self._mouths.items():
            for name in (self._master, slave) if mouths else ():
                chainage, speed = self._place(name)
                k = bisect_right(mouths, chainage)
                way = min(abs(mouth - chainage) for mouth in mouths[max(0, k - 1) : k + 1])
                found.append(step + steps_to_look(way, speed, time_step))
        return max(step + 1, min(found, default=step + 2**62))


def _containing(spans: Sequence[Interval], value: float) -> Interval | None:
    """The span, begin included and end not, of those in order that a value lies in."""
    k = bisect_right(spans, (value, float("inf"))) - 1
    return spans[k] if k >= 0 and value < spans[k][1] else None
