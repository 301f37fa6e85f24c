"""Attacks by disks that fill up or go away while something is recorded on them."""

from __future__ import annotations

import random
import signal
import subprocess
import time
from pathlib import Path

from haul_ros.errors import RecordingError
from haul_ros.recording.recovery import recover
from tests.attack.harness import Found, Outcome
from tests.attack.machine import small_disk, without_ros
from tests.attack.processes import end, started, wait_for


def vanishing(rng: random.Random, folder: Path) -> Outcome:
    """Told, the run or the node goes on and ends with a status of its own, and what is there is recovered."""
    (folder / "disk").mkdir()
    full = rng.random() < 0.6
    size = 4096 * rng.randint(60, 500) if full else 200_000_000
    with small_disk(folder / "disk", size) as disk:
        (_by_node if not without_ros() and rng.random() < 0.5 else _by_run)(rng, folder, disk, full)
        if list(disk.glob("*.mcap")):
            raise Found("a recording that failed has been given its name")
        if full:
            _check_what_is_left(disk / "run.mcap.active", folder / "whole.mcap")
        elif list(disk.iterdir()):
            raise Found("something was written where the disk had been")
    return Outcome.RAN


def _by_run(rng: random.Random, folder: Path, disk: Path, full: bool) -> None:
    process = started(folder, "-o", str(disk / "run.mcap"), "--compression", "none")
    wait_for(disk / "run.mcap.active", 1)
    time.sleep(rng.uniform(0.0, 1.0))
    if not full:
        _take_away(disk)
    time.sleep(2.0)
    process.send_signal(signal.SIGINT)
    status, told = end(process)
    if status != 2 or "recording failed" not in told:
        raise Found(f"status {status}: {told}")


def _by_node(rng: random.Random, folder: Path, disk: Path, full: bool) -> None:
    from tests.attack.nodes import live, pacing

    path = disk / "run.mcap"
    with live(folder, record_path=path, record_compression="none") as run:
        run.begin()
        run.observer.receive_for(rng.uniform(0.0, 1.0))
        if not full:
            _take_away(disk)
        run.observer.wait_until(
            lambda: any(status.level == b"\x02" for report in run.reports[-1:] for status in report.status),
            "a report of the recorder's failure",
        )
        run.go_on()
        run.observer.receive_for(1.2)
        if int(pacing(run.reports[-1])["missed periods"]) > 100:
            raise Found(f"a failed recording delays the train: {pacing(run.reports[-1])}")
        run.end(status=1)
        if "recording failed" not in run.node.log.splitlines()[-1]:
            raise Found(f"the node's last line is {run.node.log.splitlines()[-1]}")


def _take_away(disk: Path) -> None:
    subprocess.run(["umount", "-l", disk], check=True, capture_output=True)


def _check_what_is_left(active: Path, whole: Path) -> None:
    try:
        found = recover(active, whole)
    except RecordingError as error:
        raise Found(f"nothing recovered from a disk that was full: {error}") from error
    if found.repeated:
        raise Found(f"a recording on a full disk has messages twice: {found}")
