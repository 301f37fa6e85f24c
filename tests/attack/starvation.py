"""Attacks on `haul run` by processes that leave it little of a core."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from tests.attack.harness import Found, Outcome, haul
from tests.attack.machine import hogs
from tests.recorded import content

_RUN = ("run", "daqin_1_1_0", "--set", "max_duration_s=20", "-o", "run.mcap")


@cache
def _undisturbed() -> tuple[list[object], str]:
    """What is recorded of the run, and what is told of it, by a process that has its time."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        _, told = haul(*_RUN[:-1], str(path))
        return content(path), _facts(told)


def starved(rng: random.Random, folder: Path) -> Outcome:
    """Beside processes that never wait, on one core: the same bits."""
    whole, facts = _undisturbed()
    with hogs(rng.randint(1, 4)):
        done = subprocess.run(
            [sys.executable, "-m", "haul_ros", *_RUN], cwd=folder, capture_output=True, text=True, check=False,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        )  # fmt: skip
    if done.returncode != 0 or "Traceback" in done.stderr:
        raise Found(f"status {done.returncode}: {done.stderr[-2000:]}")
    if _facts(done.stdout) != facts:
        raise Found(f"another summary: {done.stdout}")
    if content(folder / "run.mcap") != whole:
        raise Found("a run on a busy core is recorded as another one")
    return Outcome.RAN


def _facts(summary: str) -> str:
    """A summary without what depends on the machine."""
    return "\n".join(line for line in summary.splitlines() if not line.startswith(("  speed", "  recorded")))
