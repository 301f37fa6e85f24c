"""``python -m haul_ros.ros.parameter_documents``: the parameter file and the page of parameters, from the table.

Writes ``config/train_node.yaml`` and ``docs/parameters.md`` of the checkout in which it runs.
"""

from __future__ import annotations

import json
import sys
import textwrap
from collections.abc import Iterable
from pathlib import Path

from haul_ros.markdown import cell
from haul_ros.ros.parameters import ParameterRow, parameter_rows

_SLAVE = "slave_1"
_WIDTH = 110
_ORIGIN = "made from haul_ros/ros/parameters.py by: python -m haul_ros.ros.parameter_documents"
_TYPES = {bool: "bool", float: "double", int: "integer", str: "string"}
_SCENARIO = "the scenario's"


def parameter_file() -> str:
    """A parameter file with every default; what is the scenario's own is left out as a comment."""
    lines = [
        f"# Parameters of the node haul with their defaults; {_ORIGIN}",
        f"# Those of the radio links, radio.<slave>.*, are {_SCENARIO} unless they are given: docs/parameters.md.",
        "/**:",
        "  ros__parameters:",
    ]
    for row in parameter_rows([]).values():
        lines += textwrap.wrap(row.described(), _WIDTH, initial_indent="    # ", subsequent_indent="    # ")
        given = f"{row.name}:" if row.default is None else f"{row.name}: {json.dumps(row.default)}"
        lines.append(f"    # {given} ({_SCENARIO})" if row.default is None else f"    {given}")
    return "\n".join([*lines, ""])


def parameter_page() -> str:
    """A page with every parameter, its type, default, range and meaning."""
    rows = parameter_rows([_SLAVE]).values()
    return "\n".join(
        [
            "# Parameters of the node `haul`",
            "",
            f"<!-- {_ORIGIN} -->",
            "",
            "`ros2 param describe /haul NAME` tells the same of a running node, `train_node --help` without one.",
            "",
            *_table(row for row in rows if not row.slave),
            "",
            f"For each slave locomotive, such as `radio.{_SLAVE}.delay`; the defaults are {_SCENARIO}:",
            "",
            *_table(row for row in rows if row.slave),
            "",
        ]
    )


def _table(rows: Iterable[ParameterRow]) -> list[str]:
    head = ["| parameter | type | default | accepted | may be set | meaning |", "|---|---|---|---|---|---|"]
    return head + [
        f"| `{row.name.replace(f'.{_SLAVE}.', '.<slave>.')}` | {_TYPES[row.kind]} | {_default(row)} "
        f"| {row.accepted()} | {'at the start' if row.read_only else 'at any time'} | {cell(row.described())} |"
        for row in rows
    ]


def _default(row: ParameterRow) -> str:
    return _SCENARIO if row.default is None else f"`{json.dumps(row.default)}`"


def main() -> int:
    """Write both."""
    root = Path(__file__).parents[2]
    (root / "config/train_node.yaml").write_text(parameter_file(), encoding="utf-8")
    (root / "docs/parameters.md").write_text(parameter_page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
