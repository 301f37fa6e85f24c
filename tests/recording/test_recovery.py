"""Killed, cut off, damaged: what was flushed is recovered, and other people's readers open the result."""

from __future__ import annotations

import errno
import io
import os
import pickle
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import mcap.records
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Chunk, DataEnd, MessageIndex
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC, Writer
from rosbags.highlevel import AnyReader

from haul_ros import recording as recording_package
from haul_ros.errors import RecordingError
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.sample import Sample
from haul_ros.model.scenario import Scenario
from haul_ros.recording import recovery
from haul_ros.recording.reader import Recording
from haul_ros.recording.recovery import RECOVERING_SUFFIX, recover
from haul_ros.recording.run_file import RunFile, description_of
from haul_ros.recording.sequences import OutOfOrderError, Sequences
from haul_ros.recording.writer import FLUSH_INTERVAL, McapRecorder
from haul_ros.ros.run import TrainRun
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session

SAMPLES = 500


def open_run(path: Path, scenario: Scenario, encoder: TelemetryEncoder) -> RunFile:
    return RunFile(path, description_of(scenario, encoder.channels, "zstd"), scenario.document, encoder.channels)


@pytest.fixture
def put(encoder: TelemetryEncoder, make_sample: Callable[[int], Sample]) -> list[Message]:
    return [message for step in range(SAMPLES) for message in encoder.sample(make_sample(step))]


@pytest.fixture
def whole(
    small_chunks: None, tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, put: list[Message]
) -> Path:
    path = tmp_path / "whole.mcap"
    with McapRecorder(path, scenario, encoder.channels, when_full="block") as recorder:
        recorder.put(put, 5)
    return path


def content_of(path: Path) -> list[tuple[str, int, int, int, bytes]]:
    with path.open("rb") as stream:
        return [
            (channel.topic, m.log_time, m.publish_time, m.sequence, m.data)
            for _, channel, m in make_reader(stream, validate_crcs=True).iter_messages(log_time_order=False)
        ]


def test_a_whole_recording_is_copied_with_all_that_is_in_it(whole: Path, tmp_path: Path) -> None:
    result = recover(whole, tmp_path / "copy.mcap")
    assert (result.messages, result.missing, result.bytes_lost, result.damage) == (3 * SAMPLES, 0, 0, None)
    assert content_of(tmp_path / "copy.mcap") == content_of(whole)
    with Recording(whole) as first, Recording(tmp_path / "copy.mcap") as second:
        assert second.scenario_document == first.scenario_document
        assert second.info().topics == first.info().topics
        assert second.metadata == first.metadata
    assert sorted(p.name for p in tmp_path.iterdir()) == ["copy.mcap", "whole.mcap"]


def chunk_ends(path: Path) -> list[tuple[int, int]]:
    """Offset of the end of each chunk, and the number of messages up to there."""
    with path.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        ends, count = [], 0
        for chunk in summary.chunk_indexes:
            stream.seek(chunk.chunk_start_offset)
            record = next(iter(StreamReader(stream, skip_magic=True, emit_chunks=True).records))
            assert isinstance(record, Chunk)
            count += sum(isinstance(entry, mcap.records.Message) for entry in breakup_chunk(record))
            ends.append((chunk.chunk_start_offset + chunk.chunk_length, count))
    return ends


@pytest.mark.no_cover
def test_a_cut_off_recording_gives_every_whole_chunk(whole: Path, tmp_path: Path) -> None:
    content, original, cut = whole.read_bytes(), content_of(whole), tmp_path / "cut.mcap"
    ends = chunk_ends(whole)
    assert len(ends) > 1
    before = 0
    for end, count in ends:
        for length, expected in ((end - 1, before), (end, count), (end + 100, count)):
            cut.write_bytes(content[:length])
            result = recover(cut, tmp_path / f"{length}.mcap")
            assert content_of(tmp_path / f"{length}.mcap") == original[:expected]
            assert result.messages == expected
            assert result.damage is not None
        before = count


@pytest.fixture
def original(whole: Path) -> tuple[list[tuple[str, int, int, int, bytes]], list[tuple[int, int]]]:
    """Read once for all examples: what is in it, and where its chunks end."""
    return content_of(whole), chunk_ends(whole)


@pytest.mark.slow
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_after_a_flipped_bit_all_before_the_damage_is_recovered_or_one_line_says_why_not(
    whole: Path, original: tuple[list[tuple[str, int, int, int, bytes]], list[tuple[int, int]]], data: st.DataObject
) -> None:
    content, (written, ends) = bytearray(whole.read_bytes()), original
    near_chunk = st.sampled_from([end for end, _ in ends]).flatmap(lambda end: st.integers(end, end + 20))
    at = data.draw(st.integers(0, 5000) | near_chunk | st.integers(0, len(content) - 1))
    content[at] ^= 1 << data.draw(st.integers(0, 7))
    damaged, target = whole.with_name("damaged.mcap"), whole.with_name("target.mcap")
    damaged.write_bytes(content)
    target.unlink(missing_ok=True)
    try:
        recover(damaged, target)
    except RecordingError as err:
        assert str(damaged) in str(err)
        assert "\n" not in str(err)
        assert not target.exists()
        assert at < 5000
    else:
        found = content_of(target)
        assert found == written[: len(found)]
        assert len(found) >= max((count for end, count in ends if end <= at), default=0)
    assert not Path(f"{target}{RECOVERING_SUFFIX}").exists()


def test_nothing_is_overwritten(whole: Path, tmp_path: Path) -> None:
    (tmp_path / "taken.mcap").write_text("precious")
    with pytest.raises(RecordingError, match=r"taken\.mcap: exists already and is not overwritten"):
        recover(whole, tmp_path / "taken.mcap")
    with pytest.raises(RecordingError, match=r"whole\.mcap: exists already"):
        recover(whole, whole)
    assert (tmp_path / "taken.mcap").read_text() == "precious"


def test_messages_that_the_recorder_dropped_are_counted(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, monkeypatch: pytest.MonkeyPatch
) -> None:
    sequences = iter([0, 1, 5, 6])
    monkeypatch.setattr(McapRecorder, "_next_sequence", lambda *_: next(sequences))
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels) as recorder:
        for _ in range(4):
            recorder.put([encoder.real_time_factor(0, 1.0)], 0)
    result = recover(tmp_path / "run.mcap", tmp_path / "copy.mcap")
    assert (result.missing, result.unplaced) == (3, 0)


def test_what_the_recorder_says_it_dropped_at_the_end_is_missing_too(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder
) -> None:
    file = open_run(tmp_path / "run.mcap", scenario, encoder)
    file.add(encoder.real_time_factor(0, 1.0), 0, 0)
    file.finish(dropped=4)
    result = recover(tmp_path / "run.mcap", tmp_path / "copy.mcap")
    assert (result.missing, result.unplaced, result.gaps) == (4, 4, ())
    with Recording(tmp_path / "copy.mcap") as recording:
        assert (recording.info().dropped, recording.info().lost) == (4, 0)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"name: daqin_1_2_1\n", "not an MCAP file, expected a recording of haul_ros"),
        (b"\x89MCAP0\r\n", "nothing to recover: damaged before its first message: the file ends too early"),
        (b"\x89MCAP0\r\n" + bytes(100), "nothing to recover: damaged before its first message: no record of MCAP"),
    ],
)
def test_a_file_of_another_kind_is_reported(tmp_path: Path, content: bytes, message: str) -> None:
    (tmp_path / "run.mcap").write_bytes(content)
    with pytest.raises(RecordingError, match=rf"run\.mcap: {message}"):
        recover(tmp_path / "run.mcap", tmp_path / "new.mcap")
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap"]


def test_a_scenario_that_was_changed_is_noticed(whole: Path, tmp_path: Path, scenario: Scenario) -> None:
    content = bytearray(whole.read_bytes())
    content[content.index(scenario.document.encode())] ^= 1
    (tmp_path / "damaged.mcap").write_bytes(content)
    with pytest.raises(RecordingError, match=r"damaged before its first message: .*Attachment with another length"):
        recover(tmp_path / "damaged.mcap", tmp_path / "new.mcap")


def records_of(path: Path) -> list[tuple[type, int]]:
    """Kind and start of every record before the end of the data."""
    found, start = [], len(MCAP0_MAGIC)
    with path.open("rb") as stream:
        stream.seek(start)
        for record in StreamReader(stream, skip_magic=True, emit_chunks=True).records:
            found.append((type(record), start))
            start = stream.tell()
            if isinstance(record, DataEnd):
                break
    return found


@pytest.mark.parametrize(
    ("kind", "offset", "new", "damage"),
    [
        (Chunk, 0, b"\x46", "no record of MCAP begins with 70"),
        (Chunk, 0, b"\x02", "damaged record: .*Footer with another length"),
        (Chunk, 1, b"\xff" * 8, "damaged record: .*CHUNK record has length .* exceeds limit 200000"),
        (MessageIndex, 0, b"\x0b", "damaged record: .*Statistics with another length"),
        (MessageIndex, 11, b"\xff" * 4, "damaged record: longer than 200000 bytes"),
        (DataEnd, 1, b"\x05", "damaged record: .*DataEnd with another length"),
    ],
)
def test_damage_at_the_edge_of_a_record_costs_no_good_record_and_little_memory(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: type, offset: int, new: bytes, damage: str
) -> None:
    """Bytes are replaced in the last record of a kind, in a file many times longer than a record."""
    monkeypatch.setattr(recovery, "LONGEST_RECORD", 200_000)
    start = [at for found, at in records_of(whole) if found is kind][-1]
    content = bytearray(whole.read_bytes() + random.Random(1).randbytes(20_000_000))
    content[start + offset : start + offset + len(new)] = new
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(content)
    tracemalloc.start()
    result = recover(damaged, tmp_path / "new.mcap")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert result.bytes_lost == len(content) - start
    assert re.match(damage, result.damage or "")
    before = max((count for end, count in chunk_ends(whole) if end <= start), default=0)
    assert content_of(tmp_path / "new.mcap") == content_of(whole)[:before]
    assert peak < 5_000_000


@pytest.mark.parametrize(
    ("profile", "message"), [("ros1", "MCAP profile 'ros1'"), ("ros2", "no recording of haul_ros")]
)
def test_an_mcap_file_of_somebody_else_is_reported(tmp_path: Path, profile: str, message: str) -> None:
    with (tmp_path / "run.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile=profile)
        writer.finish()
    with pytest.raises(RecordingError, match=message):
        recover(tmp_path / "run.mcap", tmp_path / "new.mcap")


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"run\.mcap: cannot be recovered: No such file or directory"):
        recover(tmp_path / "run.mcap", tmp_path / "new.mcap")


@contextmanager
def small_disk(folder: Path) -> Iterator[Path]:
    """A folder on a full disk of 300 kB: a file system of its own where that is allowed, else a limit for files."""
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", folder], capture_output=True
    ).returncode
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    if mounted != 0:
        resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, hard))
    try:
        yield folder
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        if mounted == 0:
            subprocess.run(["umount", folder], check=True)


@pytest.mark.usefixtures("small_chunks")
def test_on_a_full_disk_simulation_and_topics_go_on_and_the_file_is_recovered(tmp_path: Path) -> None:
    scenario = load_scenario("daqin_1_2_1")
    encoder = TelemetryEncoder(scenario.consist)
    published: list[Message] = []
    with small_disk(tmp_path / "disk") as folder:
        recorder = McapRecorder(folder / "run.mcap", scenario, encoder.channels, when_full="block")
        run = TrainRun(Session(scenario), encoder, published.extend, recorder)
        run.start()
        run.request(Command("master", CommandKind.EMERGENCY, 1.0))
        for _ in range(400):
            run.advance()
        with pytest.raises(RecordingError) as caught:
            run.close()
        assert re.fullmatch(
            r".*/run\.mcap: recording failed: (No space left on device|File too large); what was written is in "
            r".*/run\.mcap\.active, to recover it: haul recover .*/run\.mcap\.active -o .*/run\.mcap",
            str(caught.value),
        )
        shutil.copy(folder / "run.mcap.active", tmp_path)
    couplers = [message for message in published if message.channel == encoder.channels.couplers]
    assert [message.time_ns for message in couplers] == [n * 20_000_000 for n in range(401)]
    result = recover(tmp_path / "run.mcap.active", tmp_path / "run.mcap")
    assert result.damage is not None
    with Recording(tmp_path / "run.mcap") as recording:
        recovered = [m.data for m in recording.state_messages() if m.channel == encoder.channels.couplers]
    assert len(recovered) > 10
    assert recovered == [message.data for message in couplers[: len(recovered)]]


def test_a_folder_that_becomes_read_only_while_recording_is_reported_and_the_file_is_recovered(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    recorder = McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels)
    recorder.put([encoder.real_time_factor(0, 1.5)], 0)
    with monkeypatch.context() as patch:
        for name in ("link", "replace"):
            patch.setattr(os, name, refuse)
        patch.setattr(Path, "open", refuse)
        with pytest.raises(RecordingError, match=r"recording failed: Read-only file system; what was written is in .*"):
            recorder.close()
    assert recover(tmp_path / "run.mcap.active", tmp_path / "run.mcap").messages == 1


RECORD_UNTIL_KILLED = """
import os, pickle, sys, time
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.recording.run_file import RunFile
from haul_ros.recording.writer import McapRecorder

scenario, messages, path = pickle.load(sys.stdin.buffer)
flushed = os.open(f"{path}.flushed", os.O_CREAT | os.O_WRONLY)
add, flush = RunFile.add, RunFile.flush

def add_and_note(file, message, sequence, number):
    add(file, message, sequence, number)
    file.newest = number

def flush_and_tell(file):
    flush(file)
    os.pwrite(flushed, b"%d" % file.newest, 0)

RunFile.add, RunFile.flush = add_and_note, flush_and_tell
recorder = McapRecorder(path, scenario, TelemetryEncoder(scenario.consist).channels)
number = 0
while True:
    now = time.monotonic_ns()
    recorder.put([Message(m.channel, now, m.data) for m in messages], number)
    number += 1
    print(number, flush=True) if number == 1 else None
    time.sleep(0.002)
"""


@pytest.mark.slow
def test_whatever_the_moment_of_a_kill_all_that_was_flushed_is_recovered_and_that_is_what_is_older_than_a_second(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, make_sample: Callable[[int], Sample]
) -> None:
    """Five processes at a time write 500 samples a second; HAUL_KILLS is how many are killed in all."""
    kills, moments = int(os.environ.get("HAUL_KILLS", "5")), random.Random(4)
    environment = {**os.environ, "PYTHONPATH": str(Path(recording_package.__file__).parents[2])}
    environment.pop("COVERAGE_PROCESS_CONFIG", None)  # who is killed cannot say what lines were run, but is slowed
    messages = encoder.sample(make_sample(1))
    for start in range(0, kills, 5):
        children = []
        late_ns = []
        for number in range(start, min(start + 5, kills)):
            path = tmp_path / f"{number}.mcap"
            child = subprocess.Popen(
                [sys.executable, "-c", RECORD_UNTIL_KILLED],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=environment,
            )
            assert child.stdin is not None
            pickle.dump((scenario, messages, path), child.stdin)
            child.stdin.close()
            children.append((child, path))
        for child, _ in children:
            assert child.stdout is not None
            assert child.stdout.readline() == b"1\n"
        begun_ns = time.monotonic_ns()
        until = [time.monotonic() + 0.1 + 0.58 * (n + moments.random()) for n in range(len(children))]
        for (child, path), moment in zip(children, until, strict=True):
            time.sleep(max(0.0, moment - time.monotonic()))
            killed_ns = time.monotonic_ns()
            child.kill()
            assert child.wait() == -signal.SIGKILL
            assert child.stdout is not None
            child.stdout.close()
            recover(path.with_name(f"{path.name}.active"), path)
            with Recording(path) as recording:
                times = [message.log_time for message in _raw(path)]
                assert recording.info().messages == len(times)
            numbers = [m.publish_time for m in _raw(path)]
            assert numbers == [n for n in range(len(numbers) // 3) for _ in range(3)]
            flushed = (tmp_path / f"{path.name}.flushed").read_bytes()
            assert not flushed or numbers[-1] >= int(flushed)
            if killed_ns - begun_ns > FLUSH_INTERVAL * 1e9:
                late_ns.append(killed_ns - times[-1])
            with AnyReader([path]) as reader:
                assert reader.message_count == len(times)
        # A machine with other work lets some wait; what is flushed too rarely is so in all
        assert min(late_ns, default=0) < (FLUSH_INTERVAL + 0.25) * 1e9
    assert kills == len(list(tmp_path.glob("*.mcap")))


def _raw(path: Path) -> list[mcap.records.Message]:
    with path.open("rb") as stream:
        return [message for _, _, message in make_reader(stream, validate_crcs=True).iter_messages()]


def chunks_of(path: Path) -> tuple[bytes, list[bytes], bytes]:
    """What stands before the first chunk with messages, every such chunk with its indexes, and the rest."""
    data = path.read_bytes()
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    edges = [
        (index.chunk_start_offset, index.chunk_start_offset + index.chunk_length + index.message_index_length)
        for index in summary.chunk_indexes
        if index.message_index_offsets
    ]
    return data[: edges[0][0]], [data[begin:end] for begin, end in edges], data[edges[-1][1] :]


@pytest.mark.no_cover
@pytest.mark.parametrize(
    ("order", "missing", "repeated"),
    [((0, 1, 1, 2, 3), (), (1,)), ((0, 0, 0, 1, 2, 3), (), (0, 0)), ((0, 2, 3), (1,), ()), ((0, 2, 2, 3), (1,), (2,)),
     ((0, 3), (1, 2), ()), ((0, 1, 2, 3, 1), (), (1,)), ((0, 2, 1, 3), (), ()), ((0, 3, 2, 1), (), ()),
     ((0, 3, 1), (2,), ()), ((0, 3, 1, 3, 1), (2,), (1, 3)), ((0, 1, 2), (3,), ()), ((0, 2), (1, 3), ())],
)  # fmt: skip
def test_chunks_that_are_there_twice_or_not_at_all_are_counted_right(
    whole: Path, tmp_path: Path, order: tuple[int, ...], missing: tuple[int, ...], repeated: tuple[int, ...]
) -> None:
    head, chunks, tail = chunks_of(whole)
    chunks = [*chunks[:3], b"".join(chunks[3:])]
    sizes = [len(content_of_part(head + chunk)) for chunk in chunks]
    assert sum(sizes) == 3 * SAMPLES
    other, copy = tmp_path / "other.mcap", tmp_path / "copy.mcap"
    other.write_bytes(head + b"".join(chunks[n] for n in order) + tail)
    result = recover(other, copy)
    assert result.messages == sum(sizes[n] for n in set(order))
    assert result.missing == sum(sizes[n] for n in missing)
    assert result.repeated == sum(sizes[n] for n in repeated)
    assert result.unplaced == sum(sizes[n] for n in missing if n > max(order))
    inner = [n for n in missing if n < max(order)]
    assert len(result.gaps) == len(inner[:1])
    times = [sorted({m.log_time for m in content_of_part(head + chunk)}) for chunk in chunks]
    for begin, end in result.gaps:
        assert times[inner[0] - 1][-2] <= begin <= times[inner[0]][1]
        assert times[inner[-1]][-2] <= end <= times[inner[-1] + 1][1]
    recovered = content_of(copy)
    assert len(recovered) == len(set(recovered)) == result.messages
    with Recording(copy) as recording:
        assert len(recording.couplers().time_ns) == sum(topic.endswith("/couplers") for topic, *_ in recovered)
        facts = recording.info()
    assert (facts.written, facts.dropped, facts.lost) == (3 * SAMPLES, 0, result.missing)
    assert facts.complete == (not missing)


def content_of_part(data: bytes) -> list[mcap.records.Message]:
    """Message records of a file without an end."""
    records = StreamReader(io.BytesIO(data), emit_chunks=True).records
    found: list[mcap.records.Message] = []
    with suppress(EndOfFile):
        for record in records:
            if isinstance(record, Chunk):
                found += [inner for inner in breakup_chunk(record) if isinstance(inner, mcap.records.Message)]
    return found


def message_of(number: int, time_ns: int) -> mcap.records.Message:
    return mcap.records.Message(channel_id=1, log_time=time_ns, publish_time=0, sequence=number, data=b"")


def test_a_gap_is_what_all_topics_leave_open() -> None:
    """Samples at 0, 1, 2 ... miss 3 and 4; extremes at 0, 10 miss one; a command between is the last of its topic."""
    sequences = Sequences()
    for time_ns in (0, 1, 2, 5, 6, 7, 8, 9):
        assert sequences.take("samples", message_of(time_ns, time_ns))
        if time_ns == 0:
            assert sequences.take("extremes", message_of(0, 0))
    assert sequences.take("extremes", message_of(2, 10))
    assert (sequences.missing, sequences.gaps) == (3, [(2, 5)])


def test_a_number_that_fills_a_gap_is_no_repetition() -> None:
    sequences = Sequences()
    assert sequences.take("samples", message_of(5, 50))
    with pytest.raises(OutOfOrderError):
        sequences.take("samples", message_of(2, 20))
    late = Sequences(late=True)
    taken = [late.take("samples", message_of(number, 10 * number)) for number in (5, 2, 2, 0, 4, 3, 1, 1, 5)]
    assert taken == [True, True, False, True, True, True, True, False, False]
    assert (late.missing, late.repeated) == (0, 3)


def test_a_recording_without_its_first_chunk_says_that_its_topics_are_unknown(whole: Path, tmp_path: Path) -> None:
    head, chunks, tail = chunks_of(whole)
    (tmp_path / "headless.mcap").write_bytes(head + b"".join(chunks[1:]) + tail)
    result = recover(tmp_path / "headless.mcap", tmp_path / "new.mcap")
    assert result.messages == 0
    assert re.search("damaged chunk: .*messages of channel 1, which is described nowhere before", result.damage or "")


@pytest.mark.parametrize("number", ["-1", "x", "9" * 30, "\u0663"])
def test_a_count_of_messages_that_is_no_number_is_damage(
    tmp_path: Path, scenario: Scenario, encoder: TelemetryEncoder, number: str
) -> None:
    file = open_run(tmp_path / "run.mcap", scenario, encoder)
    file.finish(dropped=number)  # type: ignore[arg-type]
    assert "messages_dropped is" in (recover(tmp_path / "run.mcap", tmp_path / "new.mcap").damage or "")
    with Recording(tmp_path / "run.mcap") as recording, pytest.raises(RecordingError, match="messages_dropped is"):
        recording.info()
