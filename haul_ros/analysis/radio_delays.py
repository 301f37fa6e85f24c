"""Radio delays as they happened: from what the master applied to what each slave made of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haul_ros.model.sample import FloatArray


@dataclass(frozen=True, slots=True)
class RadioDelay:
    """The master applied ``demand`` (0..1) at ``time`` [s]; the ``slave`` followed ``delay`` [s] later, None: never."""

    slave: str
    time: float
    demand: float
    delay: float | None


def radio_delays(
    slave: str, master: tuple[FloatArray, FloatArray], applied: tuple[FloatArray, FloatArray]
) -> list[RadioDelay]:
    """Delays of a slave: ``master`` and ``applied`` are times [s] and applied brakes (n,) of the two locomotives.

    Every change of the master's brake is answered by the slave's first change to the same demand from then on, before
    the master asks for that demand anew. Their first values are where they stood at the start, and no change. What the
    slave applied already when the master asked needs no answer, and is left out.
    """
    (times, demands), (slave_times, slave_demands) = master, applied
    changes = np.flatnonzero(np.diff(demands)) + 1
    answers = np.flatnonzero(np.diff(slave_demands)) + 1
    found = []
    for i in changes:
        time, demand = float(times[i]), float(demands[i])
        again = times[[j for j in changes if j > i and demands[j] == demand][:1]]
        until = float(again[0]) if len(again) else np.inf
        before = slave_demands[slave_times < time]
        hits = [float(slave_times[j]) for j in answers if slave_demands[j] == demand and time <= slave_times[j] < until]
        if not hits and len(before) and before[-1] == demand:
            continue
        found.append(RadioDelay(slave, time, demand, hits[0] - time if hits else None))
    return found
