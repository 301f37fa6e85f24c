"""``haul analyze``: tables and figures from a recording."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from haul_ros.analysis import bundle
from haul_ros.analysis.tables import parquet_available
from haul_ros.cli.layout import rows
from haul_ros.cli.summary_text import summary_json, summary_lines, warnings
from haul_ros.errors import one_line


def analyze(arguments: argparse.Namespace) -> int:
    """Write the results of an analysis and print the summary."""
    path: Path = arguments.file
    result = bundle.analyze(path, arguments.output or bundle.default_folder(path))
    if arguments.json:
        files = [str(file) for file in result.files]
        print(json.dumps(summary_json(result.summary) | {"files": files}, indent=2))
    else:
        print(
            "\n".join(
                [*summary_lines(result.summary), *rows(("written", one_line(str(file))) for file in result.files)]
            )
        )
    for warning in warnings(result.summary):
        print(f"haul: warning: {warning}", file=sys.stderr)
    if not parquet_available():
        print("haul: peaks.parquet not written: needs pyarrow, pip install 'haul_ros[parquet]'", file=sys.stderr)
    return 0
