"""A study from its definition to its tables, figure and findings in a folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from haul_ros.analysis.plotting import save_png
from haul_ros.analysis.tables import write_pieces, write_table
from haul_ros.model.sample import FloatArray
from haul_ros.studies import vibration
from haul_ros.studies.case import CaseResult
from haul_ros.studies.claims import JUDGES, Claim, Results, effect_of_pairs
from haul_ros.studies.errors import StudyError
from haul_ros.studies.figures import (
    map_figure,
    modes_figure,
    profiles_figure,
    quantiles_figure,
    single_figure,
)
from haul_ros.studies.pools import Pool
from haul_ros.studies.runner import Done, run_cases
from haul_ros.studies.store import ResultStore
from haul_ros.studies.sweep import PaperValues, Sweep
from haul_ros.studies.tables import case_row, columns, profile_table, quantile_table

RESULTS_FILE = "results.sqlite"
"""Finished cases of all studies in a folder."""

_MOST_LINES = 8
"""Cases that a figure shows one by one."""

_FITTED = {"draft gear B": ("set B", 220.0, 2.0), "draft gear A": ("set A", 250.0, 1.0)}
"""Places of the two fitted parameter sets on the map: wave speed [m/s] and build-up time [s]."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a study has brought: ``finished`` of ``total`` cases, findings if all, and the files written.

    ``unconverged`` are names of cases whose numbers are doubtful.
    """

    study: Sweep
    finished: int
    total: int
    claims: tuple[Claim, ...] = ()
    files: tuple[Path, ...] = ()
    unconverged: tuple[str, ...] = ()

    @property
    def complete(self) -> bool:
        """Every case has run."""
        return self.finished == self.total


def run_study(
    study: Sweep,
    folder: Path,
    open_pool: Callable[[], AbstractContextManager[Pool]],
    *,
    on_finished: Callable[[], None] = lambda: None,
    stop: Callable[[], bool] = lambda: False,
) -> Outcome:
    """Run what is missing in the folder, made if there is none, and write tables, figure and findings.

    Stopped early, tables hold the finished cases, and there is no figure and no finding; called
    again, it goes on from there.

    Raises
    ------
    HaulError
        The study cannot be, or cannot be run or written; nothing is made in the folder unless all axes can be loaded.
    """
    study.check()
    if _is_vibration(study):
        return _vibration(study, folder)
    with open_pool() as pool, _store(folder) as store:
        done = run_cases(study.cases(), pool, store, on_finished=on_finished, stop=stop)
        try:
            return _write(study, folder, store, done)
        except OSError as error:
            raise _unwritable(folder, error) from error


def _is_vibration(study: Sweep) -> bool:
    return study.shipped and study.name == "vibration"


def _store(folder: Path) -> ResultStore:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _unwritable(folder, error) from error
    return ResultStore(folder / RESULTS_FILE)


def _unwritable(folder: Path, error: OSError) -> StudyError:
    return StudyError(f"{error.filename or folder}: cannot be written: {error.strerror or error}")


def _write(study: Sweep, folder: Path, store: ResultStore, done: Sequence[Done]) -> Outcome:
    if not done:
        return Outcome(study, 0, len(study))
    rows = [case_row(d.case, store[d.key], study.paper.get(d.case.name, PaperValues())) for d in done]
    files = write_table(columns(rows), folder / study.name)
    files += write_pieces((profile_table(d.case, store[d.key]) for d in done), folder / f"{study.name}_profiles")
    claims: list[Claim] = []
    if len(done) == len(study):
        figure, claims, more = _conclude(study, folder, store, done)
        files += more
        if figure is not None:
            files.append(folder / f"{study.name}.png")
            save_png(figure, files[-1])
    unconverged = tuple(str(row["case"]) for row in rows if row["unconverged_steps"])
    return Outcome(study, len(done), len(study), tuple(claims), tuple(files), unconverged)


def _conclude(
    study: Sweep, folder: Path, store: ResultStore, done: Sequence[Done]
) -> tuple[Figure | None, list[Claim], list[Path]]:
    """Figure, findings and further tables of a complete study."""
    if study.shipped and study.name in JUDGES:
        results = {d.case.name: store[d.key] for d in done}
        return _figure(study, results), JUDGES[study.name](results, study.paper), []
    if len(done) <= _MOST_LINES and not study.draws:
        return _figure(study, {d.case.name: store[d.key] for d in done}), [], []
    forces, position = _forces(store[d.key] for d in done)
    if forces is None:  # trains of different length have no quantiles by coupler
        return None, [], []
    files = write_table(quantile_table(forces, position), folder / f"{study.name}_quantiles")
    low, middle, high = np.quantile(forces.max(axis=1), (0.05, 0.5, 0.95)) / 1e3
    found = f"median {middle:.1f} kN, 5 to 95 % of {len(done)} cases between {low:.1f} and {high:.1f} kN"
    return quantiles_figure(forces, position, study.description), [Claim("largest force", None, found)], files


def _forces(results: Iterator[CaseResult]) -> tuple[FloatArray | None, FloatArray]:
    """|F| (n_cases, n_couplers) [N] and the places of the couplers; None if the trains differ in length."""
    rows, position = [], np.empty(0)
    for result in results:
        rows.append(result.force)
        position = result.position
        if len(rows[0]) != len(rows[-1]):
            return None, position
    return np.array(rows), position


def _figure(study: Sweep, results: Results) -> Figure:
    if study.shipped and study.name == "rigid-arm-map":
        return _map(study, results)
    if len(results) == 1:
        ((name, result),) = results.items()
        return single_figure(result, study.paper.get(name, PaperValues()), study.description)
    return profiles_figure(results, study.paper, study.description)


def _map(study: Sweep, results: Results) -> Figure:
    gears, waves, times, _ = study.axes
    speeds, durations = ([float(str(p.values[axis.name])) for p in axis.points] for axis in (waves, times))
    effects = np.array(list(effect_of_pairs(results).values())).reshape(-1, len(speeds), len(durations))
    maps = {gear.name: effects[number] for number, gear in enumerate(gears.points)}
    return map_figure(maps, speeds, durations, _FITTED, study.description)


def _vibration(study: Sweep, folder: Path) -> Outcome:
    modes = vibration.solve(study)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        files = write_table(vibration.frequency_table(modes), folder / study.name)
        files += write_table(vibration.shape_table(modes[vibration.SHOWN]), folder / f"{study.name}_modes")
        files.append(folder / f"{study.name}.png")
        save_png(modes_figure(modes, vibration.SHOWN, study.description), files[-1])
    except OSError as error:
        raise _unwritable(folder, error) from error
    return Outcome(study, len(modes), len(modes), tuple(vibration.judge(modes)), tuple(files))
