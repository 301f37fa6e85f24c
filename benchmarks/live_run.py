"""One run of the live node in a process of its own, watched and driven over ROS from this one."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic, monotonic_ns
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import SetBool

from haul_ros.errors import HaulError
from haul_ros.messages.channels import Channel, channel_table
from haul_ros.model.command import CommandKind
from haul_ros.ros.publishers import endpoint

START_TIMEOUT = 120.0
"""Longest wait [s] for the node, which compiles its kernel once per installation."""
TIMEOUT = 20.0
"""Longest wait [s] for anything else."""
DRAINING = 1.0
"""Wait [s] for what a node had published before it was paused."""

CHANNELS = channel_table(("master", "slave_1", "slave_2", "slave_3"))


class LiveRunError(HaulError):
    """The node does not start, answer or end as it should."""


@dataclass(slots=True)
class Stream:
    """Messages of one topic, serialised as they came, and when each did [ns, monotonic clock]."""

    channel: Channel
    messages: list[bytes] = field(default_factory=list)
    times_ns: list[int] = field(default_factory=list)

    def take(self, message: bytes) -> None:
        """Keep a message."""
        self.times_ns.append(monotonic_ns())
        self.messages.append(message)


@dataclass(frozen=True, slots=True)
class LiveRun:
    """What was received from the instant after ``last_before`` on, while the node ran without a pause.

    ``streams`` are couplers, vehicles and brake cylinder pressure; ``last_before`` is the message of
    the couplers' topic before that. ``pacing`` holds the values of that diagnostic status, once a
    second; ``cpu_percent`` is the processor time of the node's process over wall time [% of one
    core], between a tenth and nine tenths of the run.
    """

    streams: tuple[Stream, Stream, Stream]
    last_before: bytes
    pacing: list[dict[str, str]]
    cpu_percent: float


def run_live(parameters: dict[str, object], log: Path, seconds: float, emergency_after: float) -> LiveRun:
    """Run the node for so long [s], with an emergency application after ``emergency_after`` [s].

    The node is paused just before and after: so all topics begin and end at the same instant.
    What it says goes to the file ``log``.

    Raises
    ------
    LiveRunError
        The node does not start, answer or end as it should.
    """
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["ROS_DOMAIN_ID"] = str(1 + os.getpid() % 100)
    # Over the loopback interface, not shared memory, where what a killed process left can swallow messages
    os.environ.setdefault("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")
    with _observer() as observer, _node_process(parameters, log) as process:
        observer.wait_until(observer.is_connected, START_TIMEOUT, "the node's topics")
        observer.pause(True)
        last_before = observer.start_afresh()
        observer.pause(False)
        cpu_percent = _drive(observer, process.pid, seconds, emergency_after)
        observer.pause(True)
        process.terminate()
        if (status := process.wait(TIMEOUT)) != 0:
            raise LiveRunError(f"the node ended with exit status {status}")
        return LiveRun(observer.streams, last_before, observer.pacing, cpu_percent)


class _Observer:
    """Subscriber and driver."""

    def __init__(self, executor: SingleThreadedExecutor, node: Any) -> None:
        self.streams = (Stream(CHANNELS.couplers), Stream(CHANNELS.vehicles), Stream(CHANNELS.brake_cylinder_pressure))
        self.pacing: list[dict[str, str]] = []
        self._executor = executor
        for stream in self.streams:
            message_type, topic, qos = endpoint(stream.channel)
            node.create_subscription(message_type, topic, stream.take, qos, raw=True)
        message_type, topic, qos = endpoint(CHANNELS.diagnostics)
        node.create_subscription(message_type, topic, self._take_diagnostics, qos)
        self._bool, topic, qos = endpoint(CHANNELS.commands[CommandKind.EMERGENCY]["master"])
        self._emergency = node.create_publisher(self._bool, topic, qos)
        self._pause = node.create_client(SetBool, f"{CHANNELS.prefix}/pause")

    def is_connected(self) -> bool:
        """Every topic has been heard from, and the node would hear commands."""
        heard = self._emergency.get_subscription_count() > 0 and self._pause.service_is_ready()
        return heard and bool(self.pacing) and all(stream.messages for stream in self.streams)

    def start_afresh(self) -> bytes:
        """Forget what has come so far; returns the last message of the first stream."""
        last = self.streams[0].messages[-1]
        for stream in self.streams:
            stream.messages.clear()
            stream.times_ns.clear()
        self.pacing.clear()
        return last

    def receive(self, until: float) -> None:
        """Take what comes, until this time of the monotonic clock [s]."""
        while (left := until - monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def wait_until(self, condition: Callable[[], bool], timeout: float, what: str) -> None:
        """Take what comes until the condition holds; LiveRunError after ``timeout`` [s]."""
        end = monotonic() + timeout
        while not condition():
            if monotonic() > end:
                raise LiveRunError(f"waited {timeout:g} s in vain for {what}")
            self._executor.spin_once(timeout_sec=0.05)

    def send_emergency(self) -> None:
        """Command an emergency application at the master."""
        self._emergency.publish(self._bool(data=True))

    def pause(self, paused: bool) -> None:
        """Let the node go on, or pause it and take what it has published before."""
        answer = self._pause.call_async(SetBool.Request(data=paused))
        self.wait_until(answer.done, TIMEOUT, "an answer to pause")
        if not answer.result().success:
            raise LiveRunError(f"pause: {answer.result().message}")
        if paused:
            self.receive(monotonic() + DRAINING)

    def _take_diagnostics(self, message: Any) -> None:
        for status in message.status:
            if status.name == "haul: pacing":
                self.pacing.append({pair.key: pair.value for pair in status.values})


@contextmanager
def _observer() -> Iterator[_Observer]:
    context = Context()
    context.init()
    node: Any = rclpy.create_node("benchmark", context=context, enable_rosout=False, start_parameter_services=False)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        yield _Observer(executor, node)
    finally:
        executor.shutdown()
        node.destroy_node()
        context.try_shutdown()


@contextmanager
def _node_process(parameters: dict[str, object], log: Path) -> Iterator[subprocess.Popen[bytes]]:
    """The node as users start it, ended in any case; what it said is shown if something goes wrong."""
    assignments = [part for name, value in parameters.items() for part in ("-p", f"{name}:={value}")]
    command = [sys.executable, "-m", "haul_ros.ros.node", "--ros-args", *assignments]
    with log.open("wb") as output:
        process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
    try:
        yield process
    except HaulError:
        print(log.read_text(encoding="utf-8"), file=sys.stderr, end="")
        raise
    finally:
        process.kill()
        process.wait()


def _drive(observer: _Observer, pid: int, seconds: float, emergency_after: float) -> float:
    """The run itself; returns ``cpu_percent``."""
    start = monotonic()
    readings: list[tuple[float, float]] = []

    def read_clocks() -> None:
        readings.append((monotonic(), _processor_time(pid)))

    events = [(0.1 * seconds, read_clocks), (emergency_after, observer.send_emergency), (0.9 * seconds, read_clocks)]
    for after, action in sorted(events, key=lambda event: event[0]):
        observer.receive(start + after)
        action()
    observer.receive(start + seconds)
    (began, spent_before), (ended, spent) = readings
    return 100.0 * (spent - spent_before) / (ended - began)


def _processor_time(pid: int) -> float:
    """User and system time of all threads of a process so far [s]."""
    # proc(5): behind the name, which may hold spaces, comes field 3; utime and stime are fields 14 and 15
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[14 - 3]) + int(fields[15 - 3])) / os.sysconf("SC_CLK_TCK")
