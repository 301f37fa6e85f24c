"""Results of finished cases in one file, so that a study goes on where it stopped."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from haul_ros.studies.case import CaseResult
from haul_ros.studies.errors import StudyError


class ResultStore:
    """Results by the digest of what they depend on, in an SQLite file, made if missing.

    Each result is on disk, whole, when `add` returns. For the thread that opened it.

    Raises
    ------
    StudyError
        From every method: the file is of another kind, or cannot be read or written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with self._errors():
            self._database = sqlite3.connect(path)
            with self._database:
                self._database.execute(
                    "CREATE TABLE IF NOT EXISTS results (key TEXT PRIMARY KEY, name TEXT NOT NULL, result BLOB)"
                )

    def __enter__(self) -> ResultStore:
        return self

    def __exit__(self, *_: object) -> None:
        self._database.close()

    def __contains__(self, key: str) -> bool:
        with self._errors():
            return self._database.execute("SELECT 1 FROM results WHERE key = ?", (key,)).fetchone() is not None

    def __getitem__(self, key: str) -> CaseResult:
        with self._errors():
            row = self._database.execute("SELECT result FROM results WHERE key = ?", (key,)).fetchone()
        if row is None:
            raise KeyError(key)
        try:
            return CaseResult.from_bytes(row[0])
        except ValueError as error:
            raise StudyError(f"{self._path}: damaged ({error}): delete it to run all cases again") from error

    def add(self, key: str, name: str, result: CaseResult) -> None:
        """Keep a result; the name is for people who open the file."""
        with self._errors(), self._database:
            self._database.execute("INSERT OR REPLACE INTO results VALUES (?, ?, ?)", (key, name, result.to_bytes()))

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise StudyError(f"{self._path}: not usable as results of studies: {error}") from error
