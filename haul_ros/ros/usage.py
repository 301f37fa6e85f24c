"""What ``train_node --help`` prints: made from the table of parameters, and importable where there is no ROS."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence

from haul_ros.ros.parameters import ParameterRow, parameter_rows

_ROS_ARGUMENTS, _END = "--ros-args", "--"
_WIDTH = 110
_SLAVE = "slave_1"

_HEAD = """\
usage: train_node [-h] [--ros-args [-p NAME:=VALUE] [-r FROM:=TO] [--params-file FILE] ...]

The live train: simulates in real time, takes brake commands on topics, publishes and records, until SIGINT, SIGTERM or
SIGHUP. Several trains have namespaces: --ros-args -r __ns:=/train_a.

parameters (* may be set while it runs):"""


def asks_for_help(arguments: Sequence[str]) -> bool:
    """Whether ``-h`` or ``--help`` is among the arguments that are not ROS's."""
    of_ros = False
    for argument in arguments:
        if argument in (_ROS_ARGUMENTS, _END):
            of_ros = argument == _ROS_ARGUMENTS
        elif argument in ("-h", "--help") and not of_ros:
            return True
    return False


def usage() -> str:
    """The text."""
    return "\n".join([_HEAD, *_entries(parameter_rows([_SLAVE]).values())])


def _entries(rows: Iterable[ParameterRow]) -> list[str]:
    lines = []
    for row in rows:
        name = row.name.replace(f".{_SLAVE}.", ".<slave>.")
        lines.append(f"  {name}{'' if row.read_only else ' *'}")
        lines += textwrap.wrap(row.summary(), _WIDTH, initial_indent="      ", subsequent_indent="      ")
    return lines
