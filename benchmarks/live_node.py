"""Whether the live node keeps real time, what it costs, and whether everything it tells arrives.

    python -m benchmarks.live_node [--seconds 60] [--json]

Starts the node on daqin_1_2_1 (208 vehicles) in a process of its own: 1 ms time steps, 50 Hz
telemetry, recording to MCAP, on the loopback interface and a ROS domain of its own. This process
subscribes to couplers, vehicles and brake cylinder pressure with the quality of service that the
node offers, keeps every message as it came, and sends an emergency application after 5 s.

Checked, with exit status 1 if anything fails: simulated over wall time, by when the messages
came; processor time of the node's process (all its threads, Python included) between a tenth and
nine tenths of the run; every message of the run received and recorded, one each 20 ms of
simulation time; nothing dropped by the recorder; recording and received messages equal, byte for byte.
Needs rclpy (extra ``ros``, or a sourced ROS 2 Jazzy) and Linux; takes a few seconds more than the run.
"""

from __future__ import annotations

import argparse
import json
import math
import struct
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from mcap.reader import make_reader

from benchmarks.report import Check, checks_table, machine, pairs, table
from haul_ros.errors import HaulError
from haul_ros.recording.reader import Recording
from haul_ros.ros.errors import require_ros
from haul_ros.units import NS_PER_S

if TYPE_CHECKING:
    from benchmarks.live_run import LiveRun, Stream

SCENARIO = "daqin_1_2_1"
TIME_STEP = 1e-3
PUBLISH_RATE = 50.0
PERIOD_NS = round(NS_PER_S / PUBLISH_RATE)
EMERGENCY_AFTER = 5.0
SHORTEST_RUN = 10.0

REAL_TIME_FACTOR = (0.995, 1.005)
CPU_LIMIT = 15.0
"""Processor time of the node over wall time [% of one core]."""


@dataclass(frozen=True, slots=True)
class Delivery:
    """What became of one topic: messages that the simulation time asks for, and those recorded and received.

    ``misplaced`` recorded messages are not one period after the one before; ``differing`` received
    messages are not, in the same bytes, at the same place of the recording.
    """

    topic: str
    expected: int
    recorded: int
    misplaced: int
    received: int
    differing: int


@dataclass(frozen=True, slots=True)
class Result:
    """The run in figures; step time, lateness, overruns and missed periods are from the node's diagnostics."""

    seconds: float
    real_time_factor: float
    cpu_percent: float
    step_time_us: float
    lateness_median_ms: float
    lateness_max_ms: float
    overruns: int
    missed_periods: int
    recorder_dropped: int | None
    recorded_messages: int
    recording_bytes: int
    peak_compression_kN: float  # noqa: N815, a unit
    deliveries: tuple[Delivery, ...]


def main() -> int:
    """Run the node, measure, print; the exit status is 1 if something that must hold does not, 2 without ROS."""
    arguments = _arguments()
    try:
        require_ros()
    except HaulError as error:
        print(f"live_node: {error}", file=sys.stderr)
        return 2
    facts = machine(("rclpy", "numpy", "numba"))
    try:
        result = measure(arguments.seconds)
    except HaulError as error:
        print(f"live_node: {error}", file=sys.stderr)
        return 1
    checks = requirements(result)
    if arguments.json:
        found = {"machine": facts, "run": asdict(result), "checks": [asdict(check) for check in checks]}
        print(json.dumps(found, indent=2))
    else:
        _print_tables(facts, result, checks)
    return 0 if all(check.holds for check in checks) else 1


def measure(seconds: float) -> Result:
    """Run the node for so long [s] and look at what came of it.

    Raises
    ------
    HaulError
        The node does not start, answer or end as it should, or its recording cannot be read.
    """
    from benchmarks.live_run import run_live  # needs rclpy

    with TemporaryDirectory() as folder:
        path = Path(folder, "run.mcap")
        parameters = {"scenario": SCENARIO, "dt": TIME_STEP, "publish_rate": PUBLISH_RATE, "record_path": path}
        run = run_live(parameters, Path(folder, "node.log"), seconds, EMERGENCY_AFTER)
        return _evaluate(run, path, seconds)


def requirements(result: Result) -> list[Check]:
    """What has to hold for the node to be called real-time."""
    low, high = REAL_TIME_FACTOR
    factor, cpu, dropped = result.real_time_factor, result.cpu_percent, result.recorder_dropped
    checks = [
        Check("real-time factor", f"{factor:.5f}", f"{low} .. {high}", low <= factor <= high),
        Check("processor time of the node", f"{cpu:.1f} %", f"< {CPU_LIMIT:g} % of a core", cpu < CPU_LIMIT),
        Check("dropped by the recorder", str(dropped), "0", dropped == 0),
    ]
    for row in result.deliveries:
        recorded = row.recorded == row.expected and row.misplaced == 0
        found = f"{row.recorded}, {row.misplaced} misplaced"
        checks += [
            Check(f"{row.topic}: received", str(row.received), str(row.expected), row.received == row.expected),
            Check(f"{row.topic}: recorded", found, f"{row.expected}, 0 misplaced", recorded),
            Check(f"{row.topic}: received and recorded differ", str(row.differing), "0", row.differing == 0),
        ]
    return checks


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Real-time factor, processor time and completeness of the live node.")
    parser.add_argument("--seconds", type=float, default=60.0, help="length of the run (default 60)")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    arguments = parser.parse_args()
    if not SHORTEST_RUN <= arguments.seconds < math.inf:
        parser.error(f"argument --seconds: {arguments.seconds:g}, must be at least {SHORTEST_RUN:g}")
    return arguments


def _evaluate(run: LiveRun, path: Path, seconds: float) -> Result:
    with Recording(path) as recording:
        info = recording.info()
        couplers = recording.couplers()
        peak = float(recording.last_extremes().extremes.compression.max())
    began_ns, ended_ns = _stamp(run.last_before), int(couplers.time_ns[-1])
    lateness = [float(values["lateness max [ms]"]) for values in run.pacing]
    return Result(
        seconds=seconds,
        real_time_factor=_real_time_factor(run.streams[0]),
        cpu_percent=run.cpu_percent,
        step_time_us=median(float(values["step time mean [us]"]) for values in run.pacing),
        lateness_median_ms=median(lateness),
        lateness_max_ms=max(lateness),
        overruns=int(run.pacing[-1]["overruns"]),
        missed_periods=int(run.pacing[-1]["missed periods"]),
        recorder_dropped=info.dropped,
        recorded_messages=info.messages,
        recording_bytes=info.size,
        peak_compression_kN=peak / 1e3,
        deliveries=tuple(_delivery(stream, path, began_ns, ended_ns) for stream in run.streams),
    )


def _real_time_factor(stream: Stream) -> float:
    simulated_ns = _stamp(stream.messages[-1]) - _stamp(stream.messages[0])
    return simulated_ns / (stream.times_ns[-1] - stream.times_ns[0])


def _stamp(message: bytes) -> int:
    """Simulation time [ns] in a header: seconds and nanoseconds, behind the 4 bytes of the encapsulation."""
    seconds, nanoseconds = struct.unpack_from("<iI", message, 4)
    return int(seconds) * NS_PER_S + int(nanoseconds)


def _delivery(stream: Stream, path: Path, began_ns: int, ended_ns: int) -> Delivery:
    """Compare one topic with what is recorded of it after ``began_ns`` of simulation time."""
    with path.open("rb") as file:
        messages = make_reader(file).iter_messages(topics=[stream.channel.topic])
        recorded = [(message.log_time, message.data) for _, _, message in messages if message.log_time > began_ns]
    expected = (ended_ns - began_ns) // PERIOD_NS
    due = range(began_ns + PERIOD_NS, ended_ns + 1, PERIOD_NS)
    same = sum(data == other for data, (_, other) in zip(stream.messages, recorded, strict=False))
    return Delivery(
        topic=stream.channel.topic,
        expected=expected,
        recorded=len(recorded),
        misplaced=sum(time_ns != at for (time_ns, _), at in zip(recorded, due, strict=False)),
        received=len(stream.messages),
        differing=len(stream.messages) - same,
    )


def _print_tables(facts: dict[str, str], result: Result, checks: list[Check]) -> None:
    print(pairs(facts))
    print(f"\n{SCENARIO}, {TIME_STEP * 1e3:g} ms steps, {PUBLISH_RATE:g} Hz, recording, {result.seconds:g} s\n")
    rows = [
        ("integration per step, median of the means per second", f"{result.step_time_us:.2f} us"),
        ("lateness of periods, median of the largest per second", f"{result.lateness_median_ms:.3f} ms"),
        ("lateness of periods, largest of all", f"{result.lateness_max_ms:.3f} ms"),
        ("overruns, missed periods", f"{result.overruns}, {result.missed_periods}"),
        ("recorded", f"{result.recorded_messages} messages, {result.recording_bytes / 1e6:.1f} MB"),
        ("peak compression in this stop", f"{result.peak_compression_kN:.1f} kN"),
    ]
    print(table(("node", ""), rows))
    print()
    print(checks_table(checks))


if __name__ == "__main__":
    sys.exit(main())
