"""What writing and reading recordings costs, and whether a fast recording keeps up.

    python -m benchmarks.recording [--minutes 10] [--json]

Three measurements on daqin_1_2_1 (207 couplers, 208 vehicles), each against the usual way in the same run:
bytes of a coupler message by our encoder and by rclpy's serialisation of a message that is filled already; arrays of
all samples of a file of 60 000 messages by our reader and by mcap-ros2-support's decoder; and couplers, vehicles and
pressure recorded at 1 kHz in real time while the train rolls: nothing dropped, memory flat after the first tenth.

Exit status 1 if anything that must hold does not. Needs rclpy (extra ``ros``, or a sourced ROS 2 Jazzy) and
mcap-ros2-support (extra ``test``), Linux, and some 300 MB of temporary space for each minute.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from benchmarks.report import Check, checks_table, machine, pairs, table
from haul_ros.messages.cdr import JointStateCodec
from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.sample import Sample
from haul_ros.recording.reader import Recording
from haul_ros.recording.writer import McapRecorder
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session
from haul_ros.units import NS_PER_S

SCENARIO = "daqin_1_2_1"
READ_SAMPLES = 20_000
"""Of three messages each."""
ENCODE_REPEATS = 2_000
RATE = 1_000
PERIOD_NS = NS_PER_S // RATE

ENCODER_RATIO = 10.0
READER_RATIO = 20.0
MEMORY_GROWTH_MB = 8.0
LATEST_MS = 1000.0


@dataclass(frozen=True, slots=True)
class Result:
    """Times per message [us], of reading a whole file [s]; of the fast recording what became of it."""

    encoder_us: float
    rclpy_us: float
    reader_s: float
    decoder_s: float
    minutes: float
    samples: int
    written: int
    dropped: int
    recording_bytes: int
    lateness_end_ms: float
    cpu_percent: float
    memory_start_mb: float
    memory_growth_mb: float


def main() -> int:
    """Measure, print; the exit status is 1 if something that must hold does not."""
    arguments = _arguments()
    facts = machine(["numpy", "mcap", "mcap-ros2-support", "zstandard"])
    with TemporaryDirectory() as folder:
        encoder_us, rclpy_us = _encoding()
        reader_s, decoder_s = _reading(Path(folder) / "read.mcap")
        fast = _fast_recording(Path(folder) / "fast.mcap", arguments.minutes)
    result = Result(encoder_us, rclpy_us, reader_s, decoder_s, arguments.minutes, *fast)
    checks = _checks(result)
    if arguments.json:
        print(json.dumps({"machine": facts, "result": asdict(result), "checks": [asdict(c) for c in checks]}, indent=2))
    else:
        _print_tables(facts, result, checks)
    return 0 if all(check.holds for check in checks) else 1


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Encoder, reader and fast recording against the usual ways.")
    parser.add_argument("--minutes", type=float, default=10.0, help="length of the fast recording (default 10)")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    arguments = parser.parse_args()
    if not 0.1 <= arguments.minutes <= 1000.0:
        parser.error(f"argument --minutes: {arguments.minutes:g}, must be from 0.1 to 1000")
    return arguments


def _best(action: Callable[[], object], repeats: int) -> float:
    """Shortest wall time [s] of some repetitions: other programs only ever add to it."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        action()
        times.append(time.perf_counter() - began)
    return min(times)


def _encoding() -> tuple[float, float]:
    """Time per coupler message [us]: ours, and rclpy's."""
    session = Session(load_scenario(SCENARIO), play_commands=True)
    sample = session.advance(5_000)
    codec = JointStateCodec(session.consist.coupler_names)
    values = (sample.time_ns, sample.stroke, sample.stroke_rate, sample.coupler_force)
    message = JointState(
        name=list(session.consist.coupler_names),
        position=sample.stroke,
        velocity=sample.stroke_rate,
        effort=sample.coupler_force,
    )
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(sample.time_ns, NS_PER_S)
    assert deserialize_message(codec.encode(*values), JointState) == message

    def ours() -> None:
        for _ in range(ENCODE_REPEATS):
            codec.encode(*values)

    def theirs() -> None:
        for _ in range(ENCODE_REPEATS):
            serialize_message(message)

    return _best(ours, 5) / ENCODE_REPEATS * 1e6, _best(theirs, 5) / ENCODE_REPEATS * 1e6


def _reading(path: Path) -> tuple[float, float]:
    """Time [s] to read all samples of a file into arrays: ours, and with mcap-ros2-support's decoder."""
    scenario = load_scenario(SCENARIO)
    session, encoder = Session(scenario, play_commands=True), TelemetryEncoder(scenario.consist)
    with McapRecorder(path, scenario, encoder.channels, when_full="block") as recorder:
        for _ in range(READ_SAMPLES):
            recorder.put(encoder.sample(session.advance(2)), 0)

    def ours() -> None:
        with Recording(path) as recording:
            forces.append(recording.samples().couplers.force)
        del forces[:-1]

    forces: list[np.ndarray] = []
    seconds = _best(ours, 3)
    began = time.perf_counter()
    arrays: dict[str, list[tuple[np.ndarray, ...]]] = {channel.topic: [] for channel in encoder.channels}
    with path.open("rb") as stream:
        for decoded in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            message = decoded.decoded_message
            lists = (
                (message.data,)
                if decoded.channel.topic == encoder.channels.brake_cylinder_pressure.topic
                else (message.position, message.velocity, message.effort)
            )
            arrays[decoded.channel.topic].append(tuple(np.array(values) for values in lists))
    stacked = {topic: [np.stack(column) for column in zip(*rows, strict=True)] for topic, rows in arrays.items()}
    theirs = time.perf_counter() - began
    assert np.array_equal(stacked[encoder.channels.couplers.topic][2], forces[-1])
    return seconds, theirs


def _fast_recording(path: Path, minutes: float) -> tuple[int, int, int, int, float, float, float, float]:
    """Record at 1 kHz in real time; the last fields of `Result`."""
    scenario = load_scenario(SCENARIO, {"commands": [], "sample_rate_hz": RATE, "max_duration_s": 60.0 * minutes})
    session, encoder = Session(scenario), TelemetryEncoder(scenario.consist)
    samples = round(60 * minutes * RATE)
    memory = []
    with McapRecorder(path, scenario, encoder.channels) as recorder:
        began_ns, cpu = time.monotonic_ns(), time.process_time()
        for number in range(1, samples + 1):
            sample: Sample = session.advance()
            recorder.put(encoder.sample(sample), time.time_ns())
            if number % RATE == 0:
                memory.append(_resident_mb())
            wait_ns = began_ns + number * PERIOD_NS - time.monotonic_ns()
            if wait_ns > 0:
                time.sleep(wait_ns / NS_PER_S)
        elapsed_ns, used = time.monotonic_ns() - began_ns, time.process_time() - cpu
    status = recorder.status
    settled = memory[len(memory) // 10]
    return (
        samples,
        status.written,
        status.dropped,
        status.bytes,
        (elapsed_ns - samples * PERIOD_NS) / 1e6,
        100.0 * used * NS_PER_S / elapsed_ns,
        settled,
        max(memory[len(memory) // 10 :]) - settled,
    )


def _resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4096 / 1e6


def _checks(result: Result) -> list[Check]:
    encoder, reader = result.rclpy_us / result.encoder_us, result.decoder_s / result.reader_s
    late = result.lateness_end_ms
    return [
        Check("encoder faster than rclpy", f"{encoder:.1f} x", f">= {ENCODER_RATIO:g} x", encoder >= ENCODER_RATIO),
        Check("reader faster than decoder", f"{reader:.1f} x", f">= {READER_RATIO:g} x", reader >= READER_RATIO),
        Check("1 kHz: messages dropped", str(result.dropped), "0", result.dropped == 0),
        Check(
            "1 kHz: messages written",
            str(result.written),
            str(3 * result.samples),
            result.written == 3 * result.samples,
        ),
        Check("1 kHz: late at the end", f"{late:.1f} ms", f"<= {LATEST_MS:g} ms", late <= LATEST_MS),
        Check(
            "1 kHz: memory growth",
            f"{result.memory_growth_mb:.1f} MB",
            f"<= {MEMORY_GROWTH_MB:g} MB",
            result.memory_growth_mb <= MEMORY_GROWTH_MB,
        ),
    ]


def _print_tables(facts: dict[str, str], result: Result, checks: list[Check]) -> None:
    print(pairs(facts))
    rows = [
        ("bytes of a coupler message, encoder", f"{result.encoder_us:.2f} us"),
        ("  rclpy.serialization.serialize_message", f"{result.rclpy_us:.2f} us"),
        ("60 000 messages into arrays, Recording.samples", f"{result.reader_s:.2f} s"),
        ("  mcap-ros2-support's decoder and numpy.array", f"{result.decoder_s:.2f} s"),
        (f"1 kHz for {result.minutes:g} min", f"{result.samples} samples, {result.recording_bytes / 1e6:.0f} MB"),
        ("  processor time, simulation included", f"{result.cpu_percent:.1f} % of a core"),
        ("  resident memory", f"{result.memory_start_mb:.0f} MB, growing by {result.memory_growth_mb:.1f} MB"),
    ]
    print(f"\n{SCENARIO}\n")
    print(table(("recordings", ""), rows))
    print()
    print(checks_table(checks))


if __name__ == "__main__":
    sys.exit(main())
