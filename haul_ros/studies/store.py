"""Results of finished cases in one file, so that a study goes on where it stopped."""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from haul_ros.studies.case import MOST_BYTES, CaseResult
from haul_ros.studies.errors import StudyError

_TABLE = "CREATE TABLE results (key TEXT PRIMARY KEY, name TEXT NOT NULL, result BLOB)"
_FIND = "SELECT substr(name, 1, 1000), CASE WHEN length(result) <= ? THEN result END FROM results WHERE key = ?"
"""What is too large to be a result is not even fetched."""
_SCHEMA = {("table", "results", _TABLE), ("index", "sqlite_autoindex_results_1", None)}


class ResultStore:
    """Results by the digest of what they depend on, in an SQLite file, made if missing.

    Each result is on disk, whole, when `add` returns, with a digest over itself and its key. One that is damaged, that
    stands under the key of another or lacks numbers counts as not there; ``refused`` has the names of those met.
    For the thread that opened it.

    Raises
    ------
    StudyError
        From every method: the file is of another kind, or cannot be read or written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.refused: dict[str, str] = {}
        if path.is_symlink():
            raise StudyError(f"{path}: is a link, expected a file or nothing")
        with self._errors():
            self._database = sqlite3.connect(path)
            self._database.text_factory = lambda text: text.decode(errors="replace")  # damaged text is met below
            self._database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_BYTES)  # whatever stands in the file
            with self._database:
                self._database.execute(_TABLE.replace("TABLE", "TABLE IF NOT EXISTS", 1))
            if self._schema() != _SCHEMA:  # a view or a trigger computes what it likes, for as long as it likes
                raise StudyError(f"{path}: not usable as results of studies: expected the table of results alone")

    def _schema(self) -> set[tuple[str, str, str | None]]:
        found = self._database.execute("SELECT type, name, sql FROM sqlite_master LIMIT ?", (len(_SCHEMA) + 1,))
        return set(found.fetchall())

    def __enter__(self) -> ResultStore:
        return self

    def __exit__(self, *_: object) -> None:
        self._database.close()

    def __contains__(self, key: str) -> bool:
        return self._find(key) is not None

    def __getitem__(self, key: str) -> CaseResult:
        found = self._find(key)
        if found is None:
            raise StudyError(f"{self._path}: a result has been lost or damaged meanwhile: run the study again")
        return found

    def _find(self, key: str) -> CaseResult | None:
        with self._errors():
            row = self._database.execute(_FIND, (MOST_BYTES, key)).fetchone()
        if row is None:
            return None
        try:
            return _unseal(key, row[1])
        except ValueError as error:
            self.refused[key] = f"{row[0]}: {error}"
            return None

    def add(self, key: str, name: str, result: CaseResult) -> None:
        """Keep a result; the name is for people who open the file."""
        sealed = _seal(key, result)
        with self._errors(), self._database:
            self._database.execute("INSERT OR REPLACE INTO results VALUES (?, ?, ?)", (key, name, sealed))
            kept = self._database.execute(_FIND, (MOST_BYTES, key)).fetchone()
        if kept is None or kept[1] != sealed:  # a trigger that has come into the file may discard or change it
            raise StudyError(f"{self._path}: not usable as results of studies: it does not keep what is put into it")

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise StudyError(f"{self._path}: not usable as results of studies: {error}") from error


def _digest(key: str, data: bytes) -> bytes:
    return hashlib.sha256(key.encode() + data).digest()


def _seal(key: str, result: CaseResult) -> bytes:
    data = result.to_bytes()
    return _digest(key, data) + data


def _unseal(key: str, sealed: object) -> CaseResult:
    """The result in what `_seal` made for this key; ValueError: it did not, or numbers are missing."""
    size = hashlib.sha256().digest_size
    if not isinstance(sealed, bytes) or sealed[:size] != _digest(key, sealed[size:]):
        raise ValueError("damaged, or of another case")
    result = CaseResult.from_bytes(sealed[size:])
    if not result.complete:
        raise ValueError("not all numbers are finite")
    return result
