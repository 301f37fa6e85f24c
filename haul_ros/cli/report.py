"""``haul report``: a page of a recording, for any browser."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from haul_ros.cli.layout import file_size
from haul_ros.cli.progress import reading_progress
from haul_ros.errors import one_line
from haul_ros.page.report import default_report, write_report


def report(arguments: argparse.Namespace) -> int:
    """Write the page and say where it is."""
    path: Path = arguments.file
    output = arguments.output or default_report(path)
    with reading_progress() as show:
        written = write_report(path, output, node=arguments.node, run=arguments.run, show=show)
    if arguments.json:
        print(json.dumps({"report": str(written.path), "size_bytes": written.size}, indent=2))
    else:
        print(one_line(f"{written.path}: {file_size(written.size)}, to be opened in a browser; it needs nothing else"))
    return 0
