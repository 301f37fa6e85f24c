"""What a recording says of its run, taken as text from a file: each entry has its form and bounds."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping

from haul_ros.messages.channels import ChannelTable, channel_table
from haul_ros.model.recording_plan import RecordingPlan, Rounding

MOST_VEHICLES = 2000
"""As in a scenario."""
LONGEST_TEXT = 10_000
"""Characters of a description in words, as in a scenario; names have at most `LONGEST_NAME`."""
LONGEST_NAME = 255

LONGEST_REMAPPING = 200_000
"""Characters of all remapped topics and their names before."""

_TOPIC = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
_LOCOMOTIVE = re.compile(r"master|slave_[1-9][0-9]{0,3}")
_COUPLER = re.compile(r"coupler_[0-9]{3,4}")
_COUNT = re.compile(r"0|[1-9][0-9]{0,5}")
_LENGTHS = {
    "version": LONGEST_NAME,
    "scenario": LONGEST_NAME,
    "description": LONGEST_TEXT,
    "time_step": LONGEST_NAME,
    "vehicles": LONGEST_NAME,
    "couplers": LONGEST_NAME,
    "topic_prefix": LONGEST_NAME,
    "compression": LONGEST_NAME,
    "locomotives": 20 * MOST_VEHICLES,
    "record_rate": LONGEST_NAME,
    "record_every": LONGEST_NAME,
    "rounding": LONGEST_TEXT,
    "measured_couplers": 20 * MOST_VEHICLES,
}
_OPTIONAL = {"record_rate", "record_every", "rounding", "measured_couplers"}
"""Of samples that are recorded as they are published, with all their bits, and of no sensors nothing is said."""
_REMAPPED = "remapped_topics"
"""An entry that an older version does not have."""


def check_form(description: Mapping[str, str]) -> None:
    """See that a description can be used.

    Raises
    ------
    ValueError
        An entry is missing or no such thing.
    """
    for key in _LENGTHS.keys() - description.keys() - _OPTIONAL:
        raise ValueError(f"description of the run: has no {key}")
    for key, longest in _LENGTHS.items():
        if len(description.get(key, "")) > longest:
            raise ValueError(f"description of the run: {key} of {len(description[key])} characters")
    if not _TOPIC.fullmatch(description["topic_prefix"]):
        raise _wrong(description, "topic_prefix", "a name such as /haul")
    if description["compression"] not in ("zstd", "lz4", "none"):
        raise _wrong(description, "compression", "zstd, lz4 or none")
    if description.get("brake", "empirical") not in ("empirical", "pneumatic"):  # older versions knew but one
        raise _wrong(description, "brake", "empirical or pneumatic")
    if not _is_positive(description["time_step"]):
        raise _wrong(description, "time_step", "seconds")
    locomotive_names(description)
    recording_plan(description)
    described_channels(description)
    if not _is_positive(description.get("record_rate", "1")):
        raise _wrong(description, "record_rate", "samples a second")
    vehicles, couplers = (_count(description, key) for key in ("vehicles", "couplers"))
    if not 1 <= vehicles == couplers + 1 <= MOST_VEHICLES:
        raise _wrong(description, "couplers", "one less than vehicles")


def locomotive_names(description: Mapping[str, str]) -> list[str]:
    """Names of the commanded locomotives, head first; ValueError: they are none."""
    try:
        names = json.loads(description["locomotives"])
    except (ValueError, RecursionError):
        names = None
    if not isinstance(names, list) or not all(isinstance(name, str) and _LOCOMOTIVE.fullmatch(name) for name in names):
        raise _wrong(description, "locomotives", "a list of names")
    if len(set(names)) != len(names):
        raise _wrong(description, "locomotives", "different names")
    return names


def measured_couplers(description: Mapping[str, str]) -> tuple[str, ...]:
    """Names of the couplers with sensors; ValueError: they are none."""
    try:
        names = json.loads(description.get("measured_couplers", "[]"))
    except (ValueError, RecursionError):
        names = None
    if not isinstance(names, list) or not all(isinstance(name, str) and _COUPLER.fullmatch(name) for name in names):
        raise _wrong(description, "measured_couplers", "a list of names")
    return tuple(names)


def recording_plan(description: Mapping[str, str]) -> RecordingPlan:
    """How often and how exactly samples were recorded; ValueError: it is no such thing."""
    if not _COUNT.fullmatch(every := description.get("record_every", "1")) or every == "0":
        raise _wrong(description, "record_every", "a number above 0")
    try:
        resolutions = json.loads(description.get("rounding", "{}"))
        return RecordingPlan(int(every), Rounding(**resolutions))
    except (ValueError, TypeError, RecursionError):
        raise _wrong(description, "rounding", "resolutions that are powers of two, by quantity") from None


def described_channels(description: Mapping[str, str]) -> ChannelTable:
    """The topics of the train of a description in form; an older version may not have recorded all of them."""
    pneumatic, sensors = description.get("brake") == "pneumatic", bool(measured_couplers(description))
    locomotives, prefix = locomotive_names(description), description["topic_prefix"]
    table = channel_table(locomotives, prefix, pneumatic=pneumatic, sensors=sensors)
    remapped = _remapped_topics(description)
    return table.resolved(lambda name: remapped.get(name, name))


def _remapped_topics(description: Mapping[str, str]) -> dict[str, str]:
    """Topics by the names from which they were remapped; ValueError: they are none."""
    text = description.get(_REMAPPED, "{}")
    try:
        remapped = json.loads(text) if len(text) <= LONGEST_REMAPPING else None
    except (ValueError, RecursionError):
        remapped = None
    if not isinstance(remapped, dict) or not all(_is_topic(topic) for item in remapped.items() for topic in item):
        raise _wrong(description, _REMAPPED, "topics by name")
    return remapped


def _is_topic(text: object) -> bool:
    return isinstance(text, str) and len(text) <= LONGEST_NAME and _TOPIC.fullmatch(text) is not None


def _is_positive(text: str) -> bool:
    try:
        return math.isfinite(float(text)) and float(text) > 0.0
    except ValueError:
        return False


def _count(description: Mapping[str, str], key: str) -> int:
    if not _COUNT.fullmatch(description[key]):
        raise _wrong(description, key, "a number")
    return int(description[key])


def _wrong(description: Mapping[str, str], key: str, expected: str) -> ValueError:
    return ValueError(f"description of the run: {key} is {description[key][:60]!r}, expected {expected}")
