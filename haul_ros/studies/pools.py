"""Who computes the cases: the cores of this machine, or a Dask cluster."""

from __future__ import annotations

import asyncio
import logging
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from typing import Any

from haul_ros.studies.errors import StudyError
from haul_ros.studies.heartbeat import Heartbeat
from haul_ros.studies.sources import results_digest
from haul_ros.version import __version__

CONNECT_TIMEOUT = 10.0
"""Wall time [s] to wait for a scheduler, and then for a first worker."""

_CLOSE_TIMEOUT = 5.0
"""Wall time [s] to say goodbye to a scheduler."""

_AHEAD = 2
"""Cases handed out for each that is computed, so that nobody waits for the next one."""


def _always_there() -> None:
    """Threads of this process need no question."""


@dataclass(frozen=True, slots=True)
class Pool:
    """An executor, how many cases to hand it at a time, and a `check` for the one who waits for it.

    ``check`` never waits itself; it raises StudyError if there is nobody to wait for any more. ``local``: cases run in
    this process, and can be told to stop; those under way elsewhere are only waited for no longer.
    """

    executor: Executor
    room: int
    check: Callable[[], None] = _always_there
    local: bool = True


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def local_pool(jobs: int | None = None) -> Iterator[Pool]:
    """Threads of this process, as many as there are cores by default: the model runs without the GIL."""
    n = available_cores() if jobs is None else jobs
    with ThreadPoolExecutor(n, thread_name_prefix="case") as executor:
        yield Pool(executor, _AHEAD * n)


def _installed() -> tuple[str, str]:
    """Version and sources that make results, of the process that runs this."""
    return __version__, results_digest()


@contextmanager
def cluster_pool(address: str) -> Iterator[Pool]:
    """The workers of a Dask scheduler, such as ``tcp://10.0.0.1:8786``; a case whose worker dies goes to another one.

    Raises
    ------
    StudyError
        Dask is not installed, there is no scheduler, it has no workers, or these have another version or
        other sources of this package.
    """
    if find_spec("distributed") is None:
        raise StudyError("a cluster needs Dask distributed: pip install 'haul_ros[cluster]'")
    from distributed import Client
    from distributed.comm.addressing import parse_address, parse_host_port

    # It logs a traceback where the runner says in one line that the connection is lost.
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    try:
        # A client that was never connected waits long when it is thrown away: wrong addresses do not get that far.
        parse_host_port(parse_address(address, strict=True)[1])
        client = Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        reason = str(error).partition("\n")[0] or "no answer"
        raise StudyError(f"scheduler {address}: not there, expected tcp://HOST:PORT: {reason}") from error
    try:
        threads = _check_workers(client, address)
        heartbeat = Heartbeat(f"scheduler {address}", partial(_ask, client))
        # retries: of a case that failed by itself, not by the death of its worker
        yield Pool(client.get_executor(pure=False, retries=0), _AHEAD * threads, heartbeat.check, local=False)
    finally:
        # Nothing is waited for here: whoever uses the pool has its results, and a scheduler may never answer again.
        with suppress(OSError, TimeoutError):
            client.close(timeout=_CLOSE_TIMEOUT)


def _ask(client: Any) -> Future[str]:
    """A question to the scheduler: what is wrong there, empty: nothing."""

    async def problem() -> str:
        return "" if (await client.scheduler.identity())["workers"] else "has no workers any more"

    return asyncio.run_coroutine_threadsafe(problem(), client.loop.asyncio_loop)


def _check_workers(client: object, address: str) -> int:
    """Number of threads of all workers, which must have this version of the package."""
    from distributed import Client

    assert isinstance(client, Client)
    asked: list[Any] = []
    try:
        client.wait_for_workers(1, timeout=CONNECT_TIMEOUT)
        threads: dict[str, int] = client.nthreads()
        asked = [client.submit(_installed, workers=[worker], pure=False, retries=0) for worker in threads]
        installed = {question.result(timeout=CONNECT_TIMEOUT) for question in asked}
    except TimeoutError as error:
        problem = "its workers do not answer" if asked else f"has no workers, start some: dask worker {address}"
        raise StudyError(f"scheduler {address}: {problem}") from error
    except Exception as error:  # whatever a worker raises is raised here
        raise StudyError(f"scheduler {address}: a worker cannot use haul_ros {__version__}: {error}") from error
    if others := sorted({version for version, _ in installed} - {__version__}):
        raise StudyError(f"scheduler {address}: workers have haul_ros {', '.join(others)}, not {__version__}")
    if installed != {_installed()}:
        raise StudyError(f"scheduler {address}: workers have other sources of haul_ros {__version__} than this machine")
    return sum(threads.values())
