"""A measured line test beside a recording: signals of a CSV, put to couplers and vehicles, and how far they are off.

Forces are in kN and compression positive, as tables of this package have them, speeds in km/h, times in s.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from haul_ros.errors import HaulError
from haul_ros.files import open_file
from haul_ros.model.sample import FloatArray

BANDS = ((64.6, 0.68), (129.2, 0.95), (193.8, 0.997))
"""Errors of force [kN] below which published models of 20 000 t trains lie, and in which part of the samples of line
tests: Railway Sciences 4(2), p. 231."""
LARGEST_CSV = 512 * 1024 * 1024
"""Bytes of a file of measurements."""
MOST_ROWS = 5_000_000
_MOST_COLUMNS = 1000
_PIECE = 50_000
"""Rows."""
_LARGEST_MAP = 1024 * 1024
_TIMES = ("time_s", "time", "t_s", "t")
_COUPLER = re.compile(r"(-?)(coupler_[0-9]{3,4})(_force_kN)?")
_VEHICLE = re.compile(r"(-?)(vehicle_[0-9]{3,4})([A-Za-z0-9_-]*?)(_speed_kmh)?")


class LineTestError(HaulError):
    """A file of measurements, or a mapping, that cannot be used."""


@dataclass(frozen=True, slots=True)
class Signal:
    """A ``column`` of a CSV that shows the force [kN] of a coupler or the speed [km/h] of a vehicle.

    ``index`` is that of the coupler or vehicle, 0 at the head; ``sign`` -1: the file has the other sign.
    """

    column: str
    target: str
    is_force: bool
    index: int
    sign: float = 1.0

    @property
    def unit(self) -> str:
        """Of its values."""
        return "kN" if self.is_force else "km/h"


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """Columns of a CSV at ``time`` (n,) [s], in rising order; NaN where a field is empty."""

    path: Path
    time: FloatArray
    columns: Mapping[str, FloatArray]


@dataclass(frozen=True, slots=True)
class ErrorStatistics:
    """Simulated less measured, in the unit of the signal, over ``samples`` measured ones.

    ``within`` has the part of the samples whose error is at most each of `BANDS` (of forces alone). ``correlation`` is
    NaN where a signal does not change.
    """

    samples: int
    mean: float
    rms: float
    standard_deviation: float
    largest: float
    correlation: float
    within: tuple[float, ...]


def error_statistics(simulated: FloatArray, measured: FloatArray) -> ErrorStatistics:
    """Of two signals (n,) at the same times; where either is NaN they are not compared."""
    both = np.isfinite(simulated) & np.isfinite(measured)
    simulated, measured = simulated[both], measured[both]
    if not len(simulated):
        nothing = float("nan")
        return ErrorStatistics(0, nothing, nothing, nothing, nothing, nothing, tuple(nothing for _ in BANDS))
    error = simulated - measured
    changing = len(error) > 1 and simulated.std() > 0.0 and measured.std() > 0.0
    return ErrorStatistics(
        samples=len(error),
        mean=float(error.mean()),
        rms=float(np.sqrt(np.mean(error**2))),
        standard_deviation=float(error.std()),
        largest=float(np.abs(error).max()),
        correlation=float(np.corrcoef(simulated, measured)[0, 1]) if changing else float("nan"),
        within=tuple(float(np.mean(np.abs(error) <= band)) for band, _ in BANDS),
    )


def read_mapping(entries: Iterable[str]) -> dict[str, str]:
    """Targets by column, from entries ``column=target`` and from files that have one in each line.

    Raises
    ------
    LineTestError
        A file that cannot be read, or an entry that is none.
    """
    found: dict[str, str] = {}
    for entry in entries:
        lines = [(entry, "--map")] if "=" in entry else _mapping_lines(Path(entry))
        for text, where in lines:
            column, equals, target = (part.strip() for part in text.rpartition("="))
            if not (column and equals and target):
                raise LineTestError(f"{where}: {text[:60]!r}, expected COLUMN=coupler_050, vehicle_001 or time")
            found[column] = target
    return found


def read_csv(path: Path, columns: Iterable[str] | None, time_column: str | None = None) -> Measurement:
    """The chosen columns of a CSV with a header (None: all that hold forces and speeds by their names), and its times.

    ``time_column`` None: the first of time_s, time, t_s and t that there is.

    Raises
    ------
    LineTestError
        It cannot be read, has no such column, a field that is no number, or times that do not rise.
    """
    try:
        with open_file(path) as file:
            if file.seek(0, io.SEEK_END) > LARGEST_CSV:
                raise LineTestError(f"{path}: larger than {LARGEST_CSV} bytes, expected at most that")
            file.seek(0)
            with io.TextIOWrapper(file, encoding="utf-8-sig", newline="") as text:
                return _read(path, csv.reader(text), columns, time_column)
    except OSError as error:
        raise LineTestError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError:
        raise LineTestError(f"{path}: not UTF-8 text, expected a CSV file") from None
    except csv.Error as error:
        raise LineTestError(f"{path}: {error}, expected a CSV file") from error


def signals(
    measurement: Measurement, targets: Mapping[str, str], couplers: Sequence[str], vehicles: Sequence[str]
) -> tuple[Signal, ...]:
    """The signals of a file for a train; without ``targets`` columns that are called as couplers and vehicles are.

    Raises
    ------
    LineTestError
        A target that the train does not have, or no signal at all.
    """
    chosen = targets or {column: column for column in measurement.columns}
    found = []
    for column, target in chosen.items():
        if target == "time":
            continue
        signal = _signal(column, target, couplers, vehicles)
        if signal is None:
            ends = f"{couplers[0]} to {couplers[-1]} or {vehicles[0] if vehicles else 'vehicle_001'} and so on"
            raise LineTestError(f"{measurement.path}: {column} is put to {target}, expected {ends}")
        found.append(signal)
    return tuple(found)


def _signal(column: str, target: str, couplers: Sequence[str], vehicles: Sequence[str]) -> Signal | None:
    if (match := _COUPLER.fullmatch(target)) and match[2] in couplers:
        return Signal(column, match[2], True, list(couplers).index(match[2]), -1.0 if match[1] else 1.0)
    if match := _VEHICLE.fullmatch(target):
        for index, name in enumerate(vehicles):
            if name == match[2] + match[3] or (not match[3] and name.startswith(f"{match[2]}_")):
                return Signal(column, name, False, index, -1.0 if match[1] else 1.0)
    return None


def _mapping_lines(path: Path) -> list[tuple[str, str]]:
    try:
        with open_file(path) as file:
            text = file.read(_LARGEST_MAP + 1).decode()
    except OSError as error:
        raise LineTestError(f"{path}: cannot be read: {error.strerror}, expected COLUMN=TARGET or a file") from error
    except UnicodeDecodeError:
        raise LineTestError(f"{path}: not UTF-8 text, expected lines COLUMN=TARGET") from None
    if len(text) > _LARGEST_MAP:
        raise LineTestError(f"{path}: larger than {_LARGEST_MAP} bytes, expected lines COLUMN=TARGET")
    lines = ((line.partition("#")[0].strip(), f"{path}:{number}") for number, line in enumerate(text.splitlines(), 1))
    return [line for line in lines if line[0]]


def _is_named(column: str) -> bool:
    vehicle = _VEHICLE.fullmatch(column)
    return bool(_COUPLER.fullmatch(column) or (vehicle and vehicle[4]))


def _read(path: Path, rows: Iterable[list[str]], columns: Iterable[str] | None, time_column: str | None) -> Measurement:
    rows = iter(rows)
    header = [name.strip() for name in next(iter(rows), [])]
    if not 2 <= len(header) <= _MOST_COLUMNS:
        raise LineTestError(f"{path}: {len(header)} columns, expected a header with 2 to {_MOST_COLUMNS}")
    wanted = [name for name in header if _is_named(name)] if columns is None else list(columns)
    time = time_column or next((name for name in _TIMES if name in header), "time_s")
    for name in (time, *wanted):
        if header.count(name) != 1:
            there = "has no" if name not in header else "has more than one"
            raise LineTestError(f"{path}: {there} column {name}, it has {', '.join(header)}")
    if not wanted:
        raise LineTestError(f"{path}: no column is called as coupler_050 or vehicle_001_speed_kmh, expected --map")
    places = [header.index(name) for name in (time, *wanted)]
    pieces, values = [np.empty((0, len(places)))], list[list[float]]()
    for number, row in enumerate(rows, 2):
        if number > MOST_ROWS + 1:
            raise LineTestError(f"{path}: more than {MOST_ROWS} rows, expected at most that")
        if row:
            values.append([_number(path, number, header[at], row[at] if at < len(row) else "") for at in places])
        if len(values) >= _PIECE:  # as lists they take far more memory
            pieces.append(np.array(values))
            values = []
    table = np.concatenate([*pieces, np.array(values, dtype=float).reshape(-1, len(places))])
    if not len(table) or not np.isfinite(table[:, 0]).all() or (np.diff(table[:, 0]) <= 0.0).any():
        raise LineTestError(f"{path}: {time} does not rise from row to row, expected times in s")
    return Measurement(path, table[:, 0], {name: table[:, i] for i, name in enumerate(wanted, 1)})


def _number(path: Path, row: int, column: str, text: str) -> float:
    if not text.strip():
        return float("nan")
    try:
        return float(text)
    except ValueError:
        raise LineTestError(f"{path}:{row}: {column} is {text[:40]!r}, expected a number") from None
