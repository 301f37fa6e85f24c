"""``haul info``: what is in a recording."""

from __future__ import annotations

import argparse
import json
from typing import Any

from haul_ros.cli.layout import file_size, rows
from haul_ros.recording.info import RecordingInfo
from haul_ros.recording.reader import Recording
from haul_ros.units import NS_PER_S


def info(arguments: argparse.Namespace) -> int:
    """Print the facts about a recording."""
    with Recording(arguments.file) as recording:
        facts = recording.info()
    print(json.dumps(_json(facts), indent=2) if arguments.json else "\n".join(_lines(facts)))
    return 0


def _lines(facts: RecordingInfo) -> list[str]:
    times = f"{facts.start_ns / NS_PER_S:.3f} to {facts.end_ns / NS_PER_S:.3f} s of simulation"
    width = max((len(topic.topic) for topic in facts.topics), default=0)
    return [
        f"{facts.path}: {file_size(facts.size)}, compression {facts.compression}, by haul_ros {facts.version}",
        *rows(
            [
                ("scenario", f"{facts.scenario}: {facts.description}"),
                ("train", f"{facts.vehicles} vehicles, {facts.couplers} couplers, {', '.join(facts.locomotives)}"),
                ("time", f"{times}, time step {facts.time_step * 1e3:g} ms"),
                ("messages", f"{facts.messages}, {_completeness(facts)}"),
            ]
        ),
        "topics",
        *(f"  {topic.topic:{width}} {topic.count:8d}  {topic.msgtype}" for topic in facts.topics),
    ]


def _completeness(facts: RecordingInfo) -> str:
    if facts.dropped is None:
        return "the recorder did not end: how many are missing is not known"
    return f"{facts.dropped} dropped" if facts.dropped else "none dropped"


def _json(facts: RecordingInfo) -> dict[str, Any]:
    return {
        "path": str(facts.path),
        "size_bytes": facts.size,
        "version": facts.version,
        "scenario": facts.scenario,
        "description": facts.description,
        "time_step_s": facts.time_step,
        "vehicles": facts.vehicles,
        "couplers": facts.couplers,
        "locomotives": list(facts.locomotives),
        "compression": facts.compression,
        "start_ns": facts.start_ns,
        "end_ns": facts.end_ns,
        "duration_s": facts.duration,
        "messages": facts.messages,
        "messages_dropped": facts.dropped,
        "complete": facts.complete,
        "topics": [{"topic": t.topic, "type": t.msgtype, "messages": t.count} for t in facts.topics],
    }
