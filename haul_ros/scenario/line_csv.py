"""Lines from CSV files: rows of what holds from a chainage on."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

from haul_ros.errors import ScenarioError
from haul_ros.scenario.document import Document, show
from haul_ros.scenario.schema import LINE_ROW, check
from haul_ros.scenario.schema_errors import suggestion
from haul_ros.scenario.text_file import read_text

COLUMNS = ("chainage_m", "grade_permille", "curve_radius_m", "speed_limit_kmh")

MOST_ROWS = 10_000

END_OF_LINE = 10_000_000.0
"""Where a curve ends that the last row does not end [m]: the largest chainage."""

_HEADER = re.compile(r"#\s*(source|standing|grade_ramp_m)\s*:\s*(.*)")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)

_Row = dict[str, Any]


def read_line_csv(path: Path) -> Document:
    """Read a line into the form that a YAML file of it has, each value with the number of its row's line.

    The first line that is no comment names the columns, ``chainage_m`` among them; an empty grade is that of the row
    before, without a radius the line is straight, without a limit there is none. Of the comments above it
    ``# source: ...``, ``# standing: ...`` and ``# grade_ramp_m: ...`` are data.

    Raises
    ------
    FileNotFoundError, IsADirectoryError, ScenarioError
        As for `read_text`, or it is not such a table.
    """
    document = Document(str(path), {})
    columns: list[str] = []
    rows: list[tuple[str, _Row]] = []
    for number, line in enumerate(read_text(path, "CSV").split("\n"), start=1):
        where, text = f"{path}:{number}", line.strip()
        if text.startswith("#") and not columns and (match := _HEADER.fullmatch(text)):
            key, value = match.groups()
            document.data[key], document.origins[(key,)] = _value(value) if key == "grade_ramp_m" else value, where
        if not text.strip(", ") or text.startswith("#"):
            continue
        cells = _cells(where, text)
        if not columns:
            columns = _check_columns(where, cells)
            continue
        rows.append((where, _row(where, columns, cells)))
        if len(rows) > MOST_ROWS:
            raise ScenarioError(f"{where}: more than {MOST_ROWS} rows, expected fewer")
        if len(rows) > 1 and rows[-1][1]["chainage_m"] <= (before := rows[-2][1]["chainage_m"]):
            expected = f"must be above that of the row before, {before:g}"
            raise Document(where, rows[-1][1]).refusal(("chainage_m",), expected)
    if not rows:
        raise ScenarioError(f"{path}: no rows, expected a line {','.join(COLUMNS)} and rows of numbers below it")
    _add_grades(document, rows)
    _add_curves(document, rows)
    _add_limits(document, rows)
    return document


def _cells(where: str, text: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([text], strict=True))]
    except csv.Error as error:
        raise ScenarioError(f"{where}: not a row of a CSV file: {error}") from error


def _check_columns(where: str, names: list[str]) -> list[str]:
    while not names[-1]:
        names.pop()
    for name in names:
        if name not in COLUMNS:
            raise ScenarioError(f"{where}: {show(name)}: no column of a line, {suggestion(name, COLUMNS)}")
    if len(set(names)) < len(names) or COLUMNS[0] not in names:
        expected = f"expected {COLUMNS[0]} and any of {', '.join(COLUMNS[1:])}, each once"
        raise ScenarioError(f"{where}: columns {', '.join(names)}, {expected}")
    return names


def _value(text: str) -> float | str:
    if not _NUMBER.fullmatch(text):
        return text
    value = float(text)
    return int(value) if value.is_integer() and abs(value) < 2**53 else value


def _row(where: str, columns: list[str], cells: list[str]) -> _Row:
    while len(cells) > len(columns) and not cells[-1]:
        cells.pop()
    if len(cells) != len(columns):
        raise ScenarioError(f"{where}: {len(cells)} cells, expected {len(columns)}: {', '.join(columns)}")
    row = {column: _value(cell) for column, cell in zip(columns, cells, strict=True) if cell}
    check(Document(where, row), LINE_ROW)
    return row


def _add(document: Document, key: str, where: str, entry: dict[str, float]) -> None:
    entries = document.data.setdefault(key, [])
    document.origins[(key, len(entries))] = where
    entries.append(entry)


def _add_grades(document: Document, rows: list[tuple[str, _Row]]) -> None:
    now: float | None = None
    for where, row in rows:
        if (grade := row.get("grade_permille", now)) is not None and grade != now:
            _add(document, "grades", where, {"from_m": row["chainage_m"], "grade_permille": grade})
            now = grade


def _add_curves(document: Document, rows: list[tuple[str, _Row]]) -> None:
    now: float | None = None
    for where, row in rows:
        if (radius := row.get("curve_radius_m")) == now:
            continue
        if now is not None:
            document.data["curves"][-1]["to_m"] = row["chainage_m"]
        if radius is not None:
            curve = {"from_m": row["chainage_m"], "to_m": END_OF_LINE, "radius_m": radius}
            _add(document, "curves", where, curve)
        now = radius


def _add_limits(document: Document, rows: list[tuple[str, _Row]]) -> None:
    now: float | None = None
    for where, row in rows:
        if (limit := row.get("speed_limit_kmh")) != now:
            entry = {"from_m": row["chainage_m"]}
            _add(document, "speed_limits", where, entry if limit is None else entry | {"limit_kmh": limit})
            now = limit
