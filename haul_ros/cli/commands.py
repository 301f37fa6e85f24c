"""The commands of ``haul`` with their arguments; nothing here imports what carries them out."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from haul_ros.cli.values import coupler_numbers, dots, positive, seconds


@dataclass(frozen=True, slots=True)
class Subcommand:
    """A command: its name, its line in the help, what carries it out ("module:function"), and its arguments."""

    name: str
    help: str
    execute: str
    add_arguments: Callable[[ArgumentParser], None]
    epilog: str | None = None


def _run(parser: ArgumentParser) -> None:
    parser.add_argument("scenario", metavar="SCENARIO", help="name of a shipped scenario (haul scenarios), or a file")
    _output(parser, "FILE.mcap", "record to this new file")
    _set(parser, "replace a value of the scenario, such as radio.default.delay_s=1; may be repeated")
    parser.add_argument("--compression", choices=("zstd", "lz4", "none"), default="zstd", help="of the recording")
    _json(parser, "the summary")
    _quiet(parser, "summary")


def _scenarios(parser: ArgumentParser) -> None:
    _json(parser)


def _info(parser: ArgumentParser) -> None:
    _file(parser)
    _json(parser)


def _analyze(parser: ArgumentParser) -> None:
    _file(parser, "a recording, a bag's folder or one of its files")
    _output(parser, "DIR", "folder for the results, default: <FILE's name>_analysis")
    _window(parser)
    parser.add_argument(
        "--couplers", metavar="N,N-N", type=coupler_numbers, help="tables of these couplers, and their samples: 1,50-60"
    )
    _train(parser)
    _limit(parser)
    _pictures(parser)
    _json(parser, "what was found")


def _compare(parser: ArgumentParser) -> None:
    parser.add_argument(
        "files",
        metavar="FILE",
        type=Path,
        nargs="+",
        help="recordings, the first to compare with, and .csv of line tests",
    )
    _output(parser, "DIR", "folder for the results, default: comparison")
    _window(parser)
    _repeatable(
        parser,
        "--map",
        "COLUMN=TARGET",
        "what a column of a .csv shows: coupler_050 [kN], -coupler_050 where tension is positive, vehicle_001 [km/h] "
        "or time [s]; or a file of such lines; may be repeated",
    )
    parser.add_argument("--offset", metavar="S", type=seconds, default=0.0, help="add to measured times [s]")
    each = "; once for all, or once for each recording"
    _repeatable(parser, "--node", "NAME", f"full name of the train's node, where there are several trains{each}")
    parser.add_argument(
        "--run", metavar="N", type=int, action="append", default=[], help=f"which run, where the node was reset{each}"
    )
    _limit(parser)
    _pictures(parser)
    _json(parser, "the numbers")


def _report(parser: ArgumentParser) -> None:
    _file(parser, "a recording, a bag's folder or one of its files")
    _train(parser)
    _output(parser, "FILE.html", "the new file, default: <FILE's name>.html")
    _json(parser)


def _study(parser: ArgumentParser) -> None:
    parser.add_argument(
        "study",
        metavar="STUDY",
        help="validation, distribution, initial-speed, synchronisation, stiffness, rigid-arms, rigid-arm-map, "
        "vibration, marshalling, monte-carlo, cyclic-braking, release-speed, unintended-release, burst-hose, "
        "radio-outage, a study file, or 'sweep' with --scenario and --over or --draw",
    )
    _output(parser, "DIR", "folder of the results, default: <STUDY>_study")
    _scenario(parser, "of a sweep: name of a shipped scenario, or a file")
    _repeatable(
        parser,
        "--over",
        "KEY=VALUES",
        "vary a value of the scenario: V1,V2,... or FROM:TO:STEP; repeated: all combinations",
    )
    _repeatable(
        parser,
        "--draw",
        "KEY=LAW",
        "draw a value in each sample: uniform(LOW,HIGH) or normal(MEAN,SD); may be repeated",
    )
    parser.add_argument("--samples", metavar="N", type=int, help="random samples of each combination")
    parser.add_argument("--seed", metavar="N", type=int, help="of the random samples, default 0")
    _set(parser, "replace a value of the scenario in all cases; may be repeated")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--jobs", metavar="N", type=int, help="cases at a time, default: the number of cores")
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="compute on this Dask cluster, such as tcp://10.0.0.1:8786"
    )
    _json(parser, "the findings")
    _quiet(parser, "findings")


def _recover(parser: ArgumentParser) -> None:
    _file(parser, "such as FILE.mcap.active")
    _output(parser, "FILE.mcap", "the new file", required=True)
    _json(parser)


def _replay(parser: ArgumentParser) -> None:
    _file(parser)
    _set(parser, "replace a value of the scenario for another run with the same commands; may be repeated; needs -o")
    _output(parser, "NEW.mcap", "record that run to this new file")
    _json(parser)


def _node(parser: ArgumentParser) -> None:
    _scenario(parser, "name of a shipped scenario, or a file")
    parser.add_argument("--record", metavar="FILE.mcap", help="record to this new file; 'none': no recording")
    _repeatable(
        parser,
        "--param",
        "NAME:=VALUE",
        "a parameter of the node, such as radio.slave_1.delay:=0.5; may be repeated",
        dest="parameters",
    )


def _brake(parser: ArgumentParser) -> None:
    parser.add_argument("locomotive", metavar="LOCOMOTIVE", help="master, slave_1, slave_2 ...")
    demand = parser.add_mutually_exclusive_group(required=True)
    demand.add_argument("demand", metavar="DEMAND", type=float, nargs="?", help="0 release .. 1 full service")
    demand.add_argument("--emergency", action="store_true", help="emergency application")
    demand.add_argument("--release-emergency", action="store_true", help="end an emergency, at standstill only")
    parser.add_argument("--node", metavar="NAME", default="/haul", help="full name of the node, default: /haul")


def _view(parser: ArgumentParser) -> None:
    parser.add_argument("--drive", action="store_true", help="with a driver's desk; without it the page only looks")
    _watched_node(parser)
    parser.add_argument("--port", metavar="N", type=int, default=0, help="of 127.0.0.1, default: any that is free")


def _watch(parser: ArgumentParser) -> None:
    _watched_node(parser)


def _watched_node(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--node", metavar="NAME", help="full name of the node, such as /train_a/haul, default: the one that is found"
    )


def _window(parser: ArgumentParser) -> None:
    parser.add_argument("--from", dest="begin", metavar="S", type=seconds, help="only from this simulation time on [s]")
    parser.add_argument("--to", dest="end", metavar="S", type=seconds, help="only up to this simulation time [s]")


def _pictures(parser: ArgumentParser) -> None:
    parser.add_argument("--format", choices=("png", "pdf", "svg"), default="png", help="of the pictures")
    parser.add_argument("--dpi", metavar="N", type=dots, help="dots an inch of the pictures")


def _train(parser: ArgumentParser) -> None:
    parser.add_argument("--node", metavar="NAME", help="full name of the train's node, where there are several trains")
    parser.add_argument("--run", metavar="N", type=int, help="which run, where the node was reset: 1, 2 ...")


def _limit(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--limit", metavar="KN", type=positive, default=2250.0, help="force above which time is counted, default: 2250"
    )


def _file(parser: ArgumentParser, help_text: str | None = None) -> None:
    parser.add_argument("file", metavar="FILE", type=Path, help=help_text)


def _output(parser: ArgumentParser, metavar: str, help_text: str, *, required: bool = False) -> None:
    parser.add_argument("-o", "--output", metavar=metavar, type=Path, required=required, help=help_text)


def _scenario(parser: ArgumentParser, help_text: str) -> None:
    parser.add_argument("--scenario", metavar="SCENARIO", help=help_text)


def _set(parser: ArgumentParser, help_text: str) -> None:
    _repeatable(parser, "--set", "KEY=VALUE", help_text, dest="overrides")


def _repeatable(parser: ArgumentParser, option: str, metavar: str, help_text: str, *, dest: str | None = None) -> None:
    parser.add_argument(option, metavar=metavar, dest=dest, action="append", default=[], help=help_text)


def _json(parser: ArgumentParser, what: str = "") -> None:
    parser.add_argument("--json", action="store_true", help=" ".join(filter(None, ["print", what, "as JSON"])))


def _quiet(parser: ArgumentParser, what: str) -> None:
    parser.add_argument("--quiet", action="store_true", help=f"neither progress bar nor {what} in words")


COMMANDS = (
    Subcommand("run", "simulate a scenario as fast as it goes and print a summary", "haul_ros.cli.run:run", _run),
    Subcommand("scenarios", "list the shipped scenarios", "haul_ros.cli.scenarios:scenarios", _scenarios),
    Subcommand("info", "tell what is in a recording", "haul_ros.cli.info:info", _info),
    Subcommand(
        "analyze",
        "forces, run-ins, fatigue, brakes and energy from any recording, as tables and figures",
        "haul_ros.cli.analyze:analyze",
        _analyze,
    ),
    Subcommand(
        "compare",
        "recordings side by side, and measured line tests beside them",
        "haul_ros.cli.compare:compare",
        _compare,
    ),
    Subcommand(
        "report",
        "one page to look at a recording in a browser: forces, profile, brakes, events, peaks; one file, offline",
        "haul_ros.cli.report:report",
        _report,
    ),
    Subcommand(
        "study",
        "the paper's studies and free parameter sweeps: tables, figures and what they show",
        "haul_ros.cli.study:study",
        _study,
        epilog="A study goes on where it stopped: finished cases are kept in the folder.",
    ),
    Subcommand(
        "recover",
        "make an unfinished or damaged recording whole, in a new file",
        "haul_ros.cli.recover:recover_file",
        _recover,
    ),
    Subcommand(
        "replay",
        "simulate the recorded commands again and compare, or again with other parameters",
        "haul_ros.cli.replay:replay",
        _replay,
    ),
    Subcommand(
        "node",
        "run the live node (needs ROS 2)",
        "haul_ros.cli.ros:node",
        _node,
        epilog="Anything from --ros-args on is handed to the node as it is.",
    ),
    Subcommand("brake", "send one brake command to the live node (needs ROS 2)", "haul_ros.cli.ros:brake", _brake),
    Subcommand(
        "view",
        "the page of haul report live, in a browser on this machine (needs ROS 2)",
        "haul_ros.cli.view:view",
        _view,
        epilog="It prints an address with a token: who has it may look, and drive with --drive.",
    ),
    Subcommand(
        "watch",
        "show the live train in this terminal (needs ROS 2)",
        "haul_ros.cli.watch:watch",
        _watch,
        epilog="Where the output is no terminal it is a line a second.",
    ),
)
"""In the order of the help. A new command is a row here, its arguments above, and the module that carries it out."""
