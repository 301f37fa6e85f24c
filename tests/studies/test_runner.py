from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from unittest.mock import Mock

import pytest

from haul_ros.studies import runner
from haul_ros.studies.case import Case, CaseResult, simulate
from haul_ros.studies.errors import StudyError
from haul_ros.studies.pools import Pool, cluster_pool, local_pool
from haul_ros.studies.runner import run_cases
from haul_ros.studies.store import ResultStore

Cases = Callable[[int], list[Case]]


def payloads(store: ResultStore, cases: list[Case]) -> list[bytes]:
    with local_pool(1) as pool:
        return [store[done.key].to_bytes() for done in run_cases(cases, pool, store)]


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
    run = Mock(wraps=simulate)
    monkeypatch.setattr(runner, "simulate", run)
    for count in (3, 5):
        with ResultStore(tmp_path / "results.sqlite") as store, local_pool(2) as pool:
            assert len(run_cases(speeds(count), pool, store)) == count
    assert run.call_count == 5


def test_stopped_early_finished_cases_are_kept_and_no_further_one_begins(tmp_path: Path, speeds: Cases) -> None:
    told: list[None] = []
    with ResultStore(tmp_path / "results.sqlite") as store, local_pool(1) as pool:
        done = run_cases(speeds(20), pool, store, told=lambda: told.append(None), stop=lambda: len(told) >= 3)
        assert 3 <= len(done) <= 6
    with ResultStore(tmp_path / "results.sqlite") as store, local_pool(1) as pool:
        assert all(d.key in store for d in done)
        assert len(run_cases(speeds(20), pool, store)) == 20


def test_equal_cases_are_run_once(tmp_path: Path, speeds: Cases, monkeypatch: pytest.MonkeyPatch) -> None:
    run = Mock(wraps=simulate)
    monkeypatch.setattr(runner, "simulate", run)
    told: list[None] = []
    with ResultStore(tmp_path / "results.sqlite") as store, local_pool(2) as pool:
        assert len(run_cases(speeds(1) * 4, pool, store, told=lambda: told.append(None))) == 4
    assert run.call_count == 1
    assert len(told) == 4


def test_no_more_cases_are_handed_out_than_there_is_room_for(tmp_path: Path, speeds: Cases) -> None:
    class Counting(ThreadPoolExecutor):
        waiting = most = 0

        def submit(self, *arguments, **keywords):  # type: ignore[no-untyped-def]
            self.waiting += 1
            self.most = max(self.most, self.waiting)
            future = super().submit(*arguments, **keywords)
            future.add_done_callback(lambda _: setattr(self, "waiting", self.waiting - 1))
            return future

    with ResultStore(tmp_path / "results.sqlite") as store, Counting(1) as executor:
        run_cases(iter(speeds(12)), Pool(executor, 3), store)
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


def test_a_damaged_result_is_refused(tmp_path: Path, short: str) -> None:
    class Damaged(CaseResult):
        def to_bytes(self) -> bytes:
            return super().to_bytes()[:-100]

    result = simulate(Case("a", short, {}, {}).load())
    damaged = Damaged(**{name: getattr(result, name) for name in CaseResult.__slots__})
    with ResultStore(tmp_path / "results.sqlite") as store:
        store.add("a", "a", damaged)
        with pytest.raises(StudyError, match="damaged"):
            store["a"]


def test_an_address_that_is_none_is_refused_at_once() -> None:
    pytest.importorskip("distributed")
    with pytest.raises(StudyError, match="scheduler nonsense: not there, expected tcp://HOST:PORT"), \
            cluster_pool("nonsense"):  # fmt: skip
        pass
