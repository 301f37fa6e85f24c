"""Participants in processes of their own: they say so when they have found the node, and are killed at the end."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from tests.waiting import WAIT


@contextmanager
def participant(module: str, *arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """``python -m module``, which prints a line when it has found the node; killed when the block is left."""
    process = subprocess.Popen(
        [sys.executable, "-m", module, *arguments],
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"found\n", f"{module} has not found the node"
        yield process
    finally:
        process.kill()
        process.communicate()


def end_participant(process: subprocess.Popen[bytes]) -> bytes:
    """End one with SIGTERM; what it has printed meanwhile."""
    process.terminate()
    return process.communicate(timeout=WAIT)[0]
