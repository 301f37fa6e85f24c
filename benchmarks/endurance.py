"""Hours of cyclic braking: ``python -m benchmarks.endurance [--hours 8]``.

The train of `daqin_descent` goes down a line of 10 per mille that never ends, with its driver and pneumatic brake. What
is printed for every hour shows whether anything drifts: the means over its braking cycles, the air and the energy that
have come from nowhere since the start, and the memory of the process. The exit status is 1 if the last hour is not as
the second one.
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from haul_ros.model.log import AppliedBrake
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session

SETTLED_HOUR = 2
"""The first hour that the last one is compared with: one goes by until the cycles are alike."""

TOLERANCE = 0.03
"""By how much the means of two hours may differ: a driver looks once a second, so a cycle of 280 s is 0.4 % rough."""

AIR_TOLERANCE = 1e-9
ENERGY_TOLERANCE = 1e-9
MEMORY_TOLERANCE = 20.0
"""[MB]"""


@dataclass(frozen=True, slots=True)
class Hour:
    """One hour: means over its braking cycles, and the state at its end.

    Period and time braked [s], largest and least speed [km/h], mean cylinder pressure and that of the least auxiliary
    reservoir [kPa], largest compression [kN]; parts of air and energy that have come from nowhere; memory [MB].
    """

    cycles: int
    period: float
    braked: float
    fastest: float
    slowest: float
    cylinder: float
    least_reservoir: float
    compression: float
    air_error: float
    imbalance: float
    memory: float

    def differences(self, other: Hour) -> dict[str, float]:
        """Relative differences of the means over cycles."""
        names = [field.name for field in fields(self)][1:8]
        return {name: abs(getattr(other, name) / getattr(self, name) - 1.0) for name in names}


def descent(hours: float) -> Scenario:
    """The train of the shipped descent on one grade."""
    return load_scenario(
        "daqin_descent",
        {
            "track": {
                "grades": [{"from_m": -100_000, "grade_permille": -10}],
                "speed_limits": [{"from_m": -100_000, "limit_kmh": 80}],
            },
            "max_duration_s": hours * 3600.0 + 1.0,
            "sample_rate_hz": 2,
        },
    )


def memory_now() -> float:
    """Memory that this process holds now [MB]."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize() / 1e6


@dataclass(slots=True)
class _Cycle:
    began: float
    released: float = np.nan
    fastest: float = 0.0
    slowest: float = np.inf
    cylinder: float = 0.0
    reservoir: float = np.inf
    compression: float = 0.0


def _cycles(session: Session, until: float) -> list[tuple[float, ...]]:
    """Cycles from one application to the next until a time [s]; the first that is not whole is left out."""
    found: list[tuple[float, ...]] = []
    cycle: _Cycle | None = None
    while session.time < until:
        session.advance()
        log = session.take_log()
        for entry in log.entries:
            if isinstance(entry, AppliedBrake) and entry.locomotive == "master":
                now = entry.time_ns / 1e9
                if entry.value == 0.0:
                    if cycle is not None:
                        cycle.released = now
                    continue
                if cycle is not None and cycle.released < now:
                    found.append(
                        (
                            now - cycle.began,
                            cycle.released - cycle.began,
                            cycle.fastest * 3.6,
                            cycle.slowest * 3.6,
                            cycle.cylinder / 1e3,
                            cycle.reservoir / 1e3,
                            cycle.compression / 1e3,
                        )
                    )
                    cycle = None
                cycle = cycle or _Cycle(now)
        if cycle is not None and log.sample is not None and log.sample.auxiliary_pressure is not None:
            sample, reservoirs = log.sample, log.sample.auxiliary_pressure
            cycle.fastest = max(cycle.fastest, float(sample.speed[0]))
            cycle.slowest = min(cycle.slowest, float(sample.speed[0]))
            cycle.cylinder = max(cycle.cylinder, float(np.mean(sample.cylinder_pressure)))
            cycle.reservoir = min(cycle.reservoir, float(reservoirs.min()))
            cycle.compression = max(cycle.compression, float(sample.coupler_force.max()))
    return found


def hours_of(session: Session, hours: int, seconds: float = 3600.0) -> Iterator[Hour]:
    """Run on, and tell of every hour (of so many ``seconds``) when it is over."""
    began = session.time
    for hour in range(1, hours + 1):
        cycles = np.array(_cycles(session, began + hour * seconds))
        period, braked, fastest, slowest, cylinder, reservoir, compression = map(float, cycles.mean(axis=0))
        energy = session.energy()
        if energy.fault is not None:
            raise RuntimeError(energy.fault)
        yield Hour(
            len(cycles),
            period,
            braked,
            fastest,
            slowest,
            cylinder,
            reservoir,
            compression,
            energy.air_error,
            energy.relative_imbalance,
            memory_now(),
        )


def drift(settled: Hour, last: Hour) -> list[str]:
    """What of the last hour is not as in the settled one, in words."""
    wrong = [
        f"{name} differs by {difference:.1%}"
        for name, difference in settled.differences(last).items()
        if difference > TOLERANCE
    ]
    if last.air_error > AIR_TOLERANCE:
        wrong.append(f"{last.air_error:.2g} of the air has come from nowhere")
    if abs(last.imbalance) > ENERGY_TOLERANCE:
        wrong.append(f"{last.imbalance:.2g} of the energy has come from nowhere")
    if last.memory > settled.memory + MEMORY_TOLERANCE:
        wrong.append(f"{last.memory - settled.memory:.0f} MB of memory more")
    return wrong


def main(arguments: list[str] | None = None) -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=int, default=8)
    hours = parser.parse_args(arguments).hours
    session = Session(descent(hours), play_commands=True)
    began, found = time.perf_counter(), list[Hour]()
    print("hour cycles period braked fastest slowest  cylinder reservoir compression    air   energy  memory")
    print("               [s]    [s]  [km/h]  [km/h]     [kPa]     [kPa]        [kN]    [-]      [-]    [MB]")
    for number, hour in enumerate(hours_of(session, hours), start=1):
        found.append(hour)
        print(
            f"{number:4d} {hour.cycles:6d} {hour.period:6.1f} {hour.braked:6.1f} {hour.fastest:7.2f} "
            f"{hour.slowest:7.2f} {hour.cylinder:9.2f} {hour.least_reservoir:9.2f} "
            f"{hour.compression:11.1f} {hour.air_error:6.0e} {hour.imbalance:8.0e} {hour.memory:7.1f}",
            flush=True,
        )
    took = time.perf_counter() - began
    print(f"{session.time:.0f} s simulated in {took:.0f} s, {session.time / took:.0f} times real time")
    wrong = drift(found[min(SETTLED_HOUR, hours) - 1], found[-1])
    print("\n".join(wrong) or "no drift")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
