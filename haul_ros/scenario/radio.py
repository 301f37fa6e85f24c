"""Radio links, and changes of them, from a checked document."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from haul_ros.model.consist import MASTER, Consist
from haul_ros.model.radio import CHANGEABLE, Interval, RadioLink, RadioLinkChange
from haul_ros.scenario.document import Document, KeyPath

_KEYS = {
    "delay": "delay_s",
    "jitter": "jitter_s",
    "retry_interval": "retry_interval_s",
    "burst_length": "burst_length_s",
    "burst_spacing": "burst_spacing_s",
    "heartbeat": "heartbeat_s",
    "link_timeout": "link_timeout_s",
}
"""Keys of the document by the fields of a link, where they have a unit."""
_PLAIN = (*CHANGEABLE, "jitter_shape", "heartbeat", "link_lost", "link_timeout")
"""Fields whose values stand in the document as they are."""
_DECIMAL = {field.name for field in fields(RadioLink) if isinstance(field.default, float)}
SHORTEST_HEARTBEAT = 0.1
"""Between two status telegrams [s]."""


def _plain(entry: dict[str, Any]) -> dict[str, Any]:
    """The fields of a link that an entry gives as they are, decimal numbers where the link has such."""
    found = {}
    for name in _PLAIN:
        if (key := _KEYS.get(name, name)) in entry:
            found[name] = float(entry[key]) if name in _DECIMAL else entry[key]
    return found


def _spans(document: Document, path: KeyPath, unit: str) -> tuple[Interval, ...]:
    spans: list[Interval] = []
    for index, entry in enumerate(document.at(path)):
        begin, end = float(entry[f"from_{unit}"]), float(entry[f"to_{unit}"])
        if end <= begin:
            raise document.refusal((*path, index, f"to_{unit}"), f"must be above from_{unit}, {begin:g}")
        if spans and begin < spans[-1][1]:
            raise document.refusal((*path, index, f"from_{unit}"), f"the one before ends at {spans[-1][1]:g}")
        spans.append((begin, end))
    return tuple(spans)


def _quantiles(document: Document, path: KeyPath) -> tuple[float, ...]:
    values = tuple(map(float, document.at(path)))
    for index in range(1, len(values)):
        if values[index] < values[index - 1]:
            raise document.refusal((*path, index), f"must be at least that before, {values[index - 1]:g}")
    return values


def _given(document: Document, path: KeyPath) -> dict[str, Any]:
    """The fields of a link that are given at a path."""
    entry = document.at(path)
    found = _plain(entry)
    for name, unit in (("outages", "s"), ("tunnels", "m")):
        if name in entry:
            found[name] = _spans(document, (*path, name), unit)
    if "jitter_quantiles" in entry:
        found["jitter_quantiles"] = _quantiles(document, (*path, "jitter_quantiles"))
    return found


def radio_links(document: Document, train: Consist) -> dict[str, RadioLink]:
    """One link per slave: the default with what is given for that slave.

    Raises
    ------
    ScenarioError
        A link to a slave that the train does not have, or values that do not go together.
    """
    entry = document.data["radio"]
    slaves = [loco.name for loco in train.locomotives if loco.name != MASTER]
    for key in entry:
        if key.startswith("slave_") and key not in slaves:
            raise document.error(("radio", key), f"no such locomotive, slaves: {', '.join(slaves) or 'none'}")
    base = _given(document, ("radio", "default"))
    _check(document, ("radio", "default"), RadioLink(**base))
    links = {}
    for name in slaves:
        path: KeyPath = ("radio", name)
        links[name] = RadioLink(**base | (_given(document, path) if name in entry else {}))
        _check(document, path, links[name])
    return links


def _check(document: Document, path: KeyPath, link: RadioLink) -> None:
    """Refuse a slave that would take a link for lost between any two status telegrams, or never acts on that."""
    if link.link_timeout and not 0.0 < link.heartbeat < link.link_timeout:
        expected = f"must be above heartbeat_s, {link.heartbeat:g}, which must be above 0"
        raise document.error(path, f"link_timeout_s = {link.link_timeout:g}, {expected}")
    if link.link_lost != "hold" and not link.link_timeout:
        raise document.error(path, f"link_lost = {link.link_lost!r} needs link_timeout_s above 0")
    if 0.0 < link.heartbeat < SHORTEST_HEARTBEAT:
        raise document.error(path, f"heartbeat_s = {link.heartbeat:g}, must be 0 or at least {SHORTEST_HEARTBEAT:g}")


def link_change(document: Document, path: KeyPath, train: Consist) -> RadioLinkChange:
    """The change of a radio link in a command at a path.

    Raises
    ------
    ScenarioError
        There is no such slave, nothing changes, or it has a locomotive too.
    """
    entry = document.at(path)
    slaves = [loco.name for loco in train.locomotives if loco.name != MASTER]
    if entry["link"] not in slaves:
        raise document.refusal((*path, "link"), f"must be one of {', '.join(slaves) or 'none, there is no slave'}")
    if "locomotive" in entry:
        raise document.refusal((*path, "locomotive"), "must not stand beside link")
    if not (values := _plain(entry)):
        keys = ", ".join(_KEYS.get(name, name) for name in CHANGEABLE)
        raise document.error(path, f"link needs beside it what changes: {keys}")
    return RadioLinkChange(entry["link"], **values)
