"""``haul compare``: recordings and measured line tests side by side."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

from haul_ros.analysis.bundle import AnalysisError, write_files
from haul_ros.analysis.comparison import (
    Compared,
    LineTest,
    compared,
    comparison_table,
    error_table,
    labels,
    profile_table,
)
from haul_ros.analysis.comparison_plots import measured_figure, profiles_figure
from haul_ros.analysis.line_test import BANDS, read_csv, read_mapping
from haul_ros.analysis.numbers import Window
from haul_ros.analysis.pictures import PictureFormat
from haul_ros.analysis.tables import Table
from haul_ros.cli.layout import rows
from haul_ros.cli.progress import reading_progress
from haul_ros.errors import one_line

_Value = TypeVar("_Value", str, int)
_DEFAULT_FOLDER = Path("comparison")


def compare(arguments: argparse.Namespace) -> int:
    """Write the tables and pictures of a comparison and print its numbers."""
    recordings = [path for path in arguments.files if path.suffix.lower() != ".csv"]
    measurements = [path for path in arguments.files if path not in recordings]
    if not recordings or len(arguments.files) < 2:
        raise AnalysisError("a comparison needs a recording, and another one or a measured line test as .csv")
    tests = _line_tests(arguments, measurements)
    window = Window(
        -math.inf if arguments.begin is None else arguments.begin, math.inf if arguments.end is None else arguments.end
    )
    nodes = _of_each("--node", arguments.node, recordings)
    numbers = _of_each("--run", arguments.run, recordings)
    runs: list[Compared] = []
    for label, path, node, number in zip(labels(recordings), recordings, nodes, numbers, strict=True):
        with reading_progress() as show:
            runs.append(compared(label, path, tests, window, arguments.limit * 1e3, node, number, show=show))
    tables: dict[str, Table] = {}
    figures = {}
    title = " - ".join(run.label for run in runs)
    pictures = PictureFormat(arguments.format, arguments.dpi or 0)
    with pictures.style():
        if len(runs) > 1:
            tables["comparison"] = comparison_table(runs)
            if profiles := profile_table(runs):
                tables["profiles"] = profiles
            figures["profiles"] = profiles_figure(runs, title)
        if errors := error_table(runs, tests):
            tables["errors"] = errors
            figures["measured"] = measured_figure(runs, tests, title)
        files = write_files(arguments.output or _DEFAULT_FOLDER, tables, figures, pictures)
    if arguments.json:
        found = {name: _records(table) for name, table in tables.items() if name != "profiles"}
        print(json.dumps(found | {"files": [str(file) for file in files]}, indent=2))
    else:
        lines = [*_comparison_lines(tables.get("comparison")), *_error_lines(tables.get("errors"))]
        lines += rows([("written", one_line(", ".join(str(file) for file in files)))])
        print("\n".join(lines))
    return 0


def _of_each(option: str, given: Sequence[_Value], recordings: Sequence[Path]) -> list[_Value | None]:
    """What is given once for all, for each, or not at all."""
    if len(given) not in (0, 1, len(recordings)):
        problem = f"{option} {len(given)} times for {len(recordings)} recordings"
        raise AnalysisError(f"{problem}, expected once for all or once for each")
    found: list[_Value | None] = list(given) if given else [None]
    return found if len(found) == len(recordings) else found * len(recordings)


def _line_tests(arguments: argparse.Namespace, paths: Sequence[Path]) -> list[LineTest]:
    targets = read_mapping(arguments.map)
    time = next((column for column, target in targets.items() if target == "time"), None)
    columns = [column for column, target in targets.items() if target != "time"]
    if targets and not paths:
        raise AnalysisError("--map without a measured line test, expected a .csv file")
    return [LineTest(read_csv(path, columns or None, time), targets, arguments.offset) for path in paths]


def _comparison_lines(table: Table | None) -> list[str]:
    """A row for each quantity that any run has; of those that are the same everywhere no difference."""
    if table is None:
        return []
    names = [name for name in table if name != "quantity"]
    width = max(12, *(min(24, len(name)) for name in names))
    lines = [f"  {'':44} {' '.join(f'{one_line(name)[:width]:>{width}}' for name in names)}"]
    for i, quantity in enumerate(table["quantity"]):
        values = [table[name][i] for name in names]
        if any(value is not None for value in values):
            cells = [f"{'-':>{width}}" if value is None else f"{value:>{width}.6g}" for value in values]
            lines.append(f"  {quantity!s:44} {' '.join(cells)}")
    return lines


def _error_lines(table: Table | None) -> list[str]:
    if table is None:
        return []
    lines = []
    for row in _records(table):
        name = f"{row['recording']}, {row['column']}" + (f" = {row['target']}" if row["target"] else "")
        unit = row["unit"]
        told = f"mean {row['mean_error']:+.4g} {unit}, rms {row['rms_error']:.4g}, at most {row['largest_error']:.4g}"
        lines.append(one_line(f"  {name}: {told}, {row['samples']} samples"))
        if row[f"share_within_{BANDS[0][0]:g}_kN"] is not None:
            shares = [
                f"{row[f'share_within_{band:g}_kN']:.1%} within {band:g} kN (published {published:.1%})"
                for band, published in BANDS
            ]
            lines.append(f"    {', '.join(shares)}")
    return lines


def _records(table: Table) -> list[dict[str, object]]:
    """The rows; what is not known, or no number, is None."""
    return [
        {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in zip(table, row, strict=True)
        }
        for row in zip(*table.values(), strict=True)
    ]
