"""Attacks on running processes: killed, ended, stopped, without room, with their file gone."""

from __future__ import annotations

import os
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

from haul_ros.recording.reader import Recording
from haul_ros.recording.recovery import recover
from tests.attack.harness import Found, Outcome

_RUN = ("-m", "haul_ros", "run", "daqin_1_1_0", "--set", "commands=[]", "--set", "max_duration_s=80000")
_STATUS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}


def started(folder: Path, *words: str, limit: int = 0) -> subprocess.Popen[str]:
    """A run without end, in a process of its own, that records into the folder; files of at most ``limit`` bytes."""

    def limit_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    return subprocess.Popen(
        [sys.executable, *_RUN, "-o", "run.mcap", *words],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}, preexec_fn=limit_files if limit else None,
    )  # fmt: skip


def wait_for(path: Path, size: int) -> None:
    """Until a file has so many bytes."""
    until = time.monotonic() + 15.0
    while not (path.exists() and path.stat().st_size >= size):
        if time.monotonic() > until:
            raise Found("no recording within 15 s")
        time.sleep(0.01)


def end(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Exit status, and what was told; Found if that is a traceback."""
    _, told = process.communicate(timeout=15)
    if "Traceback" in told:
        raise Found(told[-2000:])
    return process.returncode, told


def killed(rng: random.Random, folder: Path) -> Outcome:
    """SIGKILL at any moment: what is older than a second is recovered."""
    process, active = started(folder), folder / "run.mcap.active"
    wait_for(active, 1)
    time.sleep(rng.uniform(0.0, 2.5))
    flushed = active.stat().st_size
    process.kill()
    process.communicate()
    if (folder / "run.mcap").exists():
        raise Found("a killed recorder has given its file a name")
    found = recover(active, folder / "whole.mcap")
    if active.stat().st_size - found.bytes_lost < min(flushed, 1) or found.missing or found.repeated:
        raise Found(f"lost of a killed recording: {found}")
    with Recording(folder / "whole.mcap") as recording:
        times = recording.couplers().time_ns
        if len(times) and (times[1:] - times[:-1] != 20_000_000).any():
            raise Found("a recovered recording has gaps")
    return Outcome.RAN


def ended(rng: random.Random, folder: Path) -> Outcome:
    """SIGINT, SIGTERM or SIGHUP at any moment, stopped and resumed before: the file is whole."""
    process = started(folder)
    wait_for(folder / "run.mcap.active", 1)
    time.sleep(rng.uniform(0.0, 1.5))
    if rng.random() < 0.3:
        process.send_signal(signal.SIGSTOP)
        time.sleep(rng.uniform(0.0, 0.5))
        process.send_signal(signal.SIGCONT)
    number = rng.choice(list(_STATUS))
    process.send_signal(number)
    status, told = end(process)
    if status != _STATUS[number]:
        raise Found(f"{number.name}: status {status}: {told}")
    with Recording(folder / "run.mcap") as recording:
        if not recording.info().complete:
            raise Found("an ended recording is not complete")
    return Outcome.RAN


def robbed(rng: random.Random, folder: Path) -> Outcome:
    """No room for the file, or the file gone, moved or replaced: told, status 2, and what is there is recovered."""
    active = folder / "run.mcap.active"
    kind = rng.choice(("full", "removed", "moved", "replaced"))
    if kind == "full":
        process = started(folder, limit=rng.randint(200_000, 3_000_000))
        wait_for(active, 1)
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
    else:
        process = started(folder)
        wait_for(active, 1)
        time.sleep(rng.uniform(0.0, 1.0))
        if kind == "moved":
            active.rename(folder / "moved")
        else:
            active.unlink()
        if kind == "replaced":
            active.symlink_to(folder / "precious")
        time.sleep(rng.uniform(0.0, 1.5))
        process.send_signal(signal.SIGINT)
    status, told = end(process)
    if kind == "full" and status == 130:  # ended before the disk was full
        return Outcome.RAN
    if status != 2 or "recording failed" not in told:
        raise Found(f"{kind}: status {status}: {told}")
    if (folder / "run.mcap").exists() or (folder / "precious").exists():
        raise Found(f"{kind}: a file that was not asked for")
    if kind == "full":
        recover(active, folder / "whole.mcap")
    return Outcome.RAN
