"""``haul study``: the paper's studies and free sweeps."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path

from tqdm import tqdm

from haul_ros.analysis.tables import parquet_available
from haul_ros.cli.interrupt import interruption
from haul_ros.cli.layout import caveat_entries, rows
from haul_ros.errors import one_line
from haul_ros.physics.train_model import COMPILING, kernel_is_cached
from haul_ros.studies.definition import free_sweep, load_study
from haul_ros.studies.errors import StudyError
from haul_ros.studies.pools import Pool, cluster_pool, local_pool
from haul_ros.studies.study import Outcome, run_study
from haul_ros.studies.sweep import Sweep

FREE = "sweep"
"""Stands for a study that the other arguments describe."""


def study(arguments: argparse.Namespace) -> int:
    """Run a study into a folder and print what it found.

    The exit status is 130, 143 or 129 if a signal ended it early, 1 if energy came from nowhere or a step was not
    solved.
    """
    sweep = _definition(arguments)
    open_pool = _pool(arguments)
    folder: Path = arguments.output or Path(f"{sweep.name}_study")
    hidden = arguments.quiet or not sys.stderr.isatty()
    with interruption() as interrupted, tqdm(total=len(sweep), unit="case", leave=False, disable=hidden) as bar:
        outcome = run_study(sweep, folder, open_pool, on_finished=bar.update, stop=interrupted)
    _report(arguments, outcome, folder)
    if outcome.faulty or outcome.unconverged:
        return 1
    return 0 if outcome.complete else interrupted.exit_status


def _definition(arguments: argparse.Namespace) -> Sweep:
    given = [
        f"--{name}"
        for name, value in {
            "scenario": arguments.scenario,
            "set": arguments.overrides,
            "over": arguments.over,
            "draw": arguments.draw,
            "samples": arguments.samples,
            "seed": arguments.seed,
        }.items()
        if value not in (None, [])
    ]
    if arguments.study != FREE:
        if given:
            raise StudyError(f"{', '.join(given)}: only for haul study {FREE}, a study file has its own")
        return load_study(arguments.study)
    if arguments.scenario is None:
        raise StudyError(f"haul study {FREE}: expected --scenario SCENARIO")
    return free_sweep(
        arguments.scenario, arguments.overrides, arguments.over, arguments.draw, arguments.samples, arguments.seed or 0
    )


def _pool(arguments: argparse.Namespace) -> Callable[[], AbstractContextManager[Pool]]:
    if arguments.scheduler is not None:
        return partial(cluster_pool, arguments.scheduler)
    if arguments.jobs is not None and arguments.jobs < 1:
        raise StudyError(f"--jobs {arguments.jobs}: must be 1 or more")
    return partial(_cores, arguments.jobs)


def _cores(jobs: int | None) -> AbstractContextManager[Pool]:
    """Opened when the study has been checked and the first case is about to be run."""
    if not kernel_is_cached():
        print(f"haul: {COMPILING}", file=sys.stderr)
    return local_pool(jobs)


def _report(arguments: argparse.Namespace, outcome: Outcome, folder: Path) -> None:
    if arguments.json:
        print(json.dumps(_json(outcome), indent=2))
    elif not arguments.quiet:
        done = f"{outcome.finished} of {outcome.total} cases"
        print(one_line(f"{outcome.study.name}: {outcome.study.description or 'free sweep'}, {done}"))
        claims = [f"  {claim}" for claim in outcome.claims]
        written = [("written", one_line(str(file))) for file in outcome.files]
        print("\n".join([*claims, *rows([*caveat_entries(outcome.caveats), *written])]))
    _warn("computed again, what was kept cannot be used: case", outcome.refused)
    _warn("steps did not converge, do not trust the numbers of case", outcome.unconverged)
    _warn("the energy balance does not hold, do not trust the numbers of case", outcome.faulty)
    if not parquet_available():
        print("haul: Parquet not written: needs pyarrow, pip install 'haul_ros[studies]'", file=sys.stderr)
    if not outcome.complete:
        left = f"{outcome.finished} of {outcome.total} cases are kept in {folder}"
        print(one_line(f"haul: interrupted, {left}: the same command goes on from there"), file=sys.stderr)


def _warn(problem: str, cases: Sequence[str]) -> None:
    if cases:
        more = f" and {len(cases) - 1} more" if len(cases) > 1 else ""
        print(one_line(f"haul: warning: {problem} {cases[0]}{more}"), file=sys.stderr)


def _json(outcome: Outcome) -> dict[str, object]:
    return {
        "study": outcome.study.name,
        "description": outcome.study.description,
        "finished": outcome.finished,
        "cases": outcome.total,
        "claims": [
            {"claim": claim.text, "holds": claim.holds, "verdict": claim.verdict, "found": claim.found}
            for claim in outcome.claims
        ],
        "caveats": list(outcome.caveats),
        "computed_again": list(outcome.refused),
        "unconverged_cases": list(outcome.unconverged),
        "energy_fault_cases": list(outcome.faulty),
        "files": [str(file) for file in outcome.files],
    }
