"""What tests of recordings share."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterator

import pytest

from haul_ros.recording import run_file


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks that the few messages of a test fill several of."""
    monkeypatch.setattr(run_file, "CHUNK_SIZE", 100_000)


@pytest.fixture
def wait_until() -> Callable[[Callable[[], bool]], None]:
    """Wait for a condition that another thread brings about."""

    def wait(condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + 30.0
        while not condition():
            assert time.monotonic() < deadline, "condition not reached"
            time.sleep(0.001)

    return wait


@pytest.fixture
def limited_file_size() -> Iterator[None]:
    """Writing a file beyond 100 kB fails, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
