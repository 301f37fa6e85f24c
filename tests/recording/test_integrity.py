"""Damage anywhere is noticed by every reader, and forged sizes cost no memory."""

from __future__ import annotations

import itertools
import random
import resource
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from haul_ros.errors import RecordingError
from haul_ros.model.scenario import Scenario
from haul_ros.recording.reader import Recording
from haul_ros.recording.recovery import recover, survey
from tests.recorded import content, forge, sign_summary, summary_section
from tests.waiting import WAIT

pytestmark = pytest.mark.no_cover

MEMORY = 1_500_000_000
"""Bytes of address space for a reader: it takes some 600 MB of it for its libraries."""


def test_a_flipped_bit_anywhere_is_noticed_or_changes_nothing(run: Path, tmp_path: Path) -> None:
    data, damaged = run.read_bytes(), tmp_path / "damaged.mcap"
    whole = content(run)
    with run.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    (chunk,) = summary.chunk_indexes
    inside = range(chunk.chunk_start_offset + 60, chunk.chunk_start_offset + chunk.chunk_length)
    # all that is not compressed, and some of what is
    places = [place for place in range(len(data)) if place not in inside or place % 97 == 0]
    draw = random.Random(1)
    unnoticed = []
    for place in draw.sample(places, 700) + list(range(len(data) - 600, len(data))):
        changed = bytearray(data)
        changed[place] ^= 1 << draw.randrange(8)
        damaged.write_bytes(changed)
        try:
            found = content(damaged)
        except RecordingError as error:
            assert "\n" not in str(error)
        else:
            if found != whole:
                unnoticed.append(place)
    assert unnoticed == []


def test_a_command_that_is_hidden_in_the_summary_is_noticed(run: Path, tmp_path: Path) -> None:
    data = bytearray(run.read_bytes())
    place = data.rindex(b"/haul/master/brake_command")
    data[place + 6] ^= 1
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data)
    with pytest.raises(RecordingError, match="summary section: checksum does not fit"):
        Recording(damaged)
    found = survey(damaged)
    assert found.counts["/haul/couplers"] == 20
    assert found.counts["/haul/master/brake_command"] == 1
    recover(damaged, tmp_path / "whole.mcap")
    with Recording(tmp_path / "whole.mcap") as recording:
        assert len(recording.commands()) == 1


def test_a_changed_scenario_is_noticed(run: Path, tmp_path: Path, scenario: Scenario) -> None:
    data = run.read_bytes()
    damaged = tmp_path / "damaged.mcap"
    text = scenario.document.encode()
    assert data.count(text) == 1
    damaged.write_bytes(data.replace(text, text.swapcase()))
    with Recording(damaged) as recording, pytest.raises(RecordingError, match=r"scenario\.yaml: checksum does not fit"):
        assert recording.scenario_document


def test_a_changed_description_is_noticed(run: Path, tmp_path: Path) -> None:
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(
        run.read_bytes().replace(b"messages_dropped\x01\x00\x00\x000", b"messages_dropped\x01\x00\x00\x001")
    )
    with pytest.raises(RecordingError, match="description of the run: checksum does not fit"):
        Recording(damaged)


@pytest.mark.parametrize(
    ("before", "after"), [(b"\x08\x00\x00\x00haul_ros", b"\x08\x00\x00\x00haul_rot"), (b"crc32", b"crc33")]
)
def test_a_description_at_the_end_that_hides_is_noticed(run: Path, tmp_path: Path, before: bytes, after: bytes) -> None:
    data = run.read_bytes()
    with run.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    last = [index for index in summary.metadata_indexes if index.name == "haul_ros"][-1]
    place = data.index(before, last.offset)
    assert place < last.offset + last.length
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data[:place] + after + data[place + len(before) :])
    with pytest.raises(RecordingError, match=r"is called haul_rot|a checksum is missing"):
        Recording(damaged)


def test_the_checksum_of_the_data_section_is_compared_where_there_is_one(run: Path, tmp_path: Path) -> None:
    """It alone covers the header and the indexes of messages."""
    signed, damaged = tmp_path / "signed.mcap", tmp_path / "damaged.mcap"
    forge(run, signed, data_checksum=True)
    forge(run, tmp_path / "unsigned.mcap")
    assert content(signed)[:1] + content(signed)[2:] == content(tmp_path / "unsigned.mcap")[:1] + content(signed)[2:]
    whole = recover(signed, tmp_path / "whole.mcap")
    assert whole.damage is None
    data = signed.read_bytes()
    start, _ = summary_section(data)
    for place in (data.index(b"somebody else"), start - 1):
        changed = bytearray(data)
        changed[place] ^= 1
        damaged.write_bytes(changed)
        with pytest.raises(RecordingError, match="data section: checksum does not fit"):
            Recording(damaged)
        (tmp_path / "recovered.mcap").unlink(missing_ok=True)
        result = recover(damaged, tmp_path / "recovered.mcap")
        assert (result.damage, result.bytes_lost) == ("data section: checksum does not fit", 0)
        assert result.messages == whole.messages
        assert survey(damaged).damage == result.damage


def test_chunks_are_checked_until_it_is_enough(run: Path, tmp_path: Path) -> None:
    forge(run, tmp_path / "many.mcap", chunk_size=1000)
    with Recording(tmp_path / "many.mcap") as recording:
        count, all_of_them = recording.check_chunks()
        assert count == all_of_them > 3
        asked = iter([False, False, True])
        assert recording.check_chunks(lambda: next(asked)) == (2, all_of_them)
    data = bytearray((tmp_path / "many.mcap").read_bytes())
    data[len(data) // 2] ^= 1
    (tmp_path / "damaged.mcap").write_bytes(data)
    with Recording(tmp_path / "damaged.mcap") as recording, pytest.raises(RecordingError, match="damaged recording"):
        recording.check_chunks()


def expanding(path: Path, source: Path, compression: CompressionType, size: int) -> None:
    """A file with the beginning of a recording and a chunk that becomes so large."""
    with source.open("rb") as stream, path.open("wb") as target:
        reader = make_reader(stream)
        writer = Writer(target, chunk_size=2 * size, compression=compression)
        writer.start("ros2", "another")
        for record in reader.iter_metadata():
            writer.add_metadata(record.name, record.metadata)
        for found in reader.iter_attachments():
            writer.add_attachment(found.create_time, found.log_time, found.name, found.media_type, found.data)
        schema = writer.register_schema("std_msgs/msg/Bool", "ros2msg", b"bool data")
        channel = writer.register_channel("/haul/master/emergency_brake", "cdr", schema)
        writer.add_message(channel, 0, bytes(size), 0)
        writer.finish()


READ = """
import resource, sys
from pathlib import Path
resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
from haul_ros.cli.main import main
sys.exit(main(sys.argv[1:]))
""".replace("MEMORY", str(MEMORY))


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
@pytest.mark.parametrize("command", [("info",), ("replay",), ("analyze",), ("recover", "-o", "new.mcap")])
def test_a_small_file_that_expands_to_a_gigabyte_is_refused_in_bounded_memory(
    run: Path, tmp_path: Path, compression: CompressionType, command: tuple[str, ...]
) -> None:
    bomb = tmp_path / "bomb.mcap"
    expanding(bomb, run, compression, 400_000_000)
    assert bomb.stat().st_size < 4_000_000
    done = subprocess.run(
        [sys.executable, "-c", READ, command[0], str(bomb), *command[1:]],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=WAIT,
    )
    assert "Traceback" not in done.stderr
    if command[0] == "recover":
        assert (done.returncode, done.stderr) == (0, "")
        assert "damaged chunk: ValueError: chunk of 4000" in done.stdout
    else:
        assert done.returncode == 2
        assert done.stderr.count("\n") == 1
        assert "expected at most 67108864" in done.stderr


def test_a_forged_summary_raises_nothing_but_a_recording_error_and_takes_no_memory(run: Path, tmp_path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    draw = random.Random(2)
    values = [0, 1, 2**31, 2**40, 2**62, 2**63, 2**64 - 1]
    resource.setrlimit(resource.RLIMIT_AS, (8_000_000_000, hard))
    try:
        for _, value in itertools.product(range(70), values):
            data = bytearray(run.read_bytes())
            begin, footer = summary_section(data)
            struct.pack_into("<Q", data, draw.randrange(begin, footer - 8), value)
            sign_summary(data)
            path = tmp_path / "forged.mcap"
            path.write_bytes(data)
            try:
                content(path)
            except RecordingError as error:
                assert "\n" not in str(error)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
