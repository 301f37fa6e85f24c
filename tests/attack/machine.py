"""What the machine has, and what it does beside: ROS, mounts, idle cores, processes that take a core for themselves."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path


def without_ros() -> str:
    """What is lacking of ROS; empty: nothing."""
    return "" if find_spec("rclpy") and find_spec("rcl_interfaces") else "needs rclpy"


def without_mounts() -> str:
    """What is lacking to mount a file system of one's own; empty: nothing."""
    if os.geteuid() != 0:
        return "needs root, to mount a tmpfs"
    try:
        with tempfile.TemporaryDirectory() as folder, small_disk(Path(folder), 100_000):
            return ""
    except (OSError, subprocess.CalledProcessError):
        return "needs the right to mount a tmpfs"


@contextmanager
def small_disk(folder: Path, size: int) -> Iterator[Path]:
    """A file system in memory of so many bytes; gone after the block, whoever still has files of it open."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], check=True, capture_output=True)
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=False, capture_output=True)


class Idle:
    """Processor time that nobody took, on all cores since it was made."""

    def __init__(self) -> None:
        self._began, self._idle = time.monotonic(), _idle_seconds()

    @property
    def cores(self) -> float:
        """How many cores were idle on average."""
        return (_idle_seconds() - self._idle) / max(time.monotonic() - self._began, 1e-9)


def _idle_seconds() -> float:
    fields = Path("/proc/stat").read_text("ascii").split(maxsplit=6)
    return (int(fields[4]) + int(fields[5])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def hogs(count: int) -> Iterator[Callable[[], None]]:
    """One core for this thread, for what it starts inside the block, and for so many processes that never wait.

    The function that it gives takes the hogs away.
    """
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    with ExitStack() as stack:
        stack.callback(os.sched_setaffinity, 0, before)
        taken = stack.enter_context(ExitStack())
        for _ in range(count):
            hog = subprocess.Popen([sys.executable, "-S", "-c", "while True: pass"])
            taken.callback(hog.wait)
            taken.callback(hog.kill)
        yield taken.close


def handles(process: int, number: int) -> bool:
    """Whether a process has a handler of its own for a signal."""
    lines = Path(f"/proc/{process}/status").read_text("ascii").splitlines()
    (caught,) = (int(line.split()[1], 16) for line in lines if line.startswith("SigCgt"))
    return bool(caught >> (number - 1) & 1)
