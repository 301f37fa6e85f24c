"""``python -m tests.soak --minutes 60``: a live node under way for a long time, watched, driven and recorded.

1 ms time steps, samples at 100 Hz, real time, 20 subscribers in four processes, a command a second. The train is driven
again when it stands. Prints a table; the exit status is 1 if anything in it does not hold, 2 without ROS.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import subprocess
import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.report import Check, checks_table
from haul_ros.errors import HaulError
from haul_ros.messages.cdr import JointStateCodec
from haul_ros.model.command import CommandKind
from haul_ros.recording.reader import Recording
from haul_ros.ros.errors import require_ros
from tests.ros.domain import own_domain

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

RATE = 100.0
PROCESSES, SUBSCRIBERS = 4, 5
"""Processes of the audience, and subscribers of each."""
WARM_UP = 0.1
"""Part of the run in which memory may grow as it likes: DDS and the allocator fill their buffers."""
GROWTH, STEPS = 340.0, 14_000.0
"""Growth of the node's memory after that, median of all minutes [kB/min], which counts as flat, and steps besides [kB].

The index of the recording, written at its end, takes 180 to 240 kB/min: two or three chunks a second, each with a place
for every topic. An object of 64 bytes that is kept of every sample would be 375 more, a sample 115 000, each minute.
Steps come and go: a busy machine fills the recorder's queue, 500 samples of 19 kB, and the allocator keeps what it had.
"""
REAL_TIME = 0.99
"""Least real-time factor of the whole run, on a machine with other work."""

Order = tuple[str, CommandKind, float | bool]


@dataclass(slots=True)
class Course:
    """What was seen: resident memory of the node [kB] and simulation time [min] over wall time [min]; what was done."""

    minutes: list[float] = field(default_factory=list)
    memory: list[float] = field(default_factory=list)
    simulated: list[float] = field(default_factory=list)
    commands: int = 0
    emergencies: int = 0
    starts: int = 0
    standing: int = 0
    errors: list[str] = field(default_factory=list)


class Driver:
    """A command a second: brakes, releases, traction, emergencies; a train that stands is released and driven again."""

    def __init__(self, rng: random.Random, observer: Observer, course: Course) -> None:
        from tests.ros.live_node import LOCOMOTIVES, TABLE

        self._rng, self._observer, self._course = rng, observer, course
        self._locomotives = LOCOMOTIVES
        self._newest = b""
        self._plan: list[Order] = []
        observer.listen(TABLE.vehicles, self._take)

    def _take(self, message: bytes) -> None:
        self._newest = message

    @property
    def minutes(self) -> float:
        """Simulation time [min] of the newest sample."""
        from tests.ros.audience import stamp_of

        return stamp_of(self._newest) / 60e9 if self._newest else 0.0

    def command(self) -> None:
        """The next command."""
        standing = bool(self._newest) and not JointStateCodec.of(self._newest).decode(self._newest)[1].any()
        self._course.standing += standing
        if not self._plan:
            self._plan = self._start() if standing else self._drive()
            self._course.starts += standing
        self._observer.send(*self._plan.pop(0))
        self._course.commands += 1

    def _start(self) -> list[Order]:
        ends: list[Order] = [(name, CommandKind.EMERGENCY, False) for name in reversed(self._locomotives)]
        releases: list[Order] = [(name, CommandKind.BRAKE, 0.0) for name in self._locomotives] * 3
        pulls: list[Order] = [("master", CommandKind.TRACTION, 400e3)] * 60
        return [*ends, *releases, *pulls]

    def _drive(self) -> list[Order]:
        locomotive = self._rng.choice(self._locomotives)
        if self._rng.random() < 0.03:
            self._course.emergencies += 1
            return [(locomotive, CommandKind.EMERGENCY, True)]
        if self._rng.random() < 0.3:
            brake: Order = (locomotive, CommandKind.BRAKE, round(self._rng.uniform(0.1, 0.8), 2))
            release: Order = (locomotive, CommandKind.BRAKE, 0.0)
            return [brake] * self._rng.randint(1, 4) + [release]
        return [("master", CommandKind.TRACTION, round(self._rng.uniform(200e3, 400e3)))]


def resident_kb(process: int) -> int:
    """Resident memory of a process [kB]."""
    lines = Path(f"/proc/{process}/status").read_text("ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS:"))


def watch(node: LiveNode, observer: Observer, course: Course, seconds: float, rng: random.Random) -> None:
    """Drive the train and look at the node, once a second."""
    from tests.ros.live_node import TABLE

    reports = observer.watch_typed(TABLE.diagnostics)
    driver = Driver(rng, observer, course)
    began = time.monotonic()
    while (passed := time.monotonic() - began) < seconds and node.process.poll() is None:
        driver.command()
        course.minutes.append(passed / 60.0)
        course.simulated.append(driver.minutes)
        course.memory.append(resident_kb(node.process.pid))
        course.errors += [f"{s.name}: {s.message}" for report in reports for s in report.status if s.level == b"\x02"]
        reports.clear()
        observer.receive_for(1.0 - (time.monotonic() - began - passed))


def run(folder: Path, minutes: float, seed: int) -> tuple[Course, list[Check]]:
    """The whole soak."""
    from tests.ros.live_node import TABLE, LiveNode, Observer
    from tests.ros.participants import end_participant, participant

    course, path = Course(), folder / "run.mcap"
    with ExitStack() as stack:
        observer = Observer()
        stack.callback(observer.close)
        parameters = {"dt": 0.001, "publish_rate": RATE, "real_time_factor": 1.0, "record_path": path}
        node = LiveNode(folder, folder / "node.log", parameters)
        stack.callback(node.leave_nothing_running)
        audience = [
            stack.enter_context(participant("tests.ros.audience", str(SUBSCRIBERS), TABLE.couplers.topic))
            for _ in range(PROCESSES)
        ]
        watch(node, observer, course, 60.0 * minutes, random.Random(seed))
        counted: list[dict[str, int]] = [c for process in audience for c in json.loads(end_participant(process))]
        status = node.end()
        log = node.log
    return course, [
        Check("ends with SIGTERM", f"status {status}", "0, no traceback", status == 0 and "Traceback" not in log),
        *_memory(course),
        Check("/diagnostics", f"{len(course.errors)} errors {' '.join(course.errors[:1])}", "0", not course.errors),
        *_received(counted),
        *_recorded(path, course),
    ]


def _memory(course: Course) -> list[Check]:
    times, memory = np.array(course.minutes), np.array(course.memory)
    later = times >= WARM_UP * times[-1]
    times, memory = times[later], memory[later]
    length = times[-1] - times[0]
    window = max(1, int(len(times) * min(1.0, length / 4.0) / length))
    growth = float(np.median((memory[window:] - memory[:-window]) / (times[window:] - times[:-window])))
    most, grown = GROWTH * length + STEPS, memory[-1] - memory[0]
    curve = " ".join(f"{kb / 1e3:.1f}" for kb in memory[np.linspace(0, len(memory) - 1, 6).astype(int)])
    return [
        Check("memory of the node", f"{growth:+.0f} kB/min, median", f"< {GROWTH:g}", growth < GROWTH),
        Check("and with its steps", f"{grown:+.0f} kB: {curve} MB", f"< {most:.0f} kB", grown < most),
    ]


def _received(counted: list[dict[str, int]]) -> list[Check]:
    received = [samples["received"] for samples in counted]
    misplaced = sum(samples["misplaced"] for samples in counted)
    complete = sum(samples["misplaced"] == 0 for samples in counted)
    told = f"{min(received)} to {max(received)} samples, {misplaced} gaps, {complete} without"
    number = PROCESSES * SUBSCRIBERS
    return [Check(f"{len(counted)} subscribers", told, f"{number}, no gap", complete == len(counted) == number)]


def _recorded(path: Path, course: Course) -> list[Check]:
    with Recording(path) as recording:
        info = recording.info()
        samples, commands = recording.count(recording.channels.couplers), len(recording.commands())
    replay = subprocess.run([sys.executable, "-m", "haul_ros", "replay", str(path)], capture_output=True, text=True)
    lines = (replay.stdout or replay.stderr).splitlines() or [""]
    passed, simulated = (times[-1] - times[5] for times in (course.minutes, course.simulated))
    factor = simulated / passed
    return [
        Check("recording complete", f"{info.messages} messages, {info.size / 1e6:.0f} MB", "complete", info.complete),
        Check("dropped", str(info.dropped), "0", info.dropped == 0),
        Check("samples", str(samples), str(expected := round(info.end_ns * RATE / 1e9)), abs(samples - expected) <= 1),
        Check("commands recorded", f"{commands} of {course.commands}", "> 80 %", commands > 0.8 * course.commands),
        Check("real-time factor", f"{factor:.4f}", f">= {REAL_TIME}", factor >= REAL_TIME),
        Check("haul replay", lines[0][:70], "identical", replay.returncode == 0 and lines[0].startswith("identical")),
    ]


def main() -> int:
    """Soak, check, tell."""
    parser = argparse.ArgumentParser(prog="python -m tests.soak", description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0, help="wall time under way, default 60")
    parser.add_argument("--seed", type=int, default=1, help="of the commands")
    arguments = parser.parse_args()
    if not 0.5 <= arguments.minutes < math.inf:
        parser.error(f"--minutes {arguments.minutes:g}: must be at least 0.5")
    try:
        require_ros()
    except HaulError as error:
        print(f"soak: {error}", file=sys.stderr)
        return 2
    os.environ.update(own_domain())
    with TemporaryDirectory(prefix="haul_soak_") as folder:
        course, checks = run(Path(folder), arguments.minutes, arguments.seed)
    commit: Any = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    print(f"{arguments.minutes:g} minutes, seed {arguments.seed}, {datetime.now(UTC):%Y-%m-%d}, commit {commit}")
    told = f"{course.emergencies} emergencies, {course.starts} starts, {course.standing} s standing"
    print(f"{course.commands} commands, {told}\n\n{checks_table(checks)}")
    return int(not all(check.holds for check in checks))


if __name__ == "__main__":
    sys.exit(main())
