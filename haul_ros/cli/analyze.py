"""``haul analyze``: tables and figures from a recording."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path

from haul_ros.analysis import bundle
from haul_ros.analysis.numbers import Window
from haul_ros.analysis.pictures import PictureFormat
from haul_ros.analysis.tables import parquet_available
from haul_ros.cli.layout import rows
from haul_ros.cli.number_text import number_lines, numbers_json, peak_lines
from haul_ros.cli.progress import reading_progress
from haul_ros.cli.summary_text import summary_json, summary_lines, warnings
from haul_ros.errors import one_line

_TABLES = (".csv", ".parquet")


def analyze(arguments: argparse.Namespace) -> int:
    """Write the results of an analysis and print what was found."""
    path: Path = arguments.file
    options = bundle.AnalysisOptions(
        window=Window(
            -math.inf if arguments.begin is None else arguments.begin,
            math.inf if arguments.end is None else arguments.end,
        ),
        couplers=arguments.couplers,
        node=arguments.node,
        run=arguments.run,
        limit=arguments.limit * 1e3,
        pictures=PictureFormat(arguments.format, arguments.dpi or 0),
    )
    with reading_progress() as show:
        result = bundle.analyze(path, arguments.output or bundle.default_folder(path), options, show)
    summary = result.summary
    if arguments.json:
        files = {"files": [str(file) for file in result.files]}
        of_run = {} if summary is None else summary_json(summary)
        print(json.dumps(of_run | {"title": result.title} | numbers_json(result.numbers) | files, indent=2))
    else:
        of_run_lines = [one_line(result.title), *rows(peak_lines(result.numbers, result.layout))]
        lines = of_run_lines if summary is None else summary_lines(summary)
        lines += rows(number_lines(result.numbers, result.layout))
        print("\n".join([*lines, *rows([("written", _written(result.files))])]))
    for warning in warnings(summary) if summary is not None else ():
        print(f"haul: warning: {warning}", file=sys.stderr)
    if not parquet_available():
        print("haul: no Parquet files written: needs pyarrow, pip install 'haul_ros[parquet]'", file=sys.stderr)
    return 0


def _written(files: Sequence[Path]) -> str:
    """The files of one folder in a line, tables by their names alone."""
    tables = list(dict.fromkeys(file.stem for file in files if file.suffix in _TABLES))
    kinds = [suffix for suffix in _TABLES if any(file.suffix == suffix for file in files)]
    others = [file.name for file in files if file.suffix not in _TABLES]
    return one_line(f"{files[0].parent}: {', '.join(tables)} ({', '.join(kinds)}), {', '.join(others)}")
