"""``python -m haul_ros.cli.command_page``: docs/commands.md of the checkout, from the arguments of the commands."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from haul_ros.cli.commands import COMMANDS, Subcommand
from haul_ros.markdown import cell

_ORIGIN = "made from haul_ros/cli/commands.py by: python -m haul_ros.cli.command_page"
_STATUS = """\
Exit status: 0 done; 2 a mistake of the user's, with one line that says what, where and what is expected, and nothing
started; 130, 143 or 129 ended by SIGINT, SIGTERM or SIGHUP with a whole recording; 1 otherwise. `haul node`, like
`train_node`, runs until a signal: these three end it with 0, as `ros2 launch` and process managers expect. `--json`
prints for programs. In a workspace of ROS 2 the command is `ros2 run haul_ros haul`. Every input has a bound of memory
and time: `SECURITY.md`."""


def command_page() -> str:
    """A page with every command, what it takes and what that means."""
    lines = ["# The command `haul`", "", f"<!-- {_ORIGIN} -->", "", _STATUS, ""]
    for command in COMMANDS:
        lines += _section(command)
    return "\n".join(lines)


def _section(command: Subcommand) -> Iterator[str]:
    parser = argparse.ArgumentParser(add_help=False)
    command.add_arguments(parser)
    yield from (f"## haul {command.name}", "", f"{command.help[0].upper()}{command.help[1:]}.", "")
    if parser._actions:
        yield from ("| argument | meaning |", "|---|---|")
        yield from (f"| `{_name(action)}` | {_meaning(action)} |" for action in parser._actions)
        yield ""
    if command.epilog:
        yield from (command.epilog, "")


def _name(action: argparse.Action) -> str:
    value = "" if action.nargs == 0 else str(action.metavar or f"{{{','.join(action.choices or ())}}}")
    given = " ".join(filter(None, [", ".join(action.option_strings), value]))
    return given if action.required or action.nargs != "?" else f"[{given}]"


def _meaning(action: argparse.Action) -> str:
    required = "required" if action.option_strings and action.required else ""
    return "; ".join(filter(None, [cell(action.help or ""), required]))


def main() -> int:
    """Write it."""
    (Path(__file__).parents[2] / "docs/commands.md").write_text(command_page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
