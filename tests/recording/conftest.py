"""What tests of recordings share."""

from __future__ import annotations

import resource
from collections.abc import Iterator

import pytest

from haul_ros.recording import run_file, writer


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks that the few messages of a test fill several of."""
    monkeypatch.setattr(run_file, "CHUNK_SIZE", 100_000)


@pytest.fixture
def frequent_flushes(monkeypatch: pytest.MonkeyPatch) -> None:
    """A test does not wait a second for each."""
    monkeypatch.setattr(writer, "FLUSH_INTERVAL", 0.05)


@pytest.fixture
def limited_file_size() -> Iterator[None]:
    """Writing a file beyond 100 kB fails, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
