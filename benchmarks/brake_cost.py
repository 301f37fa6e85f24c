"""What the pneumatic brake costs beside the empirical one: the same train, the same emergency stop, one core, in turns.

    python -m benchmarks.brake_cost [--json]

Both take turns in blocks of half a simulated second over the first 12 s, 1 ms steps; cost is that of a step, minimum
and median over the blocks. Exit status 1: the pneumatic train is slower than 100 times real time.
"""

from __future__ import annotations

import argparse
import json
import sys
from statistics import median
from time import perf_counter

from benchmarks.report import machine, pairs, table
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session

SCENARIOS = ("daqin_1_2_1", "daqin_1_2_1_pneumatic")
FIRST_PART, BLOCK = 12_000, 500
"""Time steps of 1 ms."""
TARGET = 100.0
"""Times real time."""


def measure() -> dict[str, list[float]]:
    """Wall time [us] per time step of every block, by scenario."""
    sessions = {name: Session(load_scenario(name), play_commands=True) for name in SCENARIOS}
    costs: dict[str, list[float]] = {name: [] for name in SCENARIOS}
    for session in sessions.values():
        session.advance(1)
    for _ in range(FIRST_PART // BLOCK):
        for name, session in sessions.items():
            began = perf_counter()
            session.advance(BLOCK)
            costs[name].append((perf_counter() - began) / BLOCK * 1e6)
    return costs


def main() -> int:
    """Measure, print; the exit status is 1 if the target is missed."""
    parser = argparse.ArgumentParser(description="Cost of the pneumatic brake beside the empirical one.")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    as_json = parser.parse_args().json
    facts, costs = machine(("numpy", "numba")), measure()
    least = min(costs[SCENARIOS[0]])
    rows = [(name, min(found), median(found), min(found) / least, 1e3 / min(found)) for name, found in costs.items()]
    if as_json:
        keys = ("scenario", "minimum_us", "median_us", "ratio", "times_real_time")
        print(json.dumps({"machine": facts, "brakes": [dict(zip(keys, row, strict=True)) for row in rows]}, indent=2))
    else:
        print(pairs(facts))
        texts = [(name, *(f"{number:.2f}" for number in numbers)) for name, *numbers in rows]
        print(table(("208 vehicles, 1 ms", "us a step, minimum", "median", "ratio", "x real time"), texts))
    return int(rows[-1][-1] < TARGET)


if __name__ == "__main__":
    sys.exit(main())
