"""A study from its definition to its tables, figure and findings in a folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from haul_ros.analysis.plotting import save_png
from haul_ros.analysis.tables import write_pieces, write_table
from haul_ros.studies.case import Case, CaseResult, Finished
from haul_ros.studies.claims import Claim
from haul_ros.studies.errors import StudyError
from haul_ros.studies.kinds.kind import Conclusion, Kind
from haul_ros.studies.kinds.table import KINDS
from haul_ros.studies.pools import Pool
from haul_ros.studies.runner import Done, run_cases
from haul_ros.studies.store import ResultStore
from haul_ros.studies.sweep import Sweep
from haul_ros.studies.tables import case_row, columns, profile_table

RESULTS_FILE = "results.sqlite"
"""Finished cases of all studies in a folder."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a study has brought: ``finished`` of ``total`` cases, findings if all, and the files written.

    ``unconverged`` and ``faulty`` are names of cases whose numbers are doubtful: steps that did not converge, an
    energy balance that does not hold. ``caveats`` are as those of a `Scenario`. ``refused`` says which results that
    were kept in the folder could not be used and were computed again.
    """

    study: Sweep
    finished: int
    total: int
    claims: tuple[Claim, ...] = ()
    files: tuple[Path, ...] = ()
    unconverged: tuple[str, ...] = ()
    faulty: tuple[str, ...] = ()
    caveats: tuple[str, ...] = ()
    refused: tuple[str, ...] = ()

    @property
    def complete(self) -> bool:
        """Every case has run."""
        return self.finished == self.total


@dataclass(frozen=True, slots=True)
class _Stored:
    """Finished cases, read one by one, and again, as often as one goes through them."""

    store: ResultStore
    done: Sequence[Done]

    def __iter__(self) -> Iterator[Finished[CaseResult]]:
        return (Finished(done.case, self.store[done.key]) for done in self.done)


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
    caveats = study.check()
    kind = KINDS[study.kind]
    if kind.compute is not None:
        return replace(_compute(study, kind, kind.compute, folder, on_finished), caveats=caveats)
    with open_pool() as pool, _store(folder) as store:
        done = run_cases(study.cases(), pool, store, on_finished=on_finished, stop=stop)
        with _writing(folder):
            outcome = _write(study, kind, folder, _Stored(store, done))
            return replace(outcome, caveats=caveats, refused=tuple(store.refused.values()))


@contextmanager
def _writing(folder: Path) -> Iterator[None]:
    """Name what cannot be written, in a folder that is made if missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        raise StudyError(f"{error.filename or folder}: cannot be written: {error.strerror or error}") from error


def _store(folder: Path) -> ResultStore:
    with _writing(folder):
        return ResultStore(folder / RESULTS_FILE)


def _compute(
    study: Sweep, kind: Kind, compute: Callable[[Case], object], folder: Path, on_finished: Callable[[], None]
) -> Outcome:
    """A study whose cases are not simulated: quick, so that nothing is kept."""
    finished = []
    for case in study.cases():
        finished.append(Finished(case, compute(case)))
        on_finished()
    conclusion = kind.conclude(study, finished)
    with _writing(folder):
        files = _write_conclusion(study, folder, conclusion)
    return Outcome(study, len(finished), len(finished), tuple(conclusion.claims), tuple(files))


def _write(study: Sweep, kind: Kind, folder: Path, stored: _Stored) -> Outcome:
    if not stored.done:
        return Outcome(study, 0, len(study))
    rows = [case_row(finished, study.paper_values(finished.case)) for finished in stored]
    files = write_table(columns(rows), folder / study.name)
    files += write_pieces((profile_table(finished) for finished in stored), folder / f"{study.name}_profiles")
    claims: Sequence[Claim] = ()
    if len(stored.done) == len(study):
        conclusion = kind.conclude(study, stored)
        claims = conclusion.claims
        files += _write_conclusion(study, folder, conclusion)
    unconverged = tuple(str(row["case"]) for row in rows if row["unconverged_steps"])
    faulty = tuple(str(row["case"]) for row in rows if row["energy_fault"])
    return Outcome(study, len(stored.done), len(study), tuple(claims), tuple(files), unconverged, faulty)


def _write_conclusion(study: Sweep, folder: Path, conclusion: Conclusion) -> list[Path]:
    files = []
    for suffix, table in conclusion.tables.items():
        files += write_table(table, folder / f"{study.name}{suffix}")
    if conclusion.figure is not None:
        files.append(folder / f"{study.name}.png")
        save_png(conclusion.figure, files[-1])
    return files
