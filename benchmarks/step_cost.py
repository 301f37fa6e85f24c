"""What one converged Newmark step of the 208-vehicle train costs in the compiled kernel, and what else would cost.

    python -m benchmarks.step_cost [--json]

The train is daqin_1_2_1 in an emergency stop from 80 km/h. Its first 12 s, in which the largest
forces occur and every vehicle still moves, are simulated side by side by

- the kernel as the node and ``haul run`` use it (`TrainModel.advance`), 1 ms steps;
- plain numpy with `scipy.linalg.solveh_banded`: the same step, vectorised over the vehicles;
- the kernel with 5 ms steps, about as long and as accurate as those of the next;
- `scipy.integrate.solve_ivp`, method LSODA with a banded Jacobian, which chooses its own steps.

Kernel and numpy take turns in blocks of half a simulated second, so that what else runs on the
machine hits both. numpy and solve_ivp come from ``reference_train.py`` and share no code with the
kernel: that all find the same largest forces in every coupler is checked, and exit status 1 says
that they do not. A second table has the kernel alone over the whole stop at several time steps.
Costs are minimum and median over blocks; on a machine that does other things too, believe the minimum.
Needs scipy (extra ``test``), takes less than a minute.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from time import perf_counter

import numpy as np

from benchmarks.reference_train import Floats, NumpyNewmark, ReferenceTrain, lsoda
from benchmarks.report import Check, checks_table, machine, pairs, table
from haul_ros.model.scenario import Scenario
from haul_ros.physics.train_model import NEWTON_TOLERANCE, StepStatistics, TrainModel, WaveKind
from haul_ros.scenario import load_scenario

SCENARIO = "daqin_1_2_1"
TIME_STEP = 1e-3
COARSE_STEP = 5e-3
FIRST_PART = 12.0
"""Simulated time [s] of the comparison."""
BLOCK = 0.5
"""Simulated time [s] of one block."""
SWEEP = (0.25e-3, 0.5e-3, TIME_STEP, 2e-3, COARSE_STEP)
LSODA_TOLERANCES = ((1e-6, 1e-7), (1e-8, 1e-9))
"""Relative, and absolute in m and m/s: about the loosest that agrees in every coupler, and a strict one."""
LSODA_RUNS = 3
STOPS = 3
"""How often the whole stop is repeated."""

SAME_METHOD = 1e-6
"""Difference of the largest forces, over the largest of all, allowed between two codes of the same method."""
OTHER_METHOD = 1e-3
"""The same between different methods or time steps."""
NOISY = 1.2
"""Median over minimum from which something else has been running."""
COST_TARGET_US = 8.0


@dataclass(frozen=True, slots=True)
class Cost:
    """Wall time [us], minimum and median over blocks."""

    minimum_us: float
    median_us: float


@dataclass(frozen=True, slots=True)
class Method:
    """One way to simulate the first part of the stop; costs are for 1 ms of simulated time, whatever the step.

    ``ratio`` is that of the minimum to the kernel's; ``difference`` the largest one of any coupler's
    peaks, compression or tension, from the kernel's, over the largest peak. ``iterations`` are
    Newton's in all steps, or evaluations of the equations by solve_ivp.
    """

    name: str
    cost: Cost
    ratio: float
    peak_kN: float  # noqa: N815, a unit
    difference: float
    steps: int
    iterations: int

    @property
    def real_time(self) -> float:
        """Simulated over wall time."""
        return 1e3 / self.cost.median_us

    @property
    def us_per_own_step(self) -> float:
        """Wall time [us] per step of the method itself, by the minimum."""
        return self.cost.minimum_us * FIRST_PART * 1e3 / self.steps


@dataclass(frozen=True, slots=True)
class WholeStop:
    """The kernel to standstill at one time step; ``difference`` of the peak is from that at the finest step."""

    time_step_ms: float
    cost: Cost
    stop_time: float
    peak_kN: float  # noqa: N815, a unit
    difference: float
    steps: StepStatistics

    @property
    def real_time(self) -> float:
        """Simulated over wall time."""
        return self.time_step_ms * 1e3 / self.cost.median_us


def main() -> int:
    """Measure, print; the exit status is 1 if the methods disagree."""
    parser = argparse.ArgumentParser(description="Cost of one time step, beside plain numpy and solve_ivp.")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    as_json = parser.parse_args().json
    facts = machine(("numpy", "numba", "scipy"))
    scenario = load_scenario(SCENARIO)
    _emergency_stop(scenario, TIME_STEP).advance(1)  # compiles the kernel, once per installation
    methods = compare(scenario)
    sweep = whole_stops(scenario)
    checks = agreement(methods, sweep)
    if as_json:
        parts: dict[str, Sequence[Method | WholeStop | Check]] = {"methods": methods, "sweep": sweep, "checks": checks}
        plain = {name: [asdict(row) for row in rows] for name, rows in parts.items()}
        print(json.dumps({"machine": facts, **plain}, indent=2))
    else:
        _print_tables(facts, methods, sweep, checks)
    return 0 if all(check.holds for check in checks) else 1


def compare(scenario: Scenario) -> list[Method]:
    """The first part of the stop by every method, the kernel first, plain numpy second."""
    kernel, coarse = _emergency_stop(scenario, TIME_STEP), _emergency_stop(scenario, COARSE_STEP)
    train = ReferenceTrain(scenario)
    plain = NumpyNewmark(train, TIME_STEP, NEWTON_TOLERANCE)
    costs = _take_turns(
        partial(kernel.advance, round(BLOCK / TIME_STEP)),
        partial(plain.advance, round(BLOCK / TIME_STEP)),
        partial(coarse.advance, round(BLOCK / COARSE_STEP)),
    )
    peaks = _largest_forces(kernel)

    def method(name: str, cost: Cost, found: Floats, steps: int, iterations: int) -> Method:
        ratio = cost.minimum_us / costs[0].minimum_us
        difference = float(np.abs(found - peaks).max() / peaks.max())
        return Method(name, cost, ratio, float(found[0].max()) / 1e3, difference, steps, iterations)

    def by_kernel(name: str, cost: Cost, model: TrainModel) -> Method:
        return method(name, cost, _largest_forces(model), model.step, model.statistics().newton_iterations)

    def by_lsoda(rtol: float, atol: float) -> Method:
        run = lsoda(train, FIRST_PART, rtol, atol)
        times = [_time(partial(lsoda, train, FIRST_PART, rtol, atol)) for _ in range(LSODA_RUNS)]
        name = f"solve_ivp LSODA, tolerances {rtol:g} {atol:g}"
        return method(name, _cost(times, FIRST_PART), run.largest_forces(train), run.steps, run.evaluations)

    return [
        by_kernel("haul_ros kernel, 1 ms", costs[0], kernel),
        method("plain numpy, solveh_banded, 1 ms", costs[1], plain.largest_forces, kernel.step, plain.iterations),
        by_kernel("haul_ros kernel, 5 ms", costs[2], coarse),
        *(by_lsoda(rtol, atol) for rtol, atol in LSODA_TOLERANCES),
    ]


def _take_turns(*advance_block: Callable[[], object]) -> list[Cost]:
    """Let each advance by a block in turn, until the first part of the stop is over."""
    rounds = [[_time(advance) for advance in advance_block] for _ in range(round(FIRST_PART / BLOCK))]
    return [_cost(times, BLOCK) for times in zip(*rounds, strict=True)]


def whole_stops(scenario: Scenario) -> list[WholeStop]:
    """The kernel over the whole stop at every time step of the sweep, the finest first."""
    rows: list[WholeStop] = []
    for time_step in SWEEP:
        times: list[float] = []
        for _ in range(STOPS):
            model = _emergency_stop(scenario, time_step)
            advance_block = partial(model.advance, round(BLOCK / time_step))
            while not model.at_standstill:
                times.append(_time(advance_block))
            times.pop()  # steps at standstill, in the last block, need no iteration and are cheaper
        per_ms = _cost(times, BLOCK)
        cost = Cost(per_ms.minimum_us * time_step * 1e3, per_ms.median_us * time_step * 1e3)
        peak = float(model.extremes().compression.max()) / 1e3
        change = peak / rows[0].peak_kN - 1.0 if rows else 0.0
        rows.append(WholeStop(time_step * 1e3, cost, model.stop_time, peak, change, model.statistics()))
    return rows


def agreement(methods: list[Method], sweep: list[WholeStop]) -> list[Check]:
    """What has to hold whatever the machine: the same forces from every method, and converged steps."""
    _, numpy_step, *others = methods
    limits = [(numpy_step, SAME_METHOD), *((other, OTHER_METHOD) for other in others)]
    checks = [
        Check(f"peaks of all couplers, {row.name}", f"{row.difference:.1e}", f"< {limit:g}", row.difference < limit)
        for row, limit in limits
    ]
    at_default = next(row for row in sweep if row.time_step_ms == TIME_STEP * 1e3)
    finest = f"{SWEEP[0] * 1e3:g} ms"
    change = abs(at_default.difference)
    checks.append(Check(f"peak at 1 ms beside {finest}", f"{change:.1e}", f"< {OTHER_METHOD:g}", change < OTHER_METHOD))
    divided = sum(row.steps.fallback_steps for row in sweep)
    checks.append(Check("steps that did not converge whole", str(divided), "0", divided == 0))
    return checks


def _emergency_stop(scenario: Scenario, time_step: float) -> TrainModel:
    """The train at its initial speed, every locomotive about to start an emergency application."""
    model = TrainModel(
        scenario.consist, scenario.brakes, scenario.track, initial_speed=scenario.initial_speed, time_step=time_step
    )
    for locomotive in scenario.consist.locomotives:
        model.start_wave(0.0, locomotive.vehicle, WaveKind.EMERGENCY)
    return model


def _largest_forces(model: TrainModel) -> Floats:
    """Largest compression and largest tension of every coupler so far [N], (2, couplers)."""
    extremes = model.extremes()
    return np.array([extremes.compression, extremes.tension])


def _time(work: Callable[[], object]) -> float:
    began = perf_counter()
    work()
    return perf_counter() - began


def _cost(times: Sequence[float], simulated: float) -> Cost:
    """Cost of 1 ms of simulated time, from the wall times of blocks of ``simulated`` seconds each."""
    per_ms = np.array(times) * 1e6 / (simulated * 1e3)
    return Cost(float(per_ms.min()), float(np.median(per_ms)))


def _print_tables(facts: dict[str, str], methods: list[Method], sweep: list[WholeStop], checks: list[Check]) -> None:
    print(pairs(facts))
    print(f"\n{SCENARIO}, 208 vehicles, emergency stop: the first {FIRST_PART:g} s, per 1 ms of simulated time\n")
    print(_methods_table(methods))
    print(f"\nkernel, the whole stop, {STOPS} times each\n")
    print(_sweep_table(sweep))
    print(f"\n{_verdict(sweep)}\n")
    print(checks_table(checks))


def _methods_table(methods: list[Method]) -> str:
    header = ("method", "us min", "median", "x real time", "ratio", "steps", "us/step", "iterations/step")
    rows = [
        (
            row.name,
            f"{row.cost.minimum_us:.2f}",
            f"{row.cost.median_us:.2f}",
            f"{row.real_time:.0f}",
            f"{row.ratio:.1f}",
            str(row.steps),
            f"{row.us_per_own_step:.2f}",
            f"{row.iterations / row.steps:.2f}",
            f"{row.peak_kN:.3f}",
            f"{row.difference:.1e}",
        )
        for row in methods
    ]
    return table((*header, "peak kN", "difference"), rows)


def _sweep_table(sweep: list[WholeStop]) -> str:
    header = ("dt ms", "us/step min", "median", "x real time", "stop s", "peak kN", "difference", "Newton mean", "max")
    rows = [
        (
            f"{row.time_step_ms:g}",
            f"{row.cost.minimum_us:.2f}",
            f"{row.cost.median_us:.2f}",
            f"{row.real_time:.0f}",
            f"{row.stop_time:.3f}",
            f"{row.peak_kN:.3f}",
            f"{row.difference:+.1e}",
            f"{row.steps.newton_iterations / row.steps.steps:.3f}",
            str(row.steps.newton_iterations_max),
        )
        for row in sweep
    ]
    return table(header, rows)


def _verdict(sweep: list[WholeStop]) -> str:
    """The cost of a step at the default time step in words; it depends on the machine, so it is no check."""
    cost = next(row.cost for row in sweep if row.time_step_ms == TIME_STEP * 1e3)
    text = f"one step of 1 ms: minimum {cost.minimum_us:.2f} us, median {cost.median_us:.2f} us"
    text += f"; less than {COST_TARGET_US:g} us: {'yes' if cost.minimum_us < COST_TARGET_US else 'no'}"
    if cost.median_us > NOISY * cost.minimum_us:
        text += " (median well above minimum: something else is running here)"
    return text


if __name__ == "__main__":
    sys.exit(main())
