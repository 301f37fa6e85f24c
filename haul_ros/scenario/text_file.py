"""Text files of users, with a bound on their size."""

from __future__ import annotations

from pathlib import Path

from haul_ros.errors import ScenarioError
from haul_ros.files import open_file

MOST_BYTES = 4 * 1024 * 1024
"""Longest file."""


def read_text(path: Path, kind: str) -> str:
    """Read a file of UTF-8 text; ``kind`` is what it is to be, for messages: YAML, CSV.

    Raises
    ------
    FileNotFoundError, IsADirectoryError
        There is no such file: the caller knows what was looked for.
    ScenarioError
        It cannot be read, is too long or not UTF-8 text.
    """
    try:
        with open_file(path) as file:
            data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise ScenarioError(f"{path}: more than {MOST_BYTES // 2**20} MiB, expected a {kind} file of less")
        return data.decode("utf-8-sig")
    except (FileNotFoundError, IsADirectoryError):
        raise
    except UnicodeDecodeError as error:
        raise ScenarioError(f"{path}: not a {kind} file: not text in UTF-8") from error
    except (OSError, ValueError) as error:
        raise ScenarioError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from error
