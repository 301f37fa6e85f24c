"""``haul info``: what is in a recording."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from haul_ros.cli.layout import file_size, lost_bytes, resolutions, rows
from haul_ros.errors import RecordingError, one_line
from haul_ros.recording.foreign import ForeignRecording, foreign_recording
from haul_ros.recording.info import RecordingInfo, TopicInfo
from haul_ros.recording.reader import Recording
from haul_ros.recording.recovery import Survey, survey
from haul_ros.units import NS_PER_S

_WIDEST = 80
"""Characters of the column of topics."""
_LONGEST_CHECK = 5.0
"""Wall time [s] for the checksums of chunks: some gigabytes."""


def info(arguments: argparse.Namespace) -> int:
    """Print the facts about a recording; of one that cannot be opened those before its damage, and what is wrong."""
    try:
        with Recording(arguments.file) as recording:
            facts = recording.info()
            until = time.monotonic() + _LONGEST_CHECK
            checked = recording.check_chunks(lambda: time.monotonic() > until)
    except RecordingError:
        with suppress(RecordingError):
            if foreign := foreign_recording(arguments.file):
                lines = _foreign_lines(foreign)
                print(json.dumps(_foreign_json(foreign), indent=2) if arguments.json else "\n".join(lines))
                return 0
        with suppress(RecordingError):
            found = survey(arguments.file)
            print(json.dumps(_trusted_json(found), indent=2) if arguments.json else "\n".join(_trusted_lines(found)))
        raise
    print(json.dumps(_json(facts, *checked), indent=2) if arguments.json else "\n".join(_lines(facts, *checked)))
    return 0


def _lines(facts: RecordingInfo, checked: int, chunks: int) -> list[str]:
    times = f"{facts.start_ns / NS_PER_S:.3f} to {facts.end_ns / NS_PER_S:.3f} s of simulation"
    return [
        one_line(
            f"{facts.path}: {file_size(facts.size)}, compression {facts.compression}, by haul_ros {facts.version}"
        ),
        *rows(
            [
                ("scenario", one_line(f"{facts.scenario}: {facts.description}")),
                ("train", f"{facts.vehicles} vehicles, {facts.couplers} couplers, {', '.join(facts.locomotives)}"),
                ("time", f"{times}, time step {facts.time_step * 1e3:g} ms"),
                *_samples(facts),
                *([("sensors", f"at {', '.join(facts.measured)}")] if facts.measured else []),
                ("messages", f"{facts.messages}, {_completeness(facts)}"),
                ("checksums", _checksums(checked, chunks)),
            ]
        ),
        *_topic_lines(facts.topics),
    ]


def _samples(facts: RecordingInfo) -> list[tuple[str, str]]:
    """How samples were recorded, if not as they came."""
    told = []
    if facts.plan.every > 1:
        told.append(f"{facts.record_rate:g} a second, one in {facts.plan.every} of those published")
    if rounding := facts.plan.rounding.resolutions():
        told.append(f"rounded: {resolutions(rounding)}")
    return [("samples", "; ".join(told))] if told else []


def _foreign_lines(found: ForeignRecording) -> list[str]:
    return [
        one_line(f"{found.path}: {file_size(found.size)}, topics of a train, recorded by {found.library or 'another'}"),
        *rows(
            [
                ("time", f"{found.duration:.3f} s by the clock of its recorder"),
                ("messages", str(found.messages)),
                ("scenario", "not in it: haul replay needs a recording by the node itself, haul analyze does without"),
            ]
        ),
        *_topic_lines(found.topics),
    ]


def _foreign_json(found: ForeignRecording) -> dict[str, Any]:
    return {
        "path": str(found.path),
        "size_bytes": found.size,
        "library": found.library,
        "scenario": None,
        "start_ns": found.start_ns,
        "end_ns": found.end_ns,
        "duration_s": found.duration,
        "messages": found.messages,
        "topics": _topics_json(found.topics),
    }


def _topic_lines(topics: Sequence[TopicInfo]) -> list[str]:
    width = min(_WIDEST, max((len(topic.topic) for topic in topics), default=0))
    return ["topics", *(one_line(f"  {topic.topic:{width}} {topic.count:8d}  {topic.msgtype}") for topic in topics)]


def _topics_json(topics: Sequence[TopicInfo]) -> list[dict[str, Any]]:
    return [{"topic": topic.topic, "type": topic.msgtype, "messages": topic.count} for topic in topics]


def _trusted_lines(found: Survey) -> list[str]:
    width = min(_WIDEST, max(map(len, found.counts), default=0))
    lost = lost_bytes(found.bytes_lost, found.damage) if found.damage else "only its summary section"
    return [
        f"{one_line(str(found.path))}: {file_size(found.size)}, damaged or unfinished; before its damage",
        *rows(
            [
                ("scenario", one_line(f"{found.description.get('scenario')}: {found.description.get('description')}")),
                ("messages", f"{sum(found.counts.values())} up to {found.end_ns / NS_PER_S:.3f} s of simulation"),
                ("damaged", one_line(lost)),
            ]
        ),
        "topics",
        *(one_line(f"  {topic:{width}} {count:8d}") for topic, count in found.counts.items()),
    ]


def _trusted_json(found: Survey) -> dict[str, Any]:
    return {
        "path": str(found.path),
        "size_bytes": found.size,
        "complete": False,
        "damage": found.damage,
        "bytes_lost": found.bytes_lost,
        "scenario": found.description.get("scenario"),
        "description": found.description.get("description"),
        "end_ns": found.end_ns,
        "messages": sum(found.counts.values()),
        "topics": found.counts,
    }


def _completeness(facts: RecordingInfo) -> str:
    lost = f"{facts.lost} more were written and are missing, " if facts.lost else ""
    if facts.dropped is None:
        return f"{lost}the recorder did not end: how many are missing is not known"
    return lost + (f"{facts.dropped} dropped" if facts.dropped else "none dropped")


def _checksums(checked: int, chunks: int) -> str:
    if checked == chunks:
        return "all fit"
    return f"those of the first {checked} of {chunks} chunks fit, the others have not been compared"


def _json(facts: RecordingInfo, checked: int, chunks: int) -> dict[str, Any]:
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
        "messages_written": facts.written,
        "complete": facts.complete,
        "record_rate_hz": facts.record_rate,
        "record_every": facts.plan.every,
        "rounding": facts.plan.rounding.resolutions(),
        "measured_couplers": list(facts.measured),
        "chunks": chunks,
        "chunks_checked": checked,
        "topics": _topics_json(facts.topics),
    }
