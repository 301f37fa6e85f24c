"""Tables as files."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from haul_ros.files import create_file

Table = Mapping[str, Sequence[object]]
"""Columns of equal length by name; the unit is the end of the name."""

_Append = Callable[[Table], None]
_BATCH = 50
"""Pieces of a table that are in memory at a time."""


def write_table(table: Table, stem: Path) -> list[Path]:
    """Write ``stem.csv``, and ``stem.parquet`` if pyarrow is installed; returns the files."""
    return write_pieces([table], stem)


def write_pieces(pieces: Iterable[Table], stem: Path) -> list[Path]:
    """Write one or more tables of the same columns below one another, few in memory at a time; files as `write_table`.

    CSV (RFC 4180) has numbers to nine significant digits, Parquet in full.
    """
    formats: dict[str, Callable[[Path], AbstractContextManager[_Append]]] = {"csv": _csv_file}
    if parquet_available():
        formats["parquet"] = _parquet_file
    files = [stem.with_name(f"{stem.name}.{suffix}") for suffix in formats]
    with ExitStack() as stack:
        appends = [stack.enter_context(opened(file)) for opened, file in zip(formats.values(), files, strict=True)]
        for batch in _batches(iter(pieces)):
            for append in appends:
                append(batch)
    return files


def write_arrays(arrays: Mapping[str, NDArray[Any]], path: Path) -> Path:
    """Write arrays by name as one compressed ``.npz`` of numpy; returns the file."""
    with create_file(path) as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]
    return path


def parquet_available() -> bool:
    """Whether pyarrow, which writes Parquet, is installed."""
    return find_spec("pyarrow") is not None


def _batches(pieces: Iterator[Table]) -> Iterator[Table]:
    while batch := list(islice(pieces, _BATCH)):
        yield {name: [value for table in batch for value in table[name]] for name in batch[0]}


@contextmanager
def _csv_file(path: Path) -> Iterator[_Append]:
    with io.TextIOWrapper(create_file(path), encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)

        def append(table: Table) -> None:
            if stream.tell() == 0:
                writer.writerow(table)
            rows = zip(*table.values(), strict=True)
            writer.writerows([f"{value:.9g}" if isinstance(value, float) else value for value in row] for row in rows)

        yield append


@contextmanager
def _parquet_file(path: Path) -> Iterator[_Append]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    with ExitStack() as stack:
        file = stack.enter_context(create_file(path))
        writer = None

        def append(table: Table) -> None:
            nonlocal writer
            rows = pa.table({name: list(column) for name, column in table.items()})
            if writer is None:
                writer = stack.enter_context(pq.ParquetWriter(file, rows.schema))
            writer.write_table(rows)

        yield append
