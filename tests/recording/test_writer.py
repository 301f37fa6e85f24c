from __future__ import annotations

import os
import pickle
import signal
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal

import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Attachment, McapRecord, Metadata
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader

from haul_ros import recording as recording_package
from haul_ros.errors import RecordingError
from haul_ros.messages.channels import channel_table
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.sample import Sample
from haul_ros.model.scenario import Scenario
from haul_ros.recording.reader import Recording
from haul_ros.recording.run_file import RunFile
from haul_ros.recording.writer import McapRecorder, RecorderStatus
from tests.waiting import WAIT, wait_until

MakeSample = Callable[[int], Sample]


class Gate:
    """Holds the writing thread at its first message until opened."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.reached = threading.Event()
        self.open = threading.Event()
        add = RunFile.add

        def gated(file: RunFile, message: Message, sequence: int, publish_time_ns: int) -> None:
            self.reached.set()
            assert self.open.wait(WAIT)
            add(file, message, sequence, publish_time_ns)

        monkeypatch.setattr(RunFile, "add", gated)


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch) -> Iterator[Gate]:
    gate = Gate(monkeypatch)
    yield gate
    gate.open.set()


def messages_of(path: Path) -> list[tuple[str, McapMessage]]:
    with path.open("rb") as stream:
        return [(channel.topic, message) for _, channel, message in make_reader(stream).iter_messages()]


def test_what_is_put_is_in_the_file_byte_for_byte(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, make_sample: MakeSample
) -> None:
    put = [(encoder.sample(make_sample(step)), 1_700_000_000_000_000_000 + step) for step in range(50)]
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels, when_full="block") as recorder:
        for messages, wall_ns in put:
            recorder.put(messages, wall_ns)
    read = [(topic, m.log_time, m.publish_time, m.sequence, m.data) for topic, m in messages_of(recorder.path)]
    assert read == [
        (message.channel.topic, message.time_ns, wall_ns, sequence, message.data)
        for sequence, (messages, wall_ns) in enumerate(put)
        for message in messages
    ]
    assert recorder.status == RecorderStatus(150, 0, recorder.path.stat().st_size, None)


def test_an_exception_in_the_block_keeps_the_data(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, make_sample: MakeSample
) -> None:
    with (
        pytest.raises(ZeroDivisionError),
        McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder,
    ):
        recorder.put(encoder.sample(make_sample(3)), 1)
        raise ZeroDivisionError
    assert len(messages_of(tmp_path / "run.mcap")) == 3
    assert not recorder.status.failure


def test_a_full_queue_drops_and_counts(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, make_sample: MakeSample, gate: Gate
) -> None:
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels, queue_limit=4) as recorder:
        recorder.put(encoder.sample(make_sample(0)), 0)
        assert gate.reached.wait(WAIT)  # the thread holds the first, so the queue takes four more
        for step in range(1, 7):
            recorder.put(encoder.sample(make_sample(step)), step)
        assert recorder.status.dropped == 6
        gate.open.set()
        wait_until(lambda: recorder.status.written == 15, "what is queued to be written")
        recorder.put(encoder.sample(make_sample(7)), 7)
    assert (recorder.status.written, recorder.status.dropped) == (18, 6)
    sequences = [m.sequence for topic, m in messages_of(recorder.path) if topic == "/haul/couplers"]
    assert sequences == [0, 1, 2, 3, 4, 7]  # the gap shows where two samples are missing
    with Recording(recorder.path) as recording:
        assert (recording.info().dropped, recording.info().complete) == (6, False)


def test_a_blocking_recorder_waits_and_loses_nothing(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, make_sample: MakeSample, gate: Gate
) -> None:
    samples = [encoder.sample(make_sample(step)) for step in range(10)]

    def run() -> None:
        with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels, when_full="block", queue_limit=1) as rec:
            for messages in samples:
                rec.put(messages, 0)

    caller = threading.Thread(target=run)
    caller.start()
    assert gate.reached.wait(WAIT)
    assert caller.is_alive()
    gate.open.set()
    caller.join(WAIT)
    assert not caller.is_alive()
    assert len(messages_of(tmp_path / "run.mcap")) == 30


@pytest.mark.usefixtures("limited_file_size")
@pytest.mark.parametrize("when_full", ["drop", "block"])
def test_a_full_disk_is_reported_when_closing_and_does_not_disturb_before(
    tmp_path: Path,
    scenario: Scenario,
    encoder: TelemetryEncoder,
    when_full: Literal["drop", "block"],
) -> None:
    channel = encoder.channels.real_time_factor
    recorder = McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels, when_full=when_full, queue_limit=100)
    for _ in range(20):
        recorder.put([Message(channel, 0, os.urandom(20_000))], 0)
    wait_until(lambda: recorder.status.failure is not None, "the failure")
    for _ in range(200):  # more than the queue holds: it must be emptied all the same
        recorder.put([encoder.real_time_factor(0, 1.0)], 0)
    with pytest.raises(RecordingError, match=r"run\.mcap: recording failed: File too large; .* is in .*\.active"):
        recorder.close()
    assert recorder.status.written == 0
    assert recorder.status.dropped == 220
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap.active"]


@pytest.mark.usefixtures("limited_file_size")
def test_a_failed_recording_does_not_hide_the_error_of_the_block(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    message = Message(encoder.channels.real_time_factor, 0, os.urandom(200_000))
    with (
        pytest.raises(ZeroDivisionError) as caught,
        McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder,
    ):
        recorder.put([message], 0)
        raise ZeroDivisionError
    assert "File too large" in caught.value.__notes__[0]


def test_a_message_of_another_train_is_refused_at_once(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    other = channel_table(["master", "slave_1", "slave_2"])
    recorder = McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels)
    with pytest.raises(ValueError, match="/haul/slave_2/applied_brake: not a channel of this recording"):
        recorder.put([Message(other.applied_brake["slave_2"], 0, b"")], 0)
    recorder.close()
    assert recorder.status.written == 0


def test_a_closed_recorder_takes_nothing_and_closes_again(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    recorder = McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels)
    recorder.close()
    recorder.close()
    with pytest.raises(ValueError, match="recording is closed"):
        recorder.put([encoder.real_time_factor(0, 1.0)], 0)


WRITE_UNTIL_KILLED = """
import os, pickle, sys, time
from haul_ros.recording import writer
from haul_ros.messages.encoder import TelemetryEncoder

scenario, messages = pickle.load(sys.stdin.buffer)
writer.FLUSH_INTERVAL = 0.01
recorder = writer.McapRecorder(sys.argv[1], scenario, TelemetryEncoder(scenario.consist).channels)
begun = os.path.getsize(sys.argv[1] + ".active")
recorder.put(messages, 0)  # less than a chunk: the file grows by flushing alone, and then by all of it
while os.path.getsize(sys.argv[1] + ".active") == begun:
    time.sleep(0.001)
print("flushed", flush=True)
time.sleep(60.0)
"""


def records_until_cut_off(path: Path) -> list[McapRecord]:
    records = []
    with path.open("rb") as stream, pytest.raises((McapError, struct.error)):
        for record in StreamReader(stream).records:
            records.append(record)
    return records


def test_a_killed_process_loses_nothing_older_than_the_last_flush(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, make_sample: MakeSample
) -> None:
    path = tmp_path / "run.mcap"
    messages = [message for step in range(20) for message in encoder.sample(make_sample(step))]
    environment = {**os.environ, "PYTHONPATH": str(Path(recording_package.__file__).parents[2])}
    child = subprocess.Popen(
        [sys.executable, "-c", WRITE_UNTIL_KILLED, path],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
    )
    assert child.stdin is not None
    assert child.stdout is not None
    with child:
        pickle.dump((scenario, messages), child.stdin)
        child.stdin.close()
        assert child.stdout.readline() == b"flushed\n"
        child.kill()
    assert child.returncode == -signal.SIGKILL
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap.active"]
    records = records_until_cut_off(tmp_path / "run.mcap.active")
    assert [r.data for r in records if isinstance(r, McapMessage)] == [message.data for message in messages]
    assert [r.name for r in records if isinstance(r, Metadata)] == ["rosbag2", "haul_ros"]
    assert [r.data.decode() for r in records if isinstance(r, Attachment)] == [scenario.document]
    with pytest.raises(RecordingError, match=r"run\.mcap\.active: unfinished: its recorder still writes or was killed"):
        Recording(tmp_path / "run.mcap.active")
    with pytest.raises(RecordingError, match=r"no such file; an unfinished recording run\.mcap\.active lies there"):
        Recording(path)
