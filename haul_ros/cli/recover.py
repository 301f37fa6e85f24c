"""``haul recover``: an unfinished or damaged recording made whole."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

from haul_ros.cli.layout import file_size, lost_bytes, rows
from haul_ros.errors import one_line
from haul_ros.recording.recovery import Recovery, recover
from haul_ros.units import NS_PER_S

_SHOWN = 3
"""Gaps that are told one by one."""


def recover_file(arguments: argparse.Namespace) -> int:
    """Recover a recording into a new file and say what was recovered and what was lost."""
    result = recover(arguments.file, arguments.output)
    if arguments.json:
        print(json.dumps({"recording": str(arguments.output), **asdict(result)}, indent=2))
    else:
        size = file_size(arguments.output.stat().st_size)
        print(one_line(f"{arguments.output}: {size}, recovered from {arguments.file}, which is left as it is"))
        print("\n".join(rows([("recovered", _recovered(result)), ("lost", _lost(result))])))
    return 0


def _recovered(result: Recovery) -> str:
    return f"{result.messages} messages up to {result.end_ns / NS_PER_S:.3f} s of simulation"


def _lost(result: Recovery) -> str:
    parts = [lost_bytes(result.bytes_lost, result.damage)] if result.damage else []
    if result.missing:
        shown = ", ".join(f"{begin / NS_PER_S:.3f} to {end / NS_PER_S:.3f} s" for begin, end in result.gaps[:_SHOWN])
        more = f" and {len(result.gaps) - _SHOWN} more" if len(result.gaps) > _SHOWN else ""
        where = [f"between {shown}{more}"] if shown else []
        where += [f"{result.unplaced} of them behind the last of their topics"] if result.unplaced else []
        parts.append(f"{result.missing} messages, dropped while recording or taken out, {', '.join(where)}")
    if result.repeated:
        parts.append(f"{result.repeated} messages that were there twice were left out")
    return one_line("; ".join(parts)) or "nothing of the file"
