"""The command ``haul``: its commands and their arguments, and how it ends."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from pkgutil import resolve_name
from typing import NoReturn

from haul_ros.errors import HaulError
from haul_ros.version import __version__

USER_ERROR = 2
INTERRUPTED = 130
"""Exit status after SIGINT, as shells count it."""

_ROS_ARGUMENTS = "--ros-args"


class _Parser(argparse.ArgumentParser):
    """Says in one line what is wrong."""

    def error(self, message: str) -> NoReturn:
        self.exit(USER_ERROR, f"haul: {message} (see {self.prog} --help)\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command in ``argv``, None: that of the process. Returns the exit status.

    0 done, 2 the user's mistake with one line on stderr, 130 interrupted, 1 otherwise.
    """
    arguments = _parse(sys.argv[1:] if argv is None else argv)
    try:
        # Only the module of the command asked for is imported: no numba to read a file, no rclpy but for the node
        status: int = resolve_name(arguments.execute)(arguments)
        sys.stdout.flush()
    except HaulError as error:
        print(f"haul: {error}", file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read the output has enough; Python must not fail once more when it flushes at its end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    return status


def _parse(argv: Sequence[str]) -> argparse.Namespace:
    own = list(argv)
    ros_arguments: list[str] = []
    if own[:1] == ["node"] and _ROS_ARGUMENTS in own:
        start = own.index(_ROS_ARGUMENTS)
        own, ros_arguments = own[:start], own[start:]
    return build_parser().parse_args(own, argparse.Namespace(ros_arguments=ros_arguments))


def build_parser() -> argparse.ArgumentParser:
    """The parser; the function that carries a command out is named in ``execute``."""
    parser = _Parser(prog="haul", description="Longitudinal dynamics of heavy-haul trains.")
    parser.add_argument("--version", action="version", version=f"haul {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)

    run = commands.add_parser("run", help="simulate a scenario as fast as it goes and print a summary")
    run.set_defaults(execute="haul_ros.cli.run:run")
    run.add_argument("scenario", metavar="SCENARIO", help="name of a shipped scenario (haul scenarios), or a file")
    run.add_argument("-o", "--output", metavar="FILE.mcap", type=Path, help="record to this new file")
    run.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="overrides",
        action="append",
        default=[],
        help="replace a value of the scenario, such as radio.default.delay_s=1; may be repeated",
    )
    run.add_argument("--compression", choices=("zstd", "lz4", "none"), default="zstd", help="of the recording")
    run.add_argument("--json", action="store_true", help="print the summary as JSON")
    run.add_argument("--quiet", action="store_true", help="neither progress bar nor summary in words")

    scenarios = commands.add_parser("scenarios", help="list the shipped scenarios")
    scenarios.set_defaults(execute="haul_ros.cli.scenarios:scenarios")
    scenarios.add_argument("--json", action="store_true", help="print as JSON")

    info = commands.add_parser("info", help="tell what is in a recording")
    info.set_defaults(execute="haul_ros.cli.info:info")
    info.add_argument("file", metavar="FILE", type=Path)
    info.add_argument("--json", action="store_true", help="print as JSON")

    analyze = commands.add_parser("analyze", help="peaks per coupler as tables and figures, from a recording")
    analyze.set_defaults(execute="haul_ros.cli.analyze:analyze")
    analyze.add_argument("file", metavar="FILE", type=Path)
    analyze.add_argument(
        "-o", "--output", metavar="DIR", type=Path, help="folder for the results, default: <FILE's name>_analysis"
    )
    analyze.add_argument("--json", action="store_true", help="print the summary as JSON")

    study = commands.add_parser(
        "study",
        help="the paper's studies and free parameter sweeps: tables, figures and what they show",
        epilog="A study goes on where it stopped: finished cases are kept in the folder.",
    )
    study.set_defaults(execute="haul_ros.cli.study:study")
    study.add_argument(
        "study",
        metavar="STUDY",
        help="validation, distribution, initial-speed, synchronisation, stiffness, rigid-arms, rigid-arm-map, "
        "vibration, marshalling, monte-carlo, a study file, or 'sweep' with --scenario and --over or --draw",
    )
    study.add_argument("-o", "--output", metavar="DIR", type=Path, help="folder of the results, default: <STUDY>_study")
    study.add_argument("--scenario", metavar="SCENARIO", help="of a sweep: name of a shipped scenario, or a file")
    study.add_argument(
        "--over",
        metavar="KEY=VALUES",
        action="append",
        default=[],
        help="vary a value of the scenario: V1,V2,... or FROM:TO:STEP; repeated: all combinations",
    )
    study.add_argument(
        "--draw",
        metavar="KEY=LAW",
        action="append",
        default=[],
        help="draw a value in each sample: uniform(LOW,HIGH) or normal(MEAN,SD); may be repeated",
    )
    study.add_argument("--samples", metavar="N", type=int, help="random samples of each combination")
    study.add_argument("--seed", metavar="N", type=int, help="of the random samples, default 0")
    study.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="overrides",
        action="append",
        default=[],
        help="replace a value of the scenario in all cases; may be repeated",
    )
    where = study.add_mutually_exclusive_group()
    where.add_argument("--jobs", metavar="N", type=int, help="cases at a time, default: the number of cores")
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="compute on this Dask cluster, such as tcp://10.0.0.1:8786"
    )
    study.add_argument("--json", action="store_true", help="print the findings as JSON")
    study.add_argument("--quiet", action="store_true", help="neither progress bar nor findings in words")

    recover = commands.add_parser("recover", help="make an unfinished or damaged recording whole, in a new file")
    recover.set_defaults(execute="haul_ros.cli.recover:recover_file")
    recover.add_argument("file", metavar="FILE", type=Path, help="such as FILE.mcap.active")
    recover.add_argument("-o", "--output", metavar="FILE.mcap", type=Path, required=True, help="the new file")
    recover.add_argument("--json", action="store_true", help="print as JSON")

    replay = commands.add_parser(
        "replay", help="simulate the recorded commands again and compare, or again with other parameters"
    )
    replay.set_defaults(execute="haul_ros.cli.replay:replay")
    replay.add_argument("file", metavar="FILE", type=Path)
    replay.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="overrides",
        action="append",
        default=[],
        help="replace a value of the scenario for another run with the same commands; may be repeated; needs -o",
    )
    replay.add_argument("-o", "--output", metavar="NEW.mcap", type=Path, help="record that run to this new file")
    replay.add_argument("--json", action="store_true", help="print as JSON")

    node = commands.add_parser(
        "node",
        help="run the live node (needs ROS 2)",
        epilog="Anything from --ros-args on is handed to the node as it is.",
    )
    node.set_defaults(execute="haul_ros.cli.ros:node")
    node.add_argument("--scenario", metavar="SCENARIO", help="name of a shipped scenario, or a file")
    node.add_argument("--record", metavar="FILE.mcap", help="record to this new file; 'none': no recording")
    node.add_argument(
        "--param",
        metavar="NAME:=VALUE",
        dest="parameters",
        action="append",
        default=[],
        help="a parameter of the node, such as radio.slave_1.delay:=0.5; may be repeated",
    )

    brake = commands.add_parser("brake", help="send one brake command to the live node (needs ROS 2)")
    brake.set_defaults(execute="haul_ros.cli.ros:brake")
    brake.add_argument("locomotive", metavar="LOCOMOTIVE", help="master, slave_1, slave_2 ...")
    demand = brake.add_mutually_exclusive_group(required=True)
    demand.add_argument("demand", metavar="DEMAND", type=float, nargs="?", help="0 release .. 1 full service")
    demand.add_argument("--emergency", action="store_true", help="emergency application")
    demand.add_argument("--release-emergency", action="store_true", help="end an emergency, at standstill only")
    return parser


if __name__ == "__main__":
    sys.exit(main())
