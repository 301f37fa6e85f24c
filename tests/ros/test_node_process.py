"""The process around the node: what is refused with which exit status, and how it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy")

from haul_ros.model.command import CommandKind
from haul_ros.recording.reader import Recording
from haul_ros.ros.node import main
from haul_ros.ros.signals import EndingSignals
from tests.ros.live_node import TABLE, Couplers
from tests.waiting import WAIT

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

    StartNode = Callable[..., LiveNode]


def printed(capfd: pytest.CaptureFixture[str]) -> list[str]:
    """Lines on standard error, without those that rcl prints by itself."""
    return [line for line in capfd.readouterr().err.splitlines() if "[rcl]" not in line]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["daqin_1_2_1"], "unexpected argument 'daqin_1_2_1'; parameters are given as --ros-args -p name:=value"),
        (["--ros-args", "-p", "scenario"], "ROS 2 cannot be started with these arguments: "),
        (["--ros-args", "--wrong"], "ROS 2 cannot be started with these arguments: "),
        (["--ros-args", "-p", "scenario:=daqin"], "daqin: no such scenario"),
        (["--ros-args", "-p", "scenario:=wrong.yaml"], "wrong.yaml:2: "),
        (["--ros-args", "-p", "dt:=-0.001"], "parameter dt = -0.001, must be 1e-06 to 0.1 s"),
        (["--ros-args", "-p", "dt:=0.0007"], "must be a whole number of them"),
        (["--ros-args", "-p", "initial_spead:=1.0"], "parameter initial_spead is unknown; did you mean initial_speed?"),
        (["--ros-args", "-p", "radio.slave_9.delay:=1.0"], "slave_9: no such locomotive"),
        (["--ros-args", "-p", "record_compression:=zip"], "must be one of zstd, lz4, none"),
        (["--ros-args", "-p", "record_path:=missing/run.mcap"], "missing/run.mcap: folder missing does not exist"),
        (["--ros-args", "-p", "record_path:=taken.mcap"], "taken.mcap: exists already"),
        (["--ros-args", "-p", "record_path:=."], ".: is a folder, expected a new file"),
        (["--ros-args", "-p", "scenario:=[]"], "a parameter has no value: "),
        (["--ros-args", "-p", "scenario:=[a]"], "parameter scenario = ['a'], must be text"),
        (["--ros-args", "-p", "max_recordings:=1.5"], "parameter max_recordings = 1.5, must be a whole number"),
    ],
)
def test_a_users_mistake_ends_with_one_line_status_2_and_no_file(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("taken.mcap").write_text("somebody's")
    Path("wrong.yaml").write_text("consist: [\n")
    assert main(arguments) == 2
    (line,) = printed(capfd)
    assert line.startswith("train_node: ")
    assert message in line
    assert sorted(path.name for path in tmp_path.iterdir()) == ["taken.mcap", "wrong.yaml"]
    assert Path("taken.mcap").read_text() == "somebody's"


@pytest.mark.parametrize(
    "arguments", [["--help"], ["-h"], ["--ros-args", "-p", "dt:=9.0", "--", "--help"], ["-h", "--ros-args"]]
)
def test_help_is_printed_also_where_there_is_no_ros(
    arguments: list[str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    monkeypatch.setitem(sys.modules, "rcl_interfaces", None)
    assert main(arguments) == 0
    printed = capfd.readouterr()
    assert printed.err == ""
    assert printed.out.startswith("usage: train_node [-h] [--ros-args ")
    assert "  radio.<slave>.delay *\n      time from a command" in printed.out
    assert 'of the recording: one of zstd, lz4, none; default: "zstd"' in printed.out


def test_help_among_the_arguments_of_ros_is_ross_own(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["--ros-args", "--help"]) == 2
    assert "ROS 2 cannot be started with these arguments: " in printed(capfd)[-1]


def test_without_rclpy_the_message_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    assert main([]) == 2
    (line,) = printed(capfd)
    assert "pip install 'haul_ros[ros]', or source ROS 2 Jazzy" in line


def test_without_a_middleware_the_message_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def init(**_: object) -> None:
        raise ImportError("failed to load shared library 'librmw_fastrtps_cpp.so'\nmore\n")

    monkeypatch.setattr("rclpy.init", init)
    assert main([]) == 2
    (line,) = printed(capfd)
    assert "'librmw_fastrtps_cpp.so'" in line
    assert "pip install 'haul_ros[ros]', or source ROS 2 Jazzy" in line


@pytest.mark.parametrize("signal_number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_signal_ends_the_node_with_status_0_and_a_whole_recording(
    start_node: StartNode, observer: Observer, signal_number: int
) -> None:
    node = start_node()
    couplers = Couplers(observer)
    couplers.wait_for_time(10**9)
    assert node.end(signal_number) == 0
    assert "Traceback" not in node.log
    (path,) = node.folder.iterdir()
    assert path.name.startswith("daqin_1_2_1_")
    with Recording(path) as recording:
        assert recording.info().complete
        assert recording.couplers().time_ns[-1] >= couplers.time_ns


def test_many_signals_while_it_ends_do_no_harm(start_node: StartNode, observer: Observer) -> None:
    node = start_node(record_path="run.mcap")
    Couplers(observer).wait_for_time(0)
    for _ in range(5):
        node.process.send_signal(signal.SIGINT)
    assert node.wait_for_end() == 0
    with Recording(node.folder / "run.mcap") as recording:
        assert recording.info().complete


@pytest.mark.measured
def test_without_room_for_the_recording_the_train_runs_on_and_the_node_ends_with_status_1(
    start_node: StartNode, observer: Observer
) -> None:
    node = start_node(record_path="run.mcap", record_compression="none", file_size_limit=1_000_000)
    reports = observer.watch_typed(TABLE.diagnostics)
    couplers = Couplers(observer)
    observer.wait_until(
        lambda: any(s.name == "haul: recorder" and s.level == b"\x02" for report in reports for s in report.status),
        "the error of the recorder",
    )
    couplers.wait_for_time(couplers.time_ns + 10**9)
    assert node.end() == 1
    assert "Traceback" not in node.log
    assert "run.mcap: recording failed: File too large" in node.log.splitlines()[-1]


@pytest.mark.parametrize("signal_number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_while_the_node_starts_ends_it_with_status_0_and_no_unfinished_file(
    start_node: StartNode, observer: Observer, signal_number: int
) -> None:
    node = start_node(record_path="run.mcap")
    channel = TABLE.commands[CommandKind.BRAKE]["master"]
    observer.wait_until(lambda: observer.subscribers_of(channel) > 0, "the first of the node's topics")
    assert node.end(signal_number) == 0
    assert not list(node.folder.glob("*.active"))


def test_what_fails_after_the_start_is_not_hidden_by_the_signal_that_ended_the_node(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def run_node(_argv: object, signals: EndingSignals) -> int:
        signals.started(lambda: None)
        os.kill(os.getpid(), signal.SIGTERM)
        raise RuntimeError("broken")

    monkeypatch.setattr("haul_ros.ros.train_node.run_node", run_node)
    with pytest.raises(RuntimeError, match="broken"):
        main([])


INTERRUPTED = """
import os, signal, sys
import rclpy
from haul_ros.ros.node import main

real = rclpy.init

def init(**arguments):
    try:
        os.kill(os.getpid(), signal.{name})
    except KeyboardInterrupt:
        if {lost}:
            return real(**arguments)
        raise
    raise AssertionError("the signal did not interrupt")

rclpy.init = init
sys.exit(main(["--ros-args", "-p", "record_path:=none"]))
"""


@pytest.mark.slow
@pytest.mark.parametrize("lost", [False, True])
@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT"])
def test_a_signal_before_ros_runs_ends_the_node_even_if_its_interruption_is_lost(
    tmp_path: Path, name: str, lost: bool
) -> None:
    # Code called from C, of ROS or of an import, may let no exception out
    code = INTERRUPTED.format(name=name, lost=lost)
    ended = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=WAIT)
    assert (ended.returncode, "Traceback" in ended.stderr) == (0, False), ended.stderr


AT_AN_INSTANT = """
import os, re, signal, sys
from haul_ros.ros import node

instant, name = int(sys.argv[1]), sys.argv[2]
calls = 0

def count(_frame, _event, _argument):
    global calls
    calls += 1
    if calls == instant:
        sys.settrace(None)
        os.kill(os.getpid(), getattr(signal, name))

if not instant:
    from haul_ros.ros import loop
    simulate = loop.SimulationLoop._simulate

    def told(self):
        print(calls, flush=True)
        os.kill(os.getpid(), signal.SIGTERM)
        simulate(self)

    loop.SimulationLoop._simulate = told
sys.settrace(count)
sys.exit(node.main(["--ros-args", "-p", "record_path:=run.mcap"]))
"""
INSTANTS = int(os.environ.get("HAUL_INSTANTS", "4"))


@pytest.mark.slow
def test_at_whatever_instant_of_the_start_a_signal_comes_the_node_ends_with_status_0_and_no_word(
    tmp_path: Path,
) -> None:
    """The start is some hundred thousand calls of functions: the signal comes in the one of that number."""

    def run(instant: int, name: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", AT_AN_INSTANT, str(instant), name]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=WAIT)

    calls = int(run(0, "SIGTERM").stdout)
    assert calls > 10_000
    (tmp_path / "run.mcap").unlink()
    for n in range(INSTANTS):
        instant, name = int(calls * (n + 0.5) / INSTANTS), ("SIGTERM", "SIGINT", "SIGHUP")[n % 3]
        ended = run(instant, name)
        told = [line for line in ended.stderr.splitlines() if "[INFO]" not in line and "to rosout" not in line]
        assert (ended.returncode, told) == (0, []), f"{name} at call {instant} of {calls}"
        assert not list(tmp_path.glob("*.active"))
        (tmp_path / "run.mcap").unlink(missing_ok=True)


def test_the_end_of_a_recording_and_a_reset_are_logged_and_files_are_named_when_they_begin(
    start_node: StartNode, observer: Observer
) -> None:
    before = datetime.now(UTC).replace(microsecond=0)
    node = start_node(reset_interval=0.0)
    couplers = Couplers(observer)
    couplers.wait_for_time(10**9)
    named = int(time.time())
    observer.wait_until(lambda: int(time.time()) > named, "another second, which names the second recording")
    assert observer.pause().success
    assert observer.reset().success
    assert observer.step().message == "stepped at 0.020 s"
    assert node.end() == 0
    first, second = sorted(node.folder.iterdir(), key=lambda path: path.stat().st_mtime_ns)
    begun = [
        datetime.strptime(path.name, "daqin_1_2_1_%Y%m%dT%H%M%SZ.mcap").replace(tzinfo=UTC) for path in (first, second)
    ]
    assert before <= begun[0] < begun[1]
    for path in (first, second):
        with Recording(path) as recording:
            facts = recording.info()
        told = f"{path.name}: recording complete: {facts.messages} messages of {facts.end_ns / 1e9:.3f} s"
        assert told in node.log
    assert f"reset: daqin_1_2_1: 208 vehicles at 80.0 km/h, recording to {second.name}" in node.log
    assert node.log.count("reset: ") == 1
    assert "Traceback" not in node.log
    assert "to rosout" not in node.log


COMPILES = """
import os, time
from haul_ros.ros import train_node

class Compiled(train_node.Session):
    def __init__(self, *arguments, **more):
        if not hasattr(Compiled, "waited"):
            Compiled.waited = True
            while not os.path.exists("compiled"):
                time.sleep(0.01)
        super().__init__(*arguments, **more)

train_node.Session = Compiled
train_node.kernel_is_cached = lambda: False
"""


@pytest.mark.measured
def test_while_the_model_is_compiled_the_diagnostics_say_so(start_node: StartNode, observer: Observer) -> None:
    node = start_node(record_path="none", prelude=COMPILES)
    reports = observer.watch_typed(TABLE.diagnostics)
    observer.wait_until(lambda: len(reports) >= 2, "two reports of a model that is being compiled")
    (node.folder / "compiled").touch()
    observer.wait_until(lambda: any(len(report.status) > 1 for report in reports), "a report of the train")
    told = [report.status for report in reports if len(report.status) == 1]
    assert len(told) >= 2
    for (status,) in told:
        assert (status.level, status.name, status.hardware_id) == (b"\x00", "haul: pacing", "daqin_1_2_1")
        assert status.message.startswith("starting: compiling the model")
