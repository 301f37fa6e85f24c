"""Brake applications that do not hold, though nobody has released: seen in cylinders and brake pipe."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.consist import Consist
from haul_ros.model.event import Event, EventKind
from haul_ros.model.sample import FloatArray, Sample
from haul_ros.physics.air_demand import cylinder_pressures_for
from haul_ros.physics.train_model import ValveState
from haul_ros.units import NS_PER_S

LOST = 20e3
"""Pressure [Pa] by which a cylinder may lack what it had reached, or what is asked for, and the pipe what it is put to.

Chinese brake tests allow a pipe to lose 20 kPa a minute with the brake applied (general knowledge); a cylinder that
lacks so much has lost a quarter of the least application.
"""
BEGUN = 5e3
"""Rise of a cylinder [Pa] after which it is watched: it has begun to apply."""
ARRIVED = 5e3
"""A reduction has come to a vehicle when its pipe is no further above what is asked for [Pa]."""
STILL_CYLINDER, STILL_PIPE = 1e3, 2e3
"""Pressure [Pa] by which cylinder and pipe may change while they stand."""
SETTLED, STUCK = 10.0, 30.0
"""A cylinder that stands for such a time [s] gets no more: the first where the reduction has arrived, the second where
the pipe stands too and it has not, long after the wave has passed."""
BETWEEN_NS = 10 * NS_PER_S
"""Simulation time from one event of a sort to the next in the same application: it then tells of all since, unless the
application ends before, or the run."""

Flags = NDArray[np.bool_]


class _Sort:
    """Vehicles of one way not to hold: each is told of once in an application."""

    def __init__(self, vehicles: int, words: Callable[[Flags], str]) -> None:
        self.found = np.zeros(vehicles, dtype=bool)
        self._words = words
        self._told = self.found.copy()
        self._due_ns = 0

    def restart(self) -> None:
        self.found[:] = self._told[:] = False
        self._due_ns = 0

    def tell(self, time_ns: int, names: Callable[[Iterable[int]], str], *, last: bool = False) -> list[Event]:
        """What is new, unless it is to wait; the ``last`` time in an application nothing is."""
        new = self.found & ~self._told
        if not new.any() or (time_ns < self._due_ns and not last):
            return []
        self._told |= new
        self._due_ns = time_ns + BETWEEN_NS
        return [Event(time_ns, EventKind.APPLICATION, f"{names(np.flatnonzero(new))}: {self._words(new)}")]


class ApplicationWatch:
    """Watches the applications of a train with a pneumatic brake, sample by sample.

    An application lasts from a demand of any locomotive on until one of them asks for less than before. Meanwhile

    - a cylinder that has applied must not lack `LOST` of the most that it had;
    - a cylinder that stands, once the reduction has arrived, must not lack `LOST` of what the reduction asks for, where
      several locomotives ask the least of them;
    - the pipe must not fall `LOST` below the lowest pressure that a brake valve is put to, nor below what it was at the
      start if that was lower still, but in an emergency.

    A further demand begins anew for those that have been told of. Cylinders of valves that are cut out, and those that
    the electric brake keeps empty, are not watched meanwhile.
    """

    def __init__(self, consist: Consist, brake: PneumaticBrake, names: Callable[[Iterable[int]], str]) -> None:
        count = len(consist.vehicles)
        self._consist, self._brake, self._names = consist, brake, names
        self._targets: FloatArray | None = None
        self._lowest, self._highest = np.full(count, np.inf), np.full(count, -np.inf)
        self._left = np.full(count, np.inf)
        self._pipe_at_start = np.full(count, np.inf)
        self._level, self._pipe_level, self._since_ns = np.zeros(count), np.zeros(count), np.zeros(count, np.int64)
        self._asked, self._asked_pipe = np.zeros(count), brake.pressure
        self._cylinder, self._pipe, self._put_to = np.zeros(count), np.zeros(count), 0.0
        self._fallen = _Sort(count, self._words_of_fallen)
        self._short = _Sort(count, self._words_of_short)
        self._leaking = _Sort(count, self._words_of_leaking)
        self._sorts = (self._fallen, self._short, self._leaking)

    def update(self, now: Sample, valves: ValveState) -> list[Event]:
        """Events of a sample that follows the last one."""
        before, self._targets = self._targets, valves.targets
        ended: list[Event] = []
        if before is None or (valves.targets > before).any():
            ended = self.rest(now.time_ns)
            self._restart(now.time_ns)
        elif valves.targets.min() < before.min():  # not so a slave that is put, later, to what the master is
            ended = self.rest(now.time_ns)
            self._begin_anew(now.time_ns)
        if not (valves.targets < self._brake.pressure).any() or now.pipe_pressure is None:
            self._restart(now.time_ns)
            return ended
        self._cylinder, self._pipe = now.cylinder_pressure, now.pipe_pressure
        np.minimum(self._pipe_at_start, self._pipe, out=self._pipe_at_start, where=np.isinf(self._pipe_at_start))
        self._watch_cylinders(valves)
        if not (valves.emergency_commanded or valves.emergency.any()):
            self._watch_what_is_asked(now.time_ns, valves)
        return ended + [event for sort in self._sorts for event in sort.tell(now.time_ns, self._names)]

    def rest(self, time_ns: int) -> list[Event]:
        """What waits to be told with more, where no more is to come: at the end of an application, or of the run."""
        return [event for sort in self._sorts for event in sort.tell(time_ns, self._names, last=True)]

    def _restart(self, time_ns: int) -> None:
        self._lowest[:], self._highest[:], self._pipe_at_start[:] = np.inf, -np.inf, np.inf
        self._start_watch(time_ns)

    def _begin_anew(self, time_ns: int) -> None:
        told = self._fallen.found
        self._lowest[told], self._highest[told] = np.inf, -np.inf
        self._start_watch(time_ns)

    def _start_watch(self, time_ns: int) -> None:
        self._since_ns[:] = time_ns
        self._left[:] = np.inf
        for sort in self._sorts:
            sort.restart()

    def _watch_cylinders(self, valves: ValveState) -> None:
        np.minimum(self._lowest, self._cylinder, out=self._lowest)
        begun = valves.applied & (self._cylinder > self._lowest + BEGUN)
        np.maximum(self._highest, self._cylinder, out=self._highest, where=begun | (self._highest > -np.inf))
        self._lowest[valves.out_of_use], self._highest[valves.out_of_use] = np.inf, -np.inf
        fallen = self._highest - self._cylinder > LOST
        # The least is told: a cylinder may have filled again when it is
        np.minimum(self._left, self._cylinder, out=self._left, where=fallen)
        self._fallen.found |= fallen

    def _watch_what_is_asked(self, time_ns: int, valves: ValveState) -> None:
        demanding = valves.targets < self._brake.pressure
        acting = demanding & ~valves.feed_cut
        asked_pipe = float(valves.targets[acting if acting.any() else demanding].max())
        self._put_to = float(valves.targets.min())
        self._leaking.found |= self._pipe < np.minimum(self._pipe_at_start, self._put_to) - LOST
        if asked_pipe != self._asked_pipe:
            self._asked_pipe = asked_pipe
            self._asked = cylinder_pressures_for(self._brake, self._consist, asked_pipe)
        arrived = self._pipe <= asked_pipe + ARRIVED
        moving = np.abs(self._cylinder - self._level) > STILL_CYLINDER
        moving |= valves.out_of_use
        moving |= ~arrived & (np.abs(self._pipe - self._pipe_level) > STILL_PIPE)
        self._level[moving], self._pipe_level[moving] = self._cylinder[moving], self._pipe[moving]
        self._since_ns[moving] = time_ns
        settled = time_ns - self._since_ns >= np.where(arrived, SETTLED, STUCK) * NS_PER_S
        self._short.found |= settled & (self._cylinder < self._asked - LOST) & ~self._fallen.found

    def _words_of_fallen(self, new: Flags) -> str:
        left, had = self._left[new].min() / 1e3, self._highest[new].max() / 1e3
        return f"application not held: cylinders down to {left:.0f} kPa from up to {had:.0f}, nobody has released"

    def _words_of_short(self, new: Flags) -> str:
        there, asked = self._cylinder[new].min() / 1e3, self._asked[new].max() / 1e3
        return f"application not reached: cylinders at {there:.0f} kPa and no more, the reduction asks for {asked:.0f}"

    def _words_of_leaking(self, new: Flags) -> str:
        there, put_to = self._pipe[new].min() / 1e3, self._put_to / 1e3
        return f"application not held: brake pipe down to {there:.0f} kPa, put to {put_to:.0f}"
