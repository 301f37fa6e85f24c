"""Cases over a pool: finished ones are kept at once, those already there are not run again."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass, field
from threading import Event

from haul_ros.errors import HaulError
from haul_ros.model.scenario import Scenario
from haul_ros.studies.case import Answer, Case, CaseResult, CaseStoppedError, answer, key
from haul_ros.studies.errors import StudyError
from haul_ros.studies.pools import Pool
from haul_ros.studies.store import ResultStore
from haul_ros.version import __version__

_WAKE = 0.2
"""Wall time [s] between two checks whether to stop."""


@dataclass(frozen=True, slots=True)
class Done:
    """A case whose result is in the store."""

    case: Case
    key: str


@dataclass(slots=True)
class _Work:
    """Cases handed out and not yet finished, by what they depend on."""

    pool: Pool
    store: ResultStore
    on_finished: Callable[[], None]
    running: dict[Future[Answer], tuple[str, list[str]]] = field(default_factory=dict)
    stopping: Event = field(default_factory=Event)

    def hand_out(self, case: Case, digest: str, scenario: Scenario) -> None:
        same = next((names for other, names in self.running.values() if other == digest), None)
        if same is not None:
            same.append(case.name)
        elif digest in self.store:
            self.on_finished()
        else:
            told = [self.stopping.is_set] if self.pool.local else []
            self.running[self.pool.executor.submit(answer, scenario, *told)] = (digest, [case.name])

    def collect(self) -> None:
        """Keep what has finished meanwhile."""
        finished, _ = wait(self.running, timeout=_WAKE, return_when=FIRST_COMPLETED)
        self.pool.check()
        for future in finished:
            digest, names = self.running.pop(future)
            try:
                self.store.add(digest, names[0], _checked(digest, future.result()))
            except CaseStoppedError:
                continue
            except HaulError as error:
                raise StudyError(f"case {names[0]}: {error}") from error
            except CancelledError as error:
                raise StudyError(f"case {names[0]}: was given up: the connection to the scheduler is lost") from error
            for _name in names:
                self.on_finished()

    def withdraw(self) -> None:
        """Take back what nobody has begun, and let the others give up."""
        self.stopping.set()
        for future in [future for future in self.running if future.cancel()]:
            del self.running[future]


def _checked(digest: str, found: Answer) -> CaseResult:
    if found.key != digest:
        raise StudyError(
            f"was computed with other sources of haul_ros {__version__} than this machine's; "
            "install the same on all workers and start them again"
        )
    if not found.result.complete:
        raise StudyError("not all numbers of its result are finite")
    return found.result


def run_cases(
    cases: Iterable[Case],
    pool: Pool,
    store: ResultStore,
    *,
    on_finished: Callable[[], None] = lambda: None,
    stop: Callable[[], bool] = lambda: False,
) -> list[Done]:
    """Run the cases that the store does not have; returns those that it has then, in order.

    ``on_finished`` is called for each finished case. When ``stop`` becomes true no further case begins, those under way
    are given up, and this returns within about a second. Results do not depend on the pool, bit for bit.

    Raises
    ------
    HaulError
        A case cannot be loaded or run, the store cannot be written, or the cluster is lost; what was
        finished before is kept.
    """
    work = _Work(pool, store, on_finished)
    asked: list[Done] = []
    try:
        for case in cases:
            while len(work.running) >= pool.room and not stop():
                work.collect()
            if stop():
                break
            scenario = case.load()
            digest = key(scenario)
            work.hand_out(case, digest, scenario)
            asked.append(Done(case, digest))
        while work.running:
            if stop():
                work.withdraw()
            work.collect()
    except BaseException:
        work.withdraw()
        raise
    return [done for done in asked if done.key in store]
