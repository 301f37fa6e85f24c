"""A real Dask scheduler and two worker processes, one of them killed while the sweep runs."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import pytest

from haul_ros.studies import heartbeat, pools
from haul_ros.studies.case import Case, key, simulate
from haul_ros.studies.errors import StudyError
from haul_ros.studies.pools import cluster_pool
from haul_ros.studies.runner import run_cases
from haul_ros.studies.store import ResultStore
from tests.waiting import WAIT, wait_until

pytest.importorskip("distributed")

from distributed import Client

ROOT = Path(__file__).parents[2]


@dataclass
class Cluster:
    """A scheduler and its workers, each a process."""

    folder: Path
    processes: ExitStack
    scheduler: subprocess.Popen[bytes] | None = None

    def start(self, program: str, *arguments: str, root: Path = ROOT) -> subprocess.Popen[bytes]:
        path = os.pathsep.join([str(root), *filter(None, [os.environ.get("PYTHONPATH")])])
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{program}", *arguments],
            cwd=self.folder,
            env=os.environ | {"PYTHONPATH": path},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.processes.callback(process.wait)
        self.processes.callback(process.kill)
        return process

    @property
    def file(self) -> Path:
        return self.folder / "scheduler.json"

    def address(self) -> str:
        """Address of the scheduler, once it is up."""
        wait_until(lambda: self.file.exists() and bool(self.file.read_text("utf-8")), "the scheduler")
        return str(json.loads(self.file.read_text("utf-8"))["address"])

    def worker(self, root: Path = ROOT) -> subprocess.Popen[bytes]:
        options = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(self.folder))
        return self.start("dask_worker", "--scheduler-file", str(self.file), *options, root=root)


@pytest.fixture
def cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cluster]:
    monkeypatch.setattr(pools, "CONNECT_TIMEOUT", WAIT)  # a worker takes long to start on a busy machine
    with ExitStack() as processes:
        found = Cluster(tmp_path, processes)
        found.scheduler = found.start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
                                      "--scheduler-file", str(found.file))  # fmt: skip
        yield found


@pytest.mark.slow
def test_a_worker_is_killed_mid_sweep_and_nothing_is_lost(
    cluster: Cluster, tmp_path: Path, speeds: Callable[[int], list[Case]]
) -> None:
    address = cluster.address()
    workers = [cluster.worker(), cluster.worker()]
    cases = speeds(24)
    finished: list[None] = []

    def count() -> None:
        finished.append(None)
        if len(finished) == 5:
            workers[0].kill()

    with cluster_pool(address) as pool, ResultStore(tmp_path / "results.sqlite") as store:
        done = run_cases(cases, pool, store, on_finished=count)
        found = [store[d.key].to_bytes() for d in done]
    assert workers[0].wait(WAIT) != 0
    assert workers[1].poll() is None
    assert len(finished) == 24
    assert found == [simulate(case.load()).to_bytes() for case in cases]


@pytest.fixture
def other_sources(tmp_path: Path) -> Path:
    """A checkout of the same version in which every slope of a draft gear is steeper."""
    root = tmp_path / "other"
    shutil.copytree(ROOT / "haul_ros", root / "haul_ros")
    shutil.copytree(ROOT / "config", root / "config")
    hinges = root / "haul_ros/physics/hinges.py"
    text = hinges.read_text("utf-8")
    assert text.count("np.diff(") >= 1
    hinges.write_text(text.replace("np.diff(", "1.2 * np.diff(", 1), "utf-8")
    return root


@pytest.mark.no_cover
def test_workers_with_other_sources_of_the_same_version_are_refused(cluster: Cluster, other_sources: Path) -> None:
    address = cluster.address()
    cluster.worker(other_sources)
    with pytest.raises(StudyError, match="workers have other sources of haul_ros"), cluster_pool(address):
        pass


@pytest.mark.slow
def test_a_worker_with_other_sources_that_comes_later_poisons_nothing(
    cluster: Cluster, other_sources: Path, tmp_path: Path, speeds: Callable[[int], list[Case]]
) -> None:
    address = cluster.address()
    honest = cluster.worker()
    with cluster_pool(address) as pool, ResultStore(tmp_path / "results.sqlite") as store:
        cluster.worker(other_sources)
        pool.executor._client.wait_for_workers(2, timeout=WAIT)  # type: ignore[attr-defined]
        honest.kill()
        with pytest.raises(StudyError, match="was computed with other sources of haul_ros"):
            run_cases(speeds(3), pool, store)
        assert not [case for case in speeds(3) if key(case.load()) in store]


@pytest.mark.slow
@pytest.mark.parametrize("frozen", ["scheduler", "no workers"])
def test_a_cluster_that_does_nothing_any_more_is_given_up(
    cluster: Cluster,
    tmp_path: Path,
    speeds: Callable[[int], list[Case]],
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    frozen: str,
) -> None:
    by_default = heartbeat.GIVEN_UP_AFTER
    for name, seconds in {"ASK_AGAIN": 0.3, "TOLD_AFTER": 1.0, "GIVEN_UP_AFTER": 3.0}.items():
        monkeypatch.setattr(heartbeat, name, seconds)
    monkeypatch.setattr(pools, "_CLOSE_TIMEOUT", 1.0)
    address = cluster.address()
    worker = cluster.worker()
    assert cluster.scheduler is not None
    problem = "does not answer" if frozen == "scheduler" else "has no workers any more"
    with (
        ResultStore(tmp_path / "results.sqlite") as store,
        pytest.raises(StudyError, match=f"({problem}|does not answer), given up after 3 s; finished cases are kept"),
        cluster_pool(address) as pool,
    ):
        if frozen == "scheduler":
            cluster.scheduler.send_signal(signal.SIGSTOP)
        else:
            worker.kill()
        began = time.monotonic()
        run_cases(speeds(3), pool, store)
    assert ", trying on for" in caplog.text
    assert time.monotonic() - began < by_default


def test_a_scheduler_without_workers_is_named(cluster: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    address = cluster.address()
    wait = Client.wait_for_workers
    monkeypatch.setattr(Client, "wait_for_workers", lambda self, n, timeout: wait(self, n, timeout=0.5))
    with pytest.raises(StudyError, match="has no workers, start some: dask worker"), cluster_pool(address):
        pass


def test_a_scheduler_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pools, "CONNECT_TIMEOUT", 0.5)
    with (
        pytest.raises(StudyError, match=r"scheduler tcp://127\.0\.0\.1:9: not there"),
        cluster_pool("tcp://127.0.0.1:9"),
    ):
        pass
