"""``haul replay``: a recorded run once more, to compare bit for bit or with something changed."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict

from haul_ros.analysis.recorded import recorded_scenario, summarize_recording
from haul_ros.analysis.replay import Comparison, replay_and_compare, session_with_changes
from haul_ros.analysis.summary import RunSummary
from haul_ros.cli.interrupt import interruption
from haul_ros.cli.layout import resolutions, rows
from haul_ros.cli.notices import Notices
from haul_ros.cli.progress import progress
from haul_ros.cli.run import announce_compilation, exit_status, new_sink, simulate
from haul_ros.cli.summary_text import side_by_side, summary_json, warnings
from haul_ros.errors import HaulError, one_line
from haul_ros.recording.reader import Recording
from haul_ros.scenario import parse_override
from haul_ros.units import NS_PER_S


class ReplayError(HaulError):
    """A replay that is not asked for whole."""


def replay(arguments: argparse.Namespace) -> int:
    """Compare, or run again with changes; the exit status is 1 if the replay differs, makes energy or is not solved."""
    if arguments.overrides and arguments.output is None:
        raise ReplayError("--set changes the run: expected -o NEW.mcap, the file to record it to")
    with Recording(arguments.file) as recording:
        announce_compilation()
        return _compare(arguments, recording) if arguments.output is None else _run_again(arguments, recording)


def _compare(arguments: argparse.Namespace, recording: Recording) -> int:
    with progress(recorded_scenario(recording), quiet=arguments.json) as bar:
        found = replay_and_compare(recording, bar.show)
    if arguments.json:
        print(json.dumps({"identical": found.identical, **asdict(found)}, indent=2))
    else:
        print("\n".join(_lines(found)))
    if found.dropped != 0:
        print(f"haul: warning: {_incomplete(found.dropped)}: a replay may differ", file=sys.stderr)
    return 0 if found.identical else 1


def _lines(found: Comparison) -> list[str]:
    notes = [f"missing: {count} messages of {topic or 'other topics'}" for topic, count in found.missing.items()]
    if found.rounding:
        notes.append(f"rounded before: {resolutions(found.rounding)}; extremes have all their bits")
    if found.first is None:
        same = f"{found.messages} messages of couplers, vehicles, cylinder pressure and extremes, bit for bit"
        return [f"incomplete: the same are {same}" if found.missing else f"identical: {same}", *notes]
    first = found.first
    values = f"{first.quantity}: recorded {first.recorded!r}, replayed {first.replayed!r}"
    return [
        f"different: {found.differing} of {found.messages} messages",
        f"first at {first.time_ns / NS_PER_S:.3f} s in {first.topic}: {first.name} {values}",
        *notes,
    ]


def _incomplete(dropped: int | None) -> str:
    return "the recorder did not end" if dropped is None else f"{dropped} messages were dropped while recording"


def _run_again(arguments: argparse.Namespace, recording: Recording) -> int:
    session = session_with_changes(recording, dict(map(parse_override, arguments.overrides)))
    recorded = summarize_recording(recording, recorded_scenario(recording))
    with interruption() as interrupted:
        sink = new_sink(arguments.output, session.scenario, recording.metadata["compression"])
        with sink.finishing(), progress(session.scenario, quiet=arguments.json) as bar:
            notices = Notices()
            again = simulate(session, sink, bar.show, interrupted, notices)
        _print(arguments, recorded, again, notices)
        return exit_status(again, sink, interrupted)


def _print(arguments: argparse.Namespace, recorded: RunSummary, again: RunSummary, notices: Notices) -> None:
    if arguments.json:
        anew = summary_json(again) | notices.json()
        both = {"recorded": summary_json(recorded), "again": anew, "recording": str(arguments.output)}
        print(json.dumps(both, indent=2))
    else:
        changes = ", ".join(arguments.overrides) or "no change"
        print(one_line(f"{arguments.file}, and again with {changes}: {arguments.output}"))
        happened = rows((name, f"run again: {text}") for name, text in notices.entries())
        print("\n".join(side_by_side(recorded, again) + happened))
    for warning in warnings(again):
        print(f"haul: warning: {warning}", file=sys.stderr)
