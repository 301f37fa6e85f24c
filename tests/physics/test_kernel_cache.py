"""Damage to the machine code that is kept on disk: compiled again, never run."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from numba.core.caching import IndexDataCacheFile

from haul_ros.physics.kernel._cache import SealedCacheFile
from tests.waiting import WAIT

CALL = """
import numpy as np
from haul_ros.physics.kernel import _jit

@_jit.entry
def double(x):
    return 2.0 * x

print(_jit.is_cached(double), double(4.0), _jit.is_cached(double), sum(double.stats.cache_hits.values()))
"""


def cut(path: Path) -> None:
    os.truncate(path, path.stat().st_size // 2)


def empty(path: Path) -> None:
    os.truncate(path, 0)


def flip(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def scramble(path: Path) -> None:
    path.write_bytes(os.urandom(2000))


def remove(path: Path) -> None:
    path.unlink()


@pytest.mark.parametrize("damage", [cut, empty, flip, scramble, remove])
@pytest.mark.parametrize("kind", ["nbi", "nbc", "sha256"])
def test_damaged_files_are_as_good_as_none(tmp_path: Path, kind: str, damage: Callable[[Path], None]) -> None:
    def opened() -> SealedCacheFile:
        return SealedCacheFile.taking_over(IndexDataCacheFile(str(tmp_path), "kernel", "stamp"))  # type: ignore[no-untyped-call]

    assert (opened().whole(), opened().load("key")) == (False, None)
    opened().save("key", list(range(100)))
    assert (opened().whole(), opened().load("key")) == (True, list(range(100)))
    (file,) = tmp_path.glob(f"*.{kind}")
    damage(file)
    assert (opened().whole(), opened().load("key")) == (False, None)
    opened().save("key", list(range(100)))
    assert (opened().whole(), opened().load("key")) == (True, list(range(100)))


@pytest.mark.slow
def test_damaged_machine_code_is_compiled_again(tmp_path: Path) -> None:
    (tmp_path / "call.py").write_text(CALL)

    def call() -> str:
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "NUMBA_DISABLE_JIT": "0"}
        root = Path(__file__).parents[2]
        environment["PYTHONPATH"] = os.pathsep.join([str(root), *filter(None, [os.environ.get("PYTHONPATH")])])
        done = subprocess.run(
            [sys.executable, "call.py"], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=WAIT
        )
        assert done.stderr == ""
        return done.stdout.strip()

    assert call() == "False 8.0 True 0"
    assert call() == "True 8.0 True 1"
    (file,) = (tmp_path / "cache").rglob("*.nbc")
    flip(file)
    assert call() == "False 8.0 True 0"
