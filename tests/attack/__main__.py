"""``python -m tests.attack``: seeded, resumable; prints a table of what was tried, and every finding."""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session
from tests.attack import disks, files, processes, recordings, starvation, trains
from tests.attack.harness import Attack, Outcome, Part, State, attack, try_case
from tests.attack.machine import without_mounts, without_ros
from tests.ros.domain import own_domain


def _of_nodes(name: str) -> Attack:
    def attack_node(rng: random.Random, folder: Path) -> Outcome:
        from tests.attack import nodes  # needs rclpy

        found: Outcome = getattr(nodes, name)(rng, folder)
        return found

    return attack_node


PARTS = [
    Part("scenarios", 10, files.scenario),
    Part("studies", 0.4, files.study),
    Part("arguments", 8, files.arguments),
    Part("parameters", 30, files.parameters, lacking=without_ros),
    Part("damaged recordings", 45, recordings.damaged),
    Part("forged recordings", 4, recordings.forged),
    Part("messages", 1, trains.messages),
    Part("numerics", 1.45, trains.numerics),
    Part("kills", 0.06, processes.killed),
    Part("signals", 0.05, processes.ended),
    Part("lost files", 0.04, processes.robbed),
    Part("starved runs", 0.02, starvation.starved, longest=120.0),
    Part("lost disks", 0.03, disks.vanishing, longest=90.0, lacking=without_mounts),
    *(
        Part(name, share, _of_nodes(function), longest=120.0, lacking=without_ros)
        for name, share, function in (
            ("killed nodes", 0.06, "killed"),
            ("flooded nodes", 0.03, "flooded"),
            ("frozen subscribers", 0.03, "frozen"),
            ("resumed nodes", 0.03, "resumed"),
            ("starved nodes", 0.03, "starved"),
        )
    ),
]
"""Shares in hundredths of all cases; what takes longer has less."""


def _possible(part: Part) -> bool:
    lacking = part.lacking()
    if lacking:
        print(f"{part.name}: skipped, {lacking}", flush=True)
    return not lacking


def table(state: State) -> str:
    """The tallies as Markdown."""
    lines = ["| | tried | refused or told | ran | failed | s |", "|---|---|---|---|---|---|"]
    lines += [
        f"| {name} | {t.tried} | {t.refused} | {t.ran} | {t.failed} | {t.seconds:.0f} |"
        for name, t in state.tallies.items()
    ]
    every = list(state.tallies.values())
    sums = [sum(getattr(t, name) for t in every) for name in ("tried", "refused", "ran", "failed", "seconds")]
    return "\n".join([*lines, "| **all** | {} | {} | {} | {} | {:.0f} |".format(*sums)])


def main() -> int:
    """Attack; the exit status is 1 if anything was found."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack", description=__doc__)
    parser.add_argument("--cases", type=int, default=10_000, help="in all, default 10000")
    parser.add_argument("--minutes", type=float, default=600.0, help="stop after so long")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--part", action="append", choices=[part.name for part in PARTS], help="only this; repeatable")
    parser.add_argument("--state", type=Path, help="file to go on from, and to keep the tallies in")
    parser.add_argument("--case", metavar="PART:NUMBER", help="try this one case again")
    arguments = parser.parse_args()
    if arguments.cases < 1:
        parser.error(f"--cases {arguments.cases}: must be 1 or more")
    parts = {part.name: part for part in PARTS}
    os.environ.update(own_domain())
    state = State(arguments.state, arguments.seed)
    if arguments.case:
        name, _, number = arguments.case.rpartition(":")
        if name not in parts or not number.isdecimal():
            parser.error(f"--case {arguments.case}: expected PART:NUMBER, parts are {', '.join(parts)}")
        outcome, found = try_case(parts[name], state.seed, int(number))
        print(outcome.value if outcome else found)
        return outcome is None
    # In the background a shell has it ignored, by children too
    signal.signal(signal.SIGINT, signal.default_int_handler)
    Session(load_scenario("daqin_1_1_0"))  # compiles the kernel, which no case has the time for
    attack(
        [part for name, part in parts.items() if name in (arguments.part or parts) and _possible(part)],
        state,
        arguments.cases,
        time.monotonic() + 60.0 * arguments.minutes,
        lambda found: print(found, flush=True),
    )
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False).stdout
    print(f"seed {state.seed}, {datetime.now(UTC):%Y-%m-%d}, commit {commit.strip() or 'unknown'}\n\n{table(state)}")
    return int(any(tally.failed for tally in state.tallies.values()))


if __name__ == "__main__":
    sys.exit(main())
