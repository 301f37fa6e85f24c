"""The catalogue, and taking over from it what a scenario refers to."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from functools import cache
from typing import Any

from haul_ros.resources import config_dir
from haul_ros.scenario.document import Document, KeyPath
from haul_ros.scenario.schema import CATALOGUE, check
from haul_ros.scenario.yaml_file import read_yaml

SECTION_FILES = {
    "vehicles": "vehicles.yaml",
    "couplers": "couplers.yaml",
    "brake_systems": "brakes.yaml",
    "control_valves": "control_valves.yaml",
    "brake_shoes": "brake_shoes.yaml",
    "resistances": "resistances.yaml",
}
"""Sections of the catalogue, which scenarios may have too, and their files."""


@cache
def catalogue_section(section: str) -> Document:
    """One section of the shipped catalogue, checked; not to be changed.

    Raises
    ------
    ScenarioError
        The file cannot be read or holds something else.
    """
    document = read_yaml(config_dir() / "catalogue" / SECTION_FILES[section])
    check(document, CATALOGUE)
    return document


def _references(data: dict[str, Any]) -> Iterator[tuple[KeyPath, str]]:
    """Paths of all names that refer to an entry, and the section meant."""
    yield ("coupler",), "couplers"
    yield ("brakes",), "brake_systems"
    for name in list(data.get("brake_systems", {})):
        for key in ("wagon_valve", "locomotive_valve"):
            if key in data["brake_systems"][name]:
                yield ("brake_systems", name, key), "control_valves"
    for index, entry in enumerate(data["consist"]):
        yield ("consist", index, "vehicle"), "vehicles"
        if "coupler" in entry:
            yield ("consist", index, "coupler"), "couplers"
    # A copy, since the vehicles grow while they are looked through.
    for name in list(data.get("vehicles", {})):
        yield ("vehicles", name, "brake_shoe"), "brake_shoes"
        yield ("vehicles", name, "resistance"), "resistances"
        if "control_valve" in data["vehicles"][name]:
            yield ("vehicles", name, "control_valve"), "control_valves"


def used_entries(data: dict[str, Any]) -> set[tuple[str, str]]:
    """Section and name of all entries that a complete scenario refers to."""
    document = Document("", data)
    return {(section, document.at(path)) for path, section in _references(data)}


def take_over(document: Document) -> None:
    """Copy every catalogue entry that a checked scenario refers to, and does not have itself, into it.

    Raises
    ------
    ScenarioError
        A name that is neither in the scenario nor in the catalogue.
    """
    for path, section in _references(document.data):
        name = document.at(path)
        entries = document.data.get(section, {})
        if name in entries:
            continue
        catalogue = catalogue_section(section)
        if name not in catalogue.data[section]:
            known = sorted({*entries, *catalogue.data[section]})
            raise document.refusal(path, f"unknown name, {section}: {', '.join(known)}")
        document.data.setdefault(section, {})[name] = copy.deepcopy(catalogue.data[section][name])
        entry = (section, name)
        document.set_origins(entry, {p: where for p, where in catalogue.origins.items() if p[:2] == entry})


def caveats(data: dict[str, Any]) -> tuple[str, ...]:
    """One line per used entry that is not wholly published: ``vehicles.C80: shoe_force_kN fitted; ...``."""
    entries = [(f"{section}.{name}", data[section][name]) for section, name in sorted(used_entries(data))]
    entries.append(("track", data["track"]))
    lines = [(name, _unpublished(entry.get("standing", "published"))) for name, entry in entries]
    return tuple(f"{name}: {what}" for name, what in lines if what)


def _unpublished(standing: str | dict[str, str]) -> str:
    words = {"default": standing} if isinstance(standing, str) else dict(standing)
    default = words.pop("default")
    groups: dict[str, list[str]] = {}
    for key, word in words.items():
        groups.setdefault(word, []).append(key)
    parts = [f"{', '.join(keys)} {word}" for word, keys in groups.items() if word != "published"]
    if default != "published":
        published = f" except {', '.join(groups['published'])}" if "published" in groups else ""
        parts.append(f"{'other values' if parts else 'all values'}{published} {default}")
    return "; ".join(parts)
