"""A scenario as data that knows where each value was written."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from haul_ros.errors import ScenarioError

KeyPath = tuple[str | int, ...]
"""Keys and list indexes from the top of a document."""


def dotted(path: KeyPath) -> str:
    """The path as users write it: ``consist.1.count``."""
    return ".".join(str(part) for part in path)


def _shown(path: KeyPath) -> str:
    """The same for messages, each key in a few characters."""
    return ".".join(part if len(part) <= 40 else f"{part[:36]} ..." for part in map(str, path))


def show(value: object) -> str:
    """A value in a few characters, for messages."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return "a list"
    if isinstance(value, int) and abs(value) >= 10**36:
        return "a number of more than 36 digits"  # of which Python does not print all
    text = repr(value[:41]) if isinstance(value, str) else str(value)
    return text if len(text) <= 40 else text[:36] + " ..."


@dataclass
class Document:
    """Nested dicts, lists and scalars, and for each key path the place it came from.

    ``label`` names the whole (a file); ``origins`` holds ``file:line`` per key path, also of parts
    taken over from the catalogue or given as overrides.
    """

    label: str
    data: Any
    origins: dict[KeyPath, str] = field(default_factory=dict)

    def at(self, path: KeyPath) -> Any:
        """The value at an existing path."""
        value = self.data
        for part in path:
            value = value[part]
        return value

    def origin(self, path: KeyPath) -> str:
        """Where the value at the path, or the nearest thing around it, was written."""
        for length in range(len(path), -1, -1):
            if path[:length] in self.origins:
                return self.origins[path[:length]]
        return self.label

    def set_origins(self, path: KeyPath, origins: dict[KeyPath, str]) -> None:
        """Replace what is known about the path and all below it."""
        inside = [known for known in self.origins if known[: len(path)] == path]
        for known in inside:
            del self.origins[known]
        self.origins.update(origins)

    def error(self, path: KeyPath, problem: str) -> ScenarioError:
        """The error to raise: ``my.yaml:12: vehicles.C80: problem``."""
        where = f"{self.origin(path)}: {_shown(path)}" if path else self.origin(path)
        return ScenarioError(f"{where}: {problem}")

    def refusal(self, path: KeyPath, expected: str) -> ScenarioError:
        """The error to raise: ``my.yaml:12: vehicles.C80.mass_t = -84, expected``."""
        return ScenarioError(f"{self.origin(path)}: {_shown(path)} = {show(self.at(path))}, {expected}")
