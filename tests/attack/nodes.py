"""Attacks on live nodes: killed, ended, flooded, stopped, starved, with subscribers that do not listen any more."""

from __future__ import annotations

import os
import random
import re
import signal
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from mcap.reader import make_reader

from haul_ros.analysis.replay import replay_and_compare
from haul_ros.errors import RecordingError
from haul_ros.messages.cdr import typestore
from haul_ros.messages.channels import DIAGNOSTICS, Channel
from haul_ros.model.command import CommandKind
from haul_ros.recording.reader import Recording
from haul_ros.recording.recovery import recover
from haul_ros.simulation.pacing import MAX_PERIODS_BEHIND
from haul_ros.units import NS_PER_S
from tests.attack.harness import Found, Outcome
from tests.attack.machine import Idle, handles, hogs
from tests.ros.audience import stamp_of
from tests.ros.live_node import LOCOMOTIVES, TABLE, LiveNode, Observer
from tests.ros.participants import participant

UNFLUSHED = 2.0
"""Wall time [s] before a kill of which samples may be lost: a flush every second, a chunk under way, a slow machine."""
_TOLD_LATE = 0.3
"""Wall time [s] between a report of the node and its time of publication, at most, on a busy machine."""
_LOST = 10.0
"""Wall time [s] after which an emergency counts as lost."""
_STARVED = 3.0
"""Simulation time [s] by which an emergency may be late where processors are lacking."""
_REAL_TIME = 0.95
"""Real-time factor of a node that keeps up."""
_OWN_CORE = 1.2
"""Cores that a node in real time takes, flooded too, with what receives its messages here."""
_CRASH_OF_FAST_DDS = re.compile(
    r"Segmentation fault\n\nCurrent thread .*\n"  # the call where it was comes first
    r".*rclpy/node\.py\", line \d+ in destroy_node\n"
)
"""Its shared memory is taken away under the thread that closes it, once everything of the node has been done."""


class Live:
    """A node that records to ``run.mcap``, an observer, and what it has received of the couplers."""

    def __init__(self, folder: Path, observer: Observer, parameters: dict[str, object]) -> None:
        folder.mkdir()
        self.path = folder / "run.mcap"
        self.observer = observer
        self.rate, self.factor = float(str(parameters["publish_rate"])), float(str(parameters["real_time_factor"]))
        self.node = LiveNode(folder, folder.with_suffix(".log"), {"record_path": self.path} | parameters)
        self.couplers: list[tuple[float, bytes]] = []
        observer.listen(TABLE.couplers, lambda message: self.couplers.append((time.monotonic(), message)))
        self.reports: list[Any] = observer.watch_typed(TABLE.diagnostics)

    def begin(self) -> None:
        """Wait for the first sample."""
        self.observer.wait_until(lambda: bool(self.couplers), "a sample")

    def go_on(self) -> None:
        """Wait for a sample that the node makes from now on."""
        before = len(self.couplers)
        self.observer.receive_for(0.1)
        self.observer.wait_until(lambda: len(self.couplers) > before + 1, "a further sample")

    def drive(self, rng: random.Random, seconds: float) -> None:
        """Give commands at random for so long [s]."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            kind = rng.choice((CommandKind.BRAKE, CommandKind.BRAKE, CommandKind.TRACTION, CommandKind.EMERGENCY))
            value: float | bool = rng.random() * (300e3 if kind is CommandKind.TRACTION else 1.0)
            if kind is CommandKind.EMERGENCY:
                value = rng.random() < 0.3
            self.observer.send(rng.choice(LOCOMOTIVES), kind, value)
            self.observer.receive_for(rng.uniform(0.0, 0.3))

    def end(self, number: int = signal.SIGTERM, status: int = 0) -> None:
        """End the node; Found unless it ends as it should, or Fast DDS crashes in the way that is known of it.

        Before Python runs the first line of haul_ros a signal does what it does to any process.
        """
        awake = handles(self.node.process.pid, signal.SIGTERM)
        ended = self.node.end(number)
        if not awake and not self.couplers:
            return
        if ended == -signal.SIGSEGV and _CRASH_OF_FAST_DDS.search(self.node.log):
            print("the middleware crashed while the node was taken apart, which is known (docs/attack.md)", flush=True)
        elif ended != status or "Traceback" in self.node.log:
            raise Found(f"{signal.Signals(number).name}: status {ended}: {self.node.log[-2000:]}")

    def check_recording(self) -> None:
        """Found unless the recording is whole, repeatable, has what was received and tells of the time it lost."""
        check_recording(self.path, [message for _, message in self.couplers])
        if self.factor > 0.0:
            check_lost_time(self.path, self.rate, self.factor)

    def factor_since(self, began: tuple[float, int]) -> float:
        """Simulated over wall time since `now`."""
        wall, simulated = self.now()
        return (simulated - began[1]) / NS_PER_S / (wall - began[0])

    def now(self) -> tuple[float, int]:
        """Wall time [s] and simulation time [ns] of the newest sample, once what has come is received."""
        self.observer.receive_for(0.2)
        received, message = self.couplers[-1]
        return received, stamp_of(message)


@contextmanager
def live(folder: Path, **parameters: object) -> Iterator[Live]:
    """A node, gone after the block."""
    with ExitStack() as stack:
        observer = Observer()
        stack.callback(observer.close)
        node = Live(folder / "run", observer, {"publish_rate": 50.0, "real_time_factor": 1.0, **parameters})
        stack.callback(node.node.leave_nothing_running)
        stack.callback(lambda: node.node.process.send_signal(signal.SIGCONT))
        yield node


def check_recording(path: Path, received: list[bytes], *, ended: bool = True) -> None:
    """Found unless a recording is whole and repeatable, and has all the samples that were received."""
    with Recording(path) as recording:
        info, found = recording.info(), replay_and_compare(recording)
    if ended and not info.complete:
        raise Found(f"recording not complete: {info.dropped} dropped")
    if not found.identical:
        raise Found(f"replay: {found}")
    with path.open("rb") as stream:
        messages = make_reader(stream).iter_messages(topics=[TABLE.couplers.topic])
        recorded = {message.data for _, _, message in messages}
    lost = [message for message in received if message not in recorded]
    if lost:
        raise Found(f"{len(lost)} of {len(received)} samples received are not recorded, from {stamp_of(lost[0])} ns on")


def check_lost_time(path: Path, rate: float, factor: float) -> None:
    """Found unless the wall time of the last report is that of the simulation and the missed periods together."""
    early = [wall - log / factor for log, wall, _ in _messages(path, TABLE.couplers) if log < 0.5 * NS_PER_S]
    *_, (_, wall, data) = _messages(path, TABLE.diagnostics)
    values = pacing(typestore().deserialize_cdr(data, DIAGNOSTICS))
    told = (float(values["simulation time [s]"]) + int(values["missed periods"]) / rate) / factor
    passed = (wall - min(early)) / NS_PER_S
    if not -_TOLD_LATE < passed - told < _TOLD_LATE + (MAX_PERIODS_BEHIND + 2) / rate / factor:
        raise Found(f"{passed:.3f} s have passed, the node tells of {told:.3f} s: {values}")


def _messages(path: Path, channel: Channel) -> list[tuple[int, int, bytes]]:
    with path.open("rb") as stream:
        found = make_reader(stream).iter_messages(topics=[channel.topic])
        return [(message.log_time, message.publish_time, message.data) for _, _, message in found]


def values_of(report: Any, part: str) -> dict[str, str]:
    """The figures of one part of a diagnostic message."""
    (status,) = (status for status in report.status if status.name == f"haul: {part}")
    return {entry.key: entry.value for entry in status.values}


def pacing(report: Any) -> dict[str, str]:
    """How the loop kept time."""
    return values_of(report, "pacing")


def _arrived(report: Any) -> int:
    """Commands that have come to the node."""
    return sum(map(int, values_of(report, "commands").values()))


def killed(rng: random.Random, folder: Path) -> Outcome:
    """SIGKILL at any moment: what is older is recovered and repeatable. SIGINT, SIGTERM, SIGHUP: the file is whole."""
    number = rng.choice((signal.SIGKILL, signal.SIGKILL, signal.SIGINT, signal.SIGTERM, signal.SIGHUP))
    rate, factor = rng.choice(((20.0, 0.0), (50.0, 1.0), (100.0, 1.0), (500.0, 1.0), (50.0, 5.0)))
    compression = rng.choice(("zstd", "lz4", "none"))
    with live(folder, publish_rate=rate, real_time_factor=factor, record_compression=compression) as run:
        if rng.random() < 0.25:
            run.observer.receive_for(rng.uniform(0.0, 3.0))  # while it starts
        else:
            run.begin()
            run.drive(rng, rng.uniform(0.0, 4.0))
        at = time.monotonic()
        if number != signal.SIGKILL:
            run.end(number)
            run.observer.receive_for(0.1)
        else:
            run.node.process.kill()
            run.node.wait_for_end()
        active = run.path.with_name("run.mcap.active")
        if active.exists() and number != signal.SIGKILL:
            raise Found(f"{number.name} has left {active.name}")
        if number != signal.SIGKILL:
            if run.path.exists():
                check_recording(run.path, [message for _, message in run.couplers])
            elif run.couplers:
                raise Found("no recording of a node that was ended")
        elif run.path.exists():
            raise Found("a killed recorder has given its file a name")
        elif run.couplers or active.exists():
            _check_recovered(active, [message for when, message in run.couplers if when < at - UNFLUSHED])
    return Outcome.RAN


def _check_recovered(active: Path, flushed: list[bytes]) -> None:
    whole = active.with_name("whole.mcap")
    try:
        found = recover(active, whole)
    except RecordingError as error:
        if flushed:
            raise Found(f"not recovered: {error}") from error
        return
    if found.missing or found.repeated:
        raise Found(f"lost of a killed recording: {found}")
    if found.messages and found.end_ns:
        check_recording(whole, flushed, ended=False)
    elif flushed:
        raise Found(f"nothing recovered of {len(flushed)} samples: {found}")


def flooded(rng: random.Random, folder: Path) -> Outcome:
    """Demands at full speed: an emergency takes effect within two sample periods, and real time is kept.

    Both are asked for only where, before the flood, there were idle cores for all of it and one to spare; elsewhere
    the emergency may wait for processors as everything else.
    """
    rate, floods = rng.choice((5.0, 10.0, 20.0)), rng.randint(1, 3)
    with live(folder, publish_rate=rate) as run, ExitStack() as stack:
        run.begin()
        idle = Idle()
        run.observer.receive_for(1.0)
        spare = idle.cores - floods
        for number in range(floods):
            kind = (CommandKind.BRAKE, CommandKind.TRACTION)[number % 2]
            topics = [TABLE.commands[kind][locomotive].topic for locomotive in ("master", "slave_1", "slave_2")]
            stack.enter_context(participant("tests.ros.flood", *topics))
        run.observer.receive_for(1.2)  # a report of the time before
        first, began = run.reports[-1], run.now()
        emergency = run.observer.watch_typed(TABLE.applied_brake["master"])
        run.observer.receive_for(2.5)
        factor, last = run.factor_since(began), run.reports[-1]
        sent_ns = time.time_ns()
        run.observer.send("master", CommandKind.EMERGENCY, True)
        until = time.monotonic() + _LOST
        while time.monotonic() < until and not any(applied.data == 1.0 for applied in emergency):
            run.observer.receive_for(0.2)
        stack.close()
        run.end()
        wall = (last.header.stamp.sec - first.header.stamp.sec) or 1
        arrived = (_arrived(last) - _arrived(first)) / wall
        asked = spare > _OWN_CORE - 1.0
        print(
            f"floods: {floods} processes, {arrived:.0f} commands/s reached the node at {rate:g} Hz, real-time factor "
            f"{factor:.3f} ({'asked for' if asked else 'not asked for'}: {spare:.1f} cores to spare)",
            flush=True,
        )
        if asked and factor < _REAL_TIME:
            raise Found(f"real-time factor {factor:.3f} in a flood by {floods} processes, {spare:.1f} cores to spare")
        _check_emergency(run.path, sent_ns, rate, slack=0.0 if asked else _STARVED)
        run.check_recording()
    return Outcome.RAN


def _check_emergency(path: Path, sent_ns: int, rate: float, slack: float) -> None:
    emergencies = _messages(path, TABLE.commands[CommandKind.EMERGENCY]["master"])
    if not emergencies:
        raise Found("an emergency was lost in a flood")
    before = max(log for log, wall, _ in _messages(path, TABLE.couplers) if wall <= sent_ns)
    late = (emergencies[0][0] - before) / NS_PER_S
    if late > 2.0 / rate + slack:
        raise Found(f"an emergency took effect {late:.3f} s of simulation after it was sent, at {rate:g} Hz")


def frozen(rng: random.Random, folder: Path) -> Outcome:
    """Subscribers that stop listening, for good or for a while: the node and the others go on as if there were none."""
    with live(folder, publish_rate=rng.choice((20.0, 50.0, 100.0))) as run, ExitStack() as stack:
        topics = [channel.topic for channel in TABLE if not channel.received]
        audience = [
            stack.enter_context(participant("tests.ros.audience", str(rng.randint(1, 3)), *topics))
            for _ in range(rng.randint(1, 2))
        ]
        run.begin()
        idle, began = Idle(), run.now()
        until = time.monotonic() + rng.uniform(2.0, 4.0)
        while time.monotonic() < until:
            process = rng.choice(audience)
            process.send_signal(rng.choice((signal.SIGSTOP, signal.SIGSTOP, signal.SIGCONT)))
            run.drive(rng, rng.uniform(0.0, 0.5))
        factor, spare = run.factor_since(began), idle.cores
        run.go_on()
        run.end()
        if spare > 0.25 and factor < _REAL_TIME:
            raise Found(f"real-time factor {factor:.3f} with frozen subscribers, {spare:.1f} cores idle")
        run.check_recording()
    return Outcome.RAN


def resumed(rng: random.Random, folder: Path) -> Outcome:
    """The node stopped and resumed: it goes on where it was, tells how much it missed, and hears of what was sent."""
    rate = rng.choice((20.0, 50.0, 500.0))
    with live(folder, publish_rate=rate) as run:
        run.begin()
        run.observer.send("slave_1", CommandKind.BRAKE, 0.1)  # makes its publisher known
        run.drive(rng, rng.uniform(0.0, 1.0))
        stopped = 0.0
        for _ in range(rng.randint(1, 3)):
            before, seconds = time.monotonic(), rng.uniform(0.05, 2.0)
            run.node.process.send_signal(signal.SIGSTOP)
            if seconds > 0.3:
                run.observer.send("slave_1", CommandKind.BRAKE, 0.5)
            time.sleep(max(0.0, seconds - (time.monotonic() - before)))
            run.node.process.send_signal(signal.SIGCONT)
            stopped = max(stopped, time.monotonic() - before)
            run.drive(rng, rng.uniform(0.0, 0.7))
        run.go_on()
        run.observer.receive_for(2.3)  # two reports
        missed = int(pacing(run.reports[-1])["missed periods"])
        run.end()
        if missed < (stopped - _TOLD_LATE) * rate - 2 * MAX_PERIODS_BEHIND:
            raise Found(f"stopped for {stopped:.3f} s at {rate:g} Hz, {missed} periods told of as missed")
        run.check_recording()
    return Outcome.RAN


def starved(rng: random.Random, folder: Path) -> Outcome:
    """One core for the node and processes that never wait: no sample lost, the same bits, and the lost time is told."""
    rate, factor = rng.choice(((50.0, 1.0), (500.0, 1.0), (50.0, 10.0), (100.0, 4.0)))
    cores = os.sched_getaffinity(0)
    with hogs(rng.randint(1, 4)) as away, live(folder, publish_rate=rate, real_time_factor=factor) as run:
        os.sched_setaffinity(0, cores)  # the observer does not starve
        run.begin()
        run.drive(rng, rng.uniform(1.0, 3.0))
        away()
        run.go_on()
        run.observer.receive_for(1.3)  # a report
        run.end()
        run.check_recording()
    return Outcome.RAN
