"""``haul run``: a scenario in one go, recorded and summarised."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from haul_ros.analysis.summary import RunSummary, summarize_session
from haul_ros.cli.interrupt import Interruption, interruption
from haul_ros.cli.layout import file_size, rows
from haul_ros.cli.notices import Notices
from haul_ros.cli.progress import progress
from haul_ros.cli.summary_text import summary_json, summary_lines, warnings
from haul_ros.errors import one_line
from haul_ros.model.sample import Sample
from haul_ros.model.scenario import Scenario
from haul_ros.physics.train_model import COMPILING, kernel_is_cached
from haul_ros.scenario import load_scenario, parse_override
from haul_ros.simulation.batch import periods
from haul_ros.simulation.session import Session

if TYPE_CHECKING:
    from haul_ros.cli.sink import Sink


def run(arguments: argparse.Namespace) -> int:
    """Simulate, record, print.

    The exit status is 130, 143 or 129 if a signal ended it early, 1 if energy came from nowhere or a step was not
    solved.

    Raises
    ------
    HaulError
        As for `load_scenario`, or the recording failed, which costs no summary.
    """
    scenario = load_scenario(arguments.scenario, dict(map(parse_override, arguments.overrides)))
    with interruption() as interrupted:
        sink = None if arguments.output is None else new_sink(arguments.output, scenario, arguments.compression)
        with sink.finishing() if sink else nullcontext(), progress(scenario, quiet=arguments.quiet) as bar:
            announce_compilation()
            session, notices = Session(scenario, play_commands=True), Notices()
            summary = simulate(session, sink, bar.show, interrupted, notices)
        _print(arguments, summary, notices, interrupted(), recorded=not (sink and sink.failure))
        return exit_status(summary, sink, interrupted)


def new_sink(path: Path, scenario: Scenario, compression: str) -> Sink:
    """A recording of a run.

    Raises
    ------
    RecordingError
        There can be no such recording.
    """
    from haul_ros.cli.sink import Sink  # half of the time that all imports of a run take

    return Sink(path, scenario, compression)


def exit_status(summary: RunSummary, sink: Sink | None, interrupted: Interruption) -> int:
    """How a run that has been told of ends: 1 if its numbers are wrong, else that of the signal that ended it.

    Raises
    ------
    RecordingError
        The recording failed.
    """
    if sink and sink.failure:
        raise sink.failure
    wrong = (summary.energy and summary.energy.fault) or (summary.solver and summary.solver.unconverged_steps)
    return 1 if wrong else interrupted.exit_status


def announce_compilation() -> None:
    """Say why the first session of all takes its time, if it does."""
    if not kernel_is_cached():
        print(f"haul: {COMPILING}", file=sys.stderr)


def simulate(
    session: Session,
    sink: Sink | None,
    show: Callable[[Sample], None],
    interrupted: Callable[[], bool],
    notices: Notices,
) -> RunSummary:
    """Run a session to its end or until interrupted, recorded, shown and noticed; its summary.

    Raises
    ------
    RunError
        A command cannot be carried out at its time.
    """
    began = time.perf_counter()
    for log in periods(session, interrupted):
        if sink:
            sink.put(log)
        notices.add(log)
        if log.sample is not None:
            show(log.sample)
    notices.unintended_releases = session.unintended_releases
    return summarize_session(session, time.perf_counter() - began)


def _print(
    arguments: argparse.Namespace, summary: RunSummary, notices: Notices, interrupted: bool, *, recorded: bool
) -> None:
    output: Path | None = arguments.output if recorded else None
    if arguments.json:
        recording = str(output) if output else None
        more = notices.json() | {"recording": recording, "interrupted": interrupted}
        print(json.dumps(summary_json(summary) | more, indent=2))
    elif not arguments.quiet:
        entries = notices.entries()
        if output:
            entries.append(("recorded", one_line(f"{output}, {file_size(output.stat().st_size)}")))
        print("\n".join(summary_lines(summary) + rows(entries)))
    for warning in warnings(summary):
        print(f"haul: warning: {warning}", file=sys.stderr)
    if interrupted:
        print(f"haul: interrupted at {summary.duration:.3f} s", file=sys.stderr)
