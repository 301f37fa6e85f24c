"""Attacks by damaged and forged recordings."""

from __future__ import annotations

import random
import struct
import tempfile
import zlib
from contextlib import suppress
from functools import cache
from io import BytesIO
from pathlib import Path

from mcap.reader import make_reader

from haul_ros.errors import RecordingError
from tests.attack import nasty
from tests.attack.harness import Found, Outcome, haul
from tests.recorded import content, sign_summary, summary_section


@cache
def _whole() -> tuple[bytes, list[object]]:
    """A recording of a short run, and all that is in it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        haul("run", "daqin_1_1_0", "--set", "max_duration_s=0.5", "--set", "sample_rate_hz=10", "-o", str(path))
        return path.read_bytes(), content(path)


def damaged(rng: random.Random, folder: Path) -> Outcome:
    """Changed bytes: either noticed, or nothing that is read is another."""
    data, whole = _whole()
    path = folder / "damaged.mcap"
    path.write_bytes(nasty.change_bytes(rng, data))
    try:
        found = content(path)
    except RecordingError:
        outcome = Outcome.REFUSED
    else:
        if found != whole:
            raise Found("a damaged recording is read as another one")
        outcome = Outcome.RAN
    if rng.random() < 0.1:
        _commands(rng, path, folder)
    return outcome


def _commands(rng: random.Random, path: Path, folder: Path) -> None:
    match rng.randrange(5):
        case 0:
            haul("info", str(path), *rng.choice(((), ("--json",))))
        case 1:
            haul("replay", str(path), statuses=(0, 1))
        case 2:
            haul("recover", str(path), "-o", str(folder / "recovered.mcap"))
            if (folder / "recovered.mcap").exists():
                content(folder / "recovered.mcap")
        case 3:
            haul("compare", str(path), str(path), "-o", str(folder / "comparison"))
        case _:
            haul("analyze", str(path), "-o", str(folder / "analysis"))


def forged(rng: random.Random, folder: Path) -> Outcome:
    """Changed numbers with right checksums, in the summary section, the scenario or the description of the run."""
    data = bytearray(_whole()[0])
    begin, footer = summary_section(data)
    if rng.random() < 0.3:
        _forge_scenario(rng, data)
    else:
        for _ in range(rng.choice((1, 1, 2, 5))):
            form, most = rng.choice((("<Q", 2**64 - 1), ("<I", 2**32 - 1), ("<H", 2**16 - 1), ("<B", 255)))
            number = rng.choice((0, 1, most, most // 2, most // 2 + 1, rng.randint(0, most)))
            struct.pack_into(form, data, rng.randrange(begin, footer - 8), number)
    sign_summary(data)
    path = folder / "forged.mcap"
    path.write_bytes(data)
    with suppress(RecordingError):
        content(path)
    if rng.random() < 0.3:
        _commands(rng, path, folder)
    return Outcome.RAN


def _forge_scenario(rng: random.Random, data: bytearray) -> None:
    """Other bytes of the same length in the attachment, with its checksum."""
    summary = make_reader(BytesIO(data)).get_summary()
    assert summary is not None
    (index,) = summary.attachment_indexes
    begin, end = index.offset + 9, index.offset + index.length - 4
    text = end - index.data_size
    for _ in range(rng.choice((1, 3, 10))):
        data[rng.randrange(text, end)] = rng.choice(b"0123456789-.:[]{}&*!\n #'\"\xff\0ae")
    struct.pack_into("<I", data, end, zlib.crc32(data[begin:end]))
