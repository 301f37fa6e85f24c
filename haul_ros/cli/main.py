"""The command ``haul``: what it is asked for, and how it ends."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from io import TextIOWrapper
from pathlib import Path
from pkgutil import resolve_name
from typing import NoReturn

from haul_ros.cli.commands import COMMANDS
from haul_ros.ending import no_interrupt_lost
from haul_ros.errors import HaulError, one_line
from haul_ros.resources import haul_command
from haul_ros.version import __version__

USER_ERROR = 2
INTERRUPTED = 130
"""Exit status after SIGINT, as shells count it."""

_ROS_ARGUMENTS = "--ros-args"


class _Parser(argparse.ArgumentParser):
    """Says in one line what is wrong."""

    def error(self, message: str) -> NoReturn:
        self.exit(USER_ERROR, f"{one_line(f'haul: {message} (see {self.prog} --help)')}\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command in ``argv``, None: that of the process. Returns the exit status.

    0 done, 2 the user's mistake with one line on stderr, 130 interrupted, 1 otherwise.
    """
    _open_closed_streams()
    arguments = _parse(sys.argv[1:] if argv is None else argv)
    os.environ["MPLBACKEND"] = "agg"  # pictures go into files, and the one asked for may not exist
    try:
        _check_current_folder()
        # Only the module of the command asked for is imported: no numba to read a file, no rclpy but for the node
        with no_interrupt_lost():
            status: int = resolve_name(arguments.execute)(arguments)
        sys.stdout.flush()
    except HaulError as error:
        print(f"haul: {error}", file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read the output has enough
        _give_up_output()
        return 1
    except OSError as error:  # of files HaulError tells, so it is the output
        _give_up_output()
        print(f"haul: the output cannot be written: {error.strerror or error}", file=sys.stderr)
        return 1
    return status


def _open_closed_streams() -> None:
    """Where the output was closed before the start, Python has None in its place."""
    if sys.stdout is None:
        sys.stdout = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 (as long as the process)
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # its encoding may lack what a name holds
            stream.reconfigure(errors="backslashreplace")


def _check_current_folder() -> None:
    try:
        Path.cwd()
    except OSError as error:
        raise HaulError("the current folder is gone, expected to be started in one that exists") from error


def _give_up_output() -> None:
    """Python must not fail once more when it flushes at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _parse(argv: Sequence[str]) -> argparse.Namespace:
    own = list(argv)
    ros_arguments: list[str] = []
    if own[:1] == ["node"] and _ROS_ARGUMENTS in own:
        start = own.index(_ROS_ARGUMENTS)
        own, ros_arguments = own[:start], own[start:]
    return build_parser().parse_args(own, argparse.Namespace(ros_arguments=ros_arguments))


def build_parser() -> argparse.ArgumentParser:
    """The parser; the function that carries a command out is named in ``execute``."""
    parser = _Parser(prog=haul_command(), description="Longitudinal dynamics of heavy-haul trains.")
    parser.add_argument("--version", action="version", version=f"haul {__version__}")
    subparsers = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in COMMANDS:
        subparser = subparsers.add_parser(command.name, help=command.help, epilog=command.epilog)
        subparser.set_defaults(execute=command.execute)
        command.add_arguments(subparser)
    return parser


if __name__ == "__main__":
    sys.exit(main())
