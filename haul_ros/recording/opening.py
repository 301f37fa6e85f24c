"""What kind of file a recording is, and one error for all that can be wrong with it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from mcap.writer import MCAP0_MAGIC

from haul_ros.errors import HaulError, RecordingError
from haul_ros.files import open_file
from haul_ros.recording.run_file import ACTIVE_SUFFIX, recovery_hint


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Whatever the libraries raise on damaged bytes becomes a RecordingError that names the file."""
    try:
        yield
    except HaulError:
        raise
    except OSError as err:
        raise RecordingError(f"{path}: cannot be read: {err.strerror}") from err
    except Exception as err:
        raise RecordingError(f"{path}: damaged recording: {type(err).__name__}: {err}") from err


def open_finished(path: Path) -> BinaryIO:
    """Open a file that begins and ends as MCAP files do.

    Raises
    ------
    RecordingError
        It cannot be read, is no MCAP file, or does not end as one.
    """
    stream = open_existing(path)
    try:
        with reading(path):
            head, tail = _ends(stream)
        if head != MCAP0_MAGIC:
            raise RecordingError(f"{path}: {another_kind(head)}")
        if tail != MCAP0_MAGIC:
            raise RecordingError(f"{path}: {_unfinished(path)}; {recovery_hint(path)}")
    except BaseException:
        stream.close()
        raise
    return stream


def another_kind(head: bytes) -> str:
    """What a file is that begins with other bytes than an MCAP file."""
    return f"{'not an MCAP file' if head else 'empty'}, expected a recording of haul_ros"


def open_existing(path: Path) -> BinaryIO:
    """Open a file; RecordingError: there is none, which says so of an unfinished one of its name."""
    try:
        return open_file(path)
    except FileNotFoundError:
        active = path.with_name(path.name + ACTIVE_SUFFIX)
        hint = f"; an unfinished recording {active.name} lies there, {recovery_hint(active)}" if active.exists() else ""
        raise RecordingError(f"{path}: no such file{hint}") from None
    except OSError as err:
        raise RecordingError(f"{path}: cannot be read: {err.strerror}") from err


def _ends(stream: BinaryIO) -> tuple[bytes, bytes]:
    """As many bytes as the magic has from the start, and from the end behind them."""
    head = stream.read(len(MCAP0_MAGIC))
    stream.seek(max(len(head), stream.seek(0, os.SEEK_END) - len(MCAP0_MAGIC)))
    tail = stream.read()
    stream.seek(0)
    return head, tail


def _unfinished(path: Path) -> str:
    if path.suffix == ACTIVE_SUFFIX:
        return "unfinished: its recorder still writes or was killed"
    return "unfinished or cut off: does not end as an MCAP file does"
