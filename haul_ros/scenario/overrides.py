"""Values replaced for one run: ``radio.default.delay_s=1``."""

from __future__ import annotations

import copy
import numbers
from collections.abc import Mapping
from typing import Any

from haul_ros.errors import ScenarioError
from haul_ros.scenario.catalogue import SECTION_FILES
from haul_ros.scenario.document import Document, KeyPath, dotted
from haul_ros.scenario.schema import is_known, known_keys
from haul_ros.scenario.schema_errors import suggestion
from haul_ros.scenario.yaml_file import parse_yaml

ORIGIN = "override"
"""Stands for the file and line in messages about an override."""


def parse_override(text: str) -> tuple[str, Any]:
    """Split ``KEY=VALUE``, the value being YAML: a number, true, text, ``[...]`` or ``{...}``.

    Raises
    ------
    ScenarioError
        There is no ``=`` or no key, or the value is not YAML.
    """
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise ScenarioError(f"{ORIGIN} {text!r}: expected KEY=VALUE, such as initial_speed_kmh=60")
    return key.strip(), parse_yaml(value, f"{ORIGIN} {key.strip()}").data


def _plain(value: object) -> Any:
    """A value as YAML would give it: tuples become lists, foreign numbers int or float."""
    match value:
        case None | bool() | str():
            return value
        case numbers.Integral():
            return int(value)
        case numbers.Real():
            return float(value)
        case Mapping():
            return {str(key): _plain(child) for key, child in value.items()}
        case list() | tuple():
            return [_plain(child) for child in value]
    raise ScenarioError(f"{ORIGIN}: a value of type {type(value).__name__} means nothing in a scenario")


def _index(document: Document, path: KeyPath, part: str) -> int:
    length = len(document.at(path))
    if not part.isdecimal() or int(part) >= length:
        expected = f"an index from 0 to {length - 1}" if length else "no index, it is empty"
        raise ScenarioError(f"{ORIGIN}: {dotted((*path, part))}: {dotted(path)} is a list, expected {expected}")
    return int(part)


def _step(document: Document, path: KeyPath, part: str, last: bool) -> KeyPath:
    """One part further down; a mapping that the schema knows is made where it is missing."""
    value = document.at(path)
    if isinstance(value, list):
        return (*path, _index(document, path, part))
    if not isinstance(value, dict):
        raise ScenarioError(f"{ORIGIN}: {dotted((*path, part))}: {dotted(path)} is a single value")
    if part not in value:
        inside = (*path, part)
        if len(path) == 1 and path[0] in SECTION_FILES and not last:
            used = ", ".join(value) or "none"
            raise ScenarioError(f"{ORIGIN}: {dotted(inside)}: not used by this scenario, {path[0]}: {used}")
        if not is_known(inside):
            known = dict.fromkeys([*value, *known_keys(path)])
            raise ScenarioError(f"{ORIGIN}: {dotted(inside)}: unknown key, {suggestion(part, known)}")
        if not last:
            value[part] = {}
            document.set_origins(inside, {inside: ORIGIN})
    return (*path, part)


def _mark_overridden(document: Document, path: KeyPath) -> None:
    """Note in the entry, or the line, that this value is no longer what its source says."""
    if path[0] in SECTION_FILES:
        entry, keys = path[:2], path[2:]
    elif path[0] == "track" and path[1:2] != ("start_chainage_m",):
        entry, keys = path[:1], path[1:]
    else:
        return
    if not keys or keys[0] in ("source", "standing"):
        return
    values = document.at(entry)
    standing = values.get("standing") if isinstance(values, dict) else None
    if isinstance(standing, str | dict):
        exceptions = {"default": standing} if isinstance(standing, str) else standing
        values["standing"] = exceptions | {dotted(keys): "overridden"}


def _set(document: Document, key: str, value: object) -> None:
    path: KeyPath = ()
    parts = key.split(".")
    for number, part in enumerate(parts, start=1):
        path = _step(document, path, part, last=number == len(parts))
    document.at(path[:-1])[path[-1]] = copy.deepcopy(_plain(value))
    document.set_origins(path, {path: ORIGIN})
    _mark_overridden(document, path)


def alters_entry(key: str) -> bool:
    """Whether an override changes something inside a vehicle, coupler or other catalogue entry."""
    parts = key.split(".")
    return parts[0] in SECTION_FILES and len(parts) > 2


def apply(document: Document, overrides: Mapping[str, object]) -> None:
    """Set each dotted path of a scenario to its value, in the given order.

    Raises
    ------
    ScenarioError
        A path that neither the scenario nor its schema has, or a value no scenario can hold.
    """
    for key, value in overrides.items():
        _set(document, key, value)
