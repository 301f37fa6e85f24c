from __future__ import annotations

import math
import sqlite3
import time
from collections.abc import Callable
from concurrent.futures import Executor, Future, wait
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from haul_ros.model.scenario import Scenario
from haul_ros.studies import runner
from haul_ros.studies.case import Answer, Case, answer, key, simulate
from haul_ros.studies.errors import StudyError
from haul_ros.studies.pools import Pool, cluster_pool, local_pool
from haul_ros.studies.runner import run_cases
from haul_ros.studies.store import ResultStore

Cases = Callable[[int], list[Case]]


def payloads(store: ResultStore, cases: list[Case]) -> list[bytes]:
    with local_pool(1) as pool:
        return [store[done.key].to_bytes() for done in run_cases(cases, pool, store)]


def counted(monkeypatch: pytest.MonkeyPatch) -> list[Scenario]:
    """The scenarios that are simulated from now on."""
    run: list[Scenario] = []

    def answer_and_note(scenario: Scenario, stop: Callable[[], bool]) -> Answer:
        run.append(scenario)
        return answer(scenario, stop)

    monkeypatch.setattr(runner, "answer", answer_and_note)
    return run


def test_one_thread_and_several_give_the_same_bits_in_the_same_order(tmp_path: Path, speeds: Cases) -> None:
    found = []
    for jobs in (1, 4):
        with ResultStore(tmp_path / f"{jobs}.sqlite") as store:
            with local_pool(jobs) as pool:
                done = run_cases(speeds(8), pool, store)
            assert [d.case.name for d in done] == [f"case {n}" for n in range(8)]
            found.append(payloads(store, speeds(8)))
    assert found[0] == found[1] == [simulate(case.load()).to_bytes() for case in speeds(8)]


def test_finished_cases_are_not_run_again(tmp_path: Path, speeds: Cases, monkeypatch: pytest.MonkeyPatch) -> None:
    run = counted(monkeypatch)
    for count in (3, 5):
        with ResultStore(tmp_path / "results.sqlite") as store, local_pool(2) as pool:
            assert len(run_cases(speeds(count), pool, store)) == count
    assert len(run) == 5


def test_stopped_early_finished_cases_are_kept_and_no_further_one_begins(tmp_path: Path, speeds: Cases) -> None:
    finished: list[None] = []
    with ResultStore(tmp_path / "results.sqlite") as store, local_pool(1) as pool:
        done = run_cases(
            speeds(20), pool, store, on_finished=lambda: finished.append(None), stop=lambda: len(finished) >= 3
        )
        assert 3 <= len(done) <= 6
    with ResultStore(tmp_path / "results.sqlite") as store, local_pool(1) as pool:
        assert all(d.key in store for d in done)
        assert len(run_cases(speeds(20), pool, store)) == 20


@pytest.mark.parametrize("how", ["stop", "error"])
def test_long_cases_under_way_are_given_up_within_a_second_and_finished_ones_kept(
    tmp_path: Path, speeds: Cases, short: str, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    """A second of processor time for each of the two: they would take minutes."""
    grades = [{"from_m": 0, "grade_permille": -2}]
    endless = {"commands": [], "max_duration_s": 80_000, "track": {"grades": grades}}
    long = [Case(f"long {n}", short, {**endless, "initial_speed_kmh": 60 + n}, {}) for n in range(2)]
    begun = counted(monkeypatch)
    finished: list[None] = []
    given_up: list[float] = []

    def due() -> bool:
        if len(begun) < 4 or len(finished) < 2:
            return False
        given_up.append(time.process_time())
        return True

    def stop() -> bool:
        return how == "stop" and due()

    def check() -> None:
        if how == "error" and due():
            raise StudyError("lost")

    with ResultStore(tmp_path / "results.sqlite") as store:
        with local_pool(2) as pool, nullcontext() if how == "stop" else pytest.raises(StudyError, match="lost"):
            watched = replace(pool, check=check)
            done = run_cases([*speeds(2), *long], watched, store, on_finished=lambda: finished.append(None), stop=stop)
            assert [found.case.name for found in done] == ["case 0", "case 1"]
        assert time.process_time() < given_up[0] + 2.0
        assert [key(case.load()) in store for case in [*speeds(2), *long]] == [True, True, False, False]


def test_equal_cases_are_run_once(tmp_path: Path, speeds: Cases, monkeypatch: pytest.MonkeyPatch) -> None:
    run = counted(monkeypatch)
    finished: list[None] = []
    with ResultStore(tmp_path / "results.sqlite") as store, local_pool(2) as pool:
        assert len(run_cases(speeds(1) * 4, pool, store, on_finished=lambda: finished.append(None))) == 4
    assert len(run) == 1
    assert len(finished) == 4


class Held(Executor):
    """Computes its oldest case when the runner waits, and nothing before: it never runs ahead of the runner."""

    def __init__(self) -> None:
        self.held: list[tuple[Future[object], Callable[[], object]]] = []
        self.most = 0

    def submit(self, function, /, *arguments, **keywords):  # type: ignore[no-untyped-def]
        self.held.append((Future(), partial(function, *arguments, **keywords)))
        self.most = max(self.most, len(self.held))
        return self.held[-1][0]

    def wait(self, *arguments: Any, **keywords: Any) -> object:
        future, compute = self.held.pop(0)
        future.set_result(compute())
        return wait(*arguments, **keywords)


def test_as_many_cases_are_handed_out_as_there_is_room_for_and_no_more(
    tmp_path: Path, speeds: Cases, monkeypatch: pytest.MonkeyPatch
) -> None:
    executor = Held()
    monkeypatch.setattr(runner, "wait", executor.wait)
    with ResultStore(tmp_path / "results.sqlite") as store:
        assert len(run_cases(iter(speeds(12)), Pool(executor, 3), store)) == 12
    assert executor.most == 3


def test_a_case_that_cannot_run_is_named_and_the_others_are_kept(tmp_path: Path, speeds: Cases, short: str) -> None:
    end = [{"at_s": 0.5, "locomotive": "master", "emergency": False}]
    begin = [{"at_s": 0.25, "locomotive": "master", "emergency": True}]
    wrong = Case("ends too early", short, {"commands": begin + end}, {})
    with ResultStore(tmp_path / "results.sqlite") as store, local_pool(1) as pool:
        with pytest.raises(StudyError, match=r"case ends too early: .* ends at standstill only"):
            run_cases([*speeds(2), wrong], pool, store)
        assert len(payloads(store, speeds(2))) == 2


def test_a_store_of_another_kind_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "results.sqlite"
    path.write_bytes(b"no database at all, but long enough to be read as the head of one" * 20)
    with pytest.raises(StudyError, match=r"results\.sqlite: not usable as results of studies: .*not a database"):
        ResultStore(path)


def damage(path: Path, statement: str) -> None:
    with sqlite3.connect(path) as database:
        database.execute(statement)
    database.close()


@pytest.mark.parametrize(
    ("statement", "count"),
    [
        ("UPDATE results SET result = substr(result, 1, length(result) - 100)", 2),
        ("UPDATE results SET result = X'504B0304'", 2),
        ("UPDATE results SET result = 'text'", 2),
        ("UPDATE results SET result = NULL", 2),
        ("UPDATE results SET result = substr(result, 1, 500) || X'00' || substr(result, 502)", 2),
        ("UPDATE results SET result = (SELECT result FROM results WHERE name = 'case 0')", 1),
    ],
)
def test_what_is_kept_but_damaged_or_swapped_is_told_and_computed_again(
    tmp_path: Path, speeds: Cases, monkeypatch: pytest.MonkeyPatch, statement: str, count: int
) -> None:
    path = tmp_path / "results.sqlite"
    with ResultStore(path) as store:
        before = payloads(store, speeds(2))
    damage(path, statement)
    run = counted(monkeypatch)
    with ResultStore(path) as store:
        assert payloads(store, speeds(2)) == before
        refused = [told.partition(":")[0] for told in store.refused.values()]
    assert len(run) == len(refused) == count


def test_a_result_without_all_numbers_is_not_kept(
    tmp_path: Path, speeds: Cases, monkeypatch: pytest.MonkeyPatch
) -> None:
    def incomplete(scenario: Scenario, _stop: object) -> Answer:
        found = answer(scenario)
        return found._replace(result=replace(found.result, distance=math.nan))

    monkeypatch.setattr(runner, "answer", incomplete)
    with ResultStore(tmp_path / "results.sqlite") as store, local_pool(1) as pool:
        with pytest.raises(StudyError, match="case 0: not all numbers of its result are finite"):
            run_cases(speeds(1), pool, store)
        assert run_cases([], pool, store) == []


def test_a_kept_result_without_all_numbers_is_computed_again(tmp_path: Path, speeds: Cases) -> None:
    (case,) = speeds(1)
    scenario = case.load()
    with ResultStore(tmp_path / "results.sqlite") as store:
        store.add(key(scenario), case.name, replace(simulate(scenario), relative_imbalance=math.nan))
        assert key(scenario) not in store


def test_the_answer_of_other_sources_is_refused(tmp_path: Path, speeds: Cases, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "answer", lambda scenario, _: answer(scenario)._replace(key="another"))
    with ResultStore(tmp_path / "results.sqlite") as store, local_pool(1) as pool:
        with pytest.raises(StudyError, match="case 0: was computed with other sources of haul_ros"):
            run_cases(speeds(1), pool, store)
        assert key(speeds(1)[0].load()) not in store


def test_a_link_in_the_place_of_the_store_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "results.sqlite").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(StudyError, match=r"results\.sqlite: is a link"):
        ResultStore(tmp_path / "results.sqlite")
    assert not (tmp_path / "elsewhere").exists()


def test_who_computes_is_looked_after_while_cases_finish_too(tmp_path: Path, speeds: Cases) -> None:
    looks: list[None] = []
    with ResultStore(tmp_path / "results.sqlite") as store, local_pool(1) as pool:
        watched = replace(pool, check=lambda: looks.append(None))
        run_cases(speeds(4), watched, store)
    assert len(looks) >= 4


def test_an_address_that_is_none_is_refused_at_once() -> None:
    pytest.importorskip("distributed")
    with pytest.raises(StudyError, match="scheduler nonsense: not there, expected tcp://HOST:PORT"), \
            cluster_pool("nonsense"):  # fmt: skip
        pass
