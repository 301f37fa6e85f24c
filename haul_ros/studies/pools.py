"""Who computes the cases: the cores of this machine, or a Dask cluster."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec

from haul_ros.studies.errors import StudyError
from haul_ros.version import __version__

CONNECT_TIMEOUT = 10.0
"""Wall time [s] to wait for a scheduler, and then for a first worker."""

_AHEAD = 2
"""Cases handed out for each that is computed, so that nobody waits for the next one."""


@dataclass(frozen=True, slots=True)
class Pool:
    """An executor, and how many cases to hand it at a time."""

    executor: Executor
    room: int


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def local_pool(jobs: int | None = None) -> Iterator[Pool]:
    """Threads of this process, as many as there are cores by default: the model runs without the GIL."""
    n = available_cores() if jobs is None else jobs
    with ThreadPoolExecutor(n, thread_name_prefix="case") as executor:
        yield Pool(executor, _AHEAD * n)


def _installed_version() -> str:
    return __version__


@contextmanager
def cluster_pool(address: str) -> Iterator[Pool]:
    """The workers of a Dask scheduler, such as ``tcp://10.0.0.1:8786``; a case whose worker dies goes to another one.

    Raises
    ------
    StudyError
        Dask is not installed, there is no scheduler, it has no workers, or these have another version of this package.
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
    with client:
        threads = _check_workers(client, address)
        # retries: of a case that failed by itself, not by the death of its worker
        with client.get_executor(pure=False, retries=0) as executor:
            yield Pool(executor, _AHEAD * threads)


def _check_workers(client: object, address: str) -> int:
    """Number of threads of all workers, which must have this version of the package."""
    from distributed import Client

    assert isinstance(client, Client)
    try:
        client.wait_for_workers(1, timeout=CONNECT_TIMEOUT)
        versions = set(client.run(_installed_version).values())
    except TimeoutError as error:
        raise StudyError(f"scheduler {address}: has no workers, start some: dask worker {address}") from error
    except Exception as error:  # whatever a worker raises is raised here
        raise StudyError(f"scheduler {address}: a worker cannot use haul_ros {__version__}: {error}") from error
    if versions != {__version__}:
        raise StudyError(f"scheduler {address}: workers have haul_ros {', '.join(sorted(versions))}, not {__version__}")
    return sum(client.nthreads().values())
