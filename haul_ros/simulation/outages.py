"""Where and when radio links are out: in spans of time, and with the master or the slave in a tunnel."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence

from haul_ros.model.radio import Interval, RadioLink


class Outages:
    """Outages of all links; ``chainage`` gives where a locomotive is now [m], by name."""

    def __init__(self, links: Mapping[str, RadioLink], master: str, chainage: Callable[[str], float]) -> None:
        self._links = links
        self._master = master
        self._chainage = chainage
        self.slaves = tuple(slave for slave, link in links.items() if link.outages or link.tunnels)
        """Those whose links may be out."""

    def why(self, slave: str, time: float) -> str:
        """Why the link to a slave is out at a time [s], in words; empty: it is not."""
        link = self._links[slave]
        if link.outages and (span := _containing(link.outages, time)):
            return f"{span[0]:g} to {span[1]:g} s"
        if link.tunnels:
            for name in (self._master, slave):
                if span := _containing(link.tunnels, self._chainage(name)):
                    return f"{name} in the tunnel from {span[0]:g} to {span[1]:g} m"
        return ""

    def out(self, slave: str, time: float) -> bool:
        """Whether the link to a slave is out at a time [s]."""
        return bool(self.why(slave, time))


def _containing(spans: Sequence[Interval], value: float) -> Interval | None:
    """The span, begin included and end not, of those in order that a value lies in."""
    k = bisect_right(spans, (value, float("inf"))) - 1
    return spans[k] if k >= 0 and value < spans[k][1] else None
