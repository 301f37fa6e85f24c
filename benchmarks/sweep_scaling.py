"""How a sweep of the 208-vehicle train scales over cores, and whether its memory stays flat.

python -m benchmarks.sweep_scaling [CASES]
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.report import Check, checks_table, machine, pairs, table
from haul_ros.studies.definition import free_sweep
from haul_ros.studies.pools import local_pool
from haul_ros.studies.runner import run_cases
from haul_ros.studies.store import ResultStore

CASES = 200
SCALING = 1.8
"""On two cores."""
GROWTH_MB = 50.0
"""Largest growth of memory after the first cases."""
WARM = 20


def _peak_memory_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def sweep_time(cases: int, cores: set[int]) -> tuple[float, float]:
    """Wall time [s] of a Monte-Carlo sweep on these cores and no others, and growth of memory [MB] after its start."""
    os.sched_setaffinity(0, cores)
    sweep = free_sweep("daqin_1_2_1", [], [], ["vehicles.C80.mass_t=normal(100,3)"], cases, seed=1)
    memory: list[float] = []
    with tempfile.TemporaryDirectory() as folder, ResultStore(Path(folder) / "results.sqlite") as store:
        began = time.perf_counter()
        with local_pool() as pool:
            run_cases(sweep.cases(), pool, store, on_finished=lambda: memory.append(_peak_memory_mb()))
        return time.perf_counter() - began, memory[-1] - memory[min(WARM, len(memory) - 1)]


def main() -> int:
    """Measure and print; 1 if something does not hold."""
    cases = int(sys.argv[1]) if len(sys.argv) > 1 else CASES
    print(pairs(machine(["numpy", "numba"])))
    cores = sorted(os.sched_getaffinity(0))[:2]
    if len(cores) < 2:
        print("needs two cores")
        return 1
    sweep_time(2, set(cores))  # compiles, fills caches
    one, _ = sweep_time(cases, set(cores[:1]))
    more, growth = sweep_time(cases, set(cores))
    rows = [(name, f"{t:.1f}", f"{t / cases * 1e3:.0f}") for name, t in (("one core", one), ("two cores", more))]
    print(table((f"{cases} cases, 1+2+1 train", "s", "ms per case"), rows))
    checks = [
        Check("scaling over 2 cores", f"{one / more:.2f}", f"at least {SCALING}", one / more >= SCALING),
        Check("growth of memory", f"{growth:.1f} MB", f"at most {GROWTH_MB:g} MB", growth <= GROWTH_MB),
    ]
    print(checks_table(checks))
    return 0 if all(check.holds for check in checks) else 1


if __name__ == "__main__":
    sys.exit(main())
