"""Attacks by damaged and forged recordings."""

from __future__ import annotations

import hashlib
import os
import random
import struct
import tempfile
import zlib
from functools import cache
from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import MCAP0_MAGIC

from haul_ros.errors import RecordingError
from haul_ros.recording.reader import Recording
from tests.attack import nasty
from tests.attack.harness import Found, Outcome, haul

_FOOTER = 29


@cache
def _whole() -> tuple[bytes, str]:
    """A recording of a short run, and a digest of all that is in it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        haul("run", "daqin_1_1_0", "--set", "max_duration_s=0.5", "--set", "sample_rate_hz=10", "-o", str(path))
        return path.read_bytes(), _content(path)


def _content(path: Path) -> str:
    """Digest of everything that a reader gives of a recording."""
    digest = hashlib.sha256()
    with Recording(path) as recording:
        info = recording.info()
        facts = (info.topics, info.messages, info.start_ns, info.end_ns, info.dropped, info.written)
        events = recording.events()
        digest.update(repr((recording.scenario_document, recording.metadata, facts, events)).encode())
        digest.update(repr(recording.requests()).encode())
        for message in recording.state_messages():
            digest.update(message.channel.topic.encode() + str(message.time_ns).encode() + message.data)
        samples = recording.samples()
        digest.update(samples.couplers.force.tobytes() + samples.pressure.pressure.tobytes())
        digest.update(repr(samples.couplers.time_ns.tolist()).encode())
        for extremes in recording.extremes():
            digest.update(extremes.extremes.tension.tobytes())
    return digest.hexdigest()


def damaged(rng: random.Random, folder: Path) -> Outcome:
    """Changed bytes: either noticed, or nothing that is read is another."""
    data, whole = _whole()
    path = folder / "damaged.mcap"
    path.write_bytes(nasty.change_bytes(rng, data))
    try:
        found = _content(path)
    except RecordingError as error:
        if "\n" in str(error):
            raise Found(f"refused in more than one line: {error}") from error
        outcome = Outcome.REFUSED
    else:
        if found != whole:
            raise Found("a damaged recording is read as another one")
        outcome = Outcome.RAN
    if rng.random() < 0.1:
        _commands(rng, path, folder)
    return outcome


def _commands(rng: random.Random, path: Path, folder: Path) -> None:
    match rng.randrange(4):
        case 0:
            haul("info", str(path), *rng.choice(((), ("--json",))))
        case 1:
            haul("replay", str(path), statuses=(0, 1))
        case 2:
            haul("recover", str(path), "-o", str(folder / "recovered.mcap"))
            if (folder / "recovered.mcap").exists():
                _content(folder / "recovered.mcap")
        case _:
            haul("analyze", str(path), "-o", str(folder / "analysis"))


def forged(rng: random.Random, folder: Path) -> Outcome:
    """Changed numbers with right checksums, in the summary section, the scenario or the description of the run."""
    data = bytearray(_whole()[0])
    footer = len(data) - len(MCAP0_MAGIC) - _FOOTER
    (start,) = struct.unpack_from("<Q", data, footer + 9)
    if rng.random() < 0.3:
        _forge_scenario(rng, data)
    else:
        for _ in range(rng.choice((1, 1, 2, 5))):
            form, most = rng.choice((("<Q", 2**64 - 1), ("<I", 2**32 - 1), ("<H", 2**16 - 1), ("<B", 255)))
            number = rng.choice((0, 1, most, most // 2, most // 2 + 1, rng.randint(0, most)))
            struct.pack_into(form, data, rng.randrange(start, footer - 8), number)
    struct.pack_into("<I", data, footer + 25, zlib.crc32(data[start : footer + 25]))
    path = folder / "forged.mcap"
    path.write_bytes(data)
    try:
        _content(path)
    except RecordingError as error:
        if "\n" in str(error):
            raise Found(f"refused in more than one line: {error}") from error
    if rng.random() < 0.3:
        _commands(rng, path, folder)
    return Outcome.RAN


def _forge_scenario(rng: random.Random, data: bytearray) -> None:
    """Other bytes of the same length in the attachment, with its checksum."""
    with tempfile.TemporaryFile() as stream:
        stream.write(data)
        stream.flush()
        os.lseek(stream.fileno(), 0, os.SEEK_SET)
        summary = make_reader(stream).get_summary()
    assert summary is not None
    (index,) = summary.attachment_indexes
    begin, end = index.offset + 9, index.offset + index.length - 4
    text = end - index.data_size
    for _ in range(rng.choice((1, 3, 10))):
        data[rng.randrange(text, end)] = rng.choice(b"0123456789-.:[]{}&*!\n #'\"\xff\0ae")
    struct.pack_into("<I", data, end, zlib.crc32(data[begin:end]))
