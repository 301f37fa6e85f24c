"""How facts are laid out on a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from haul_ros.model.recording_plan import UNITS

_NAME_WIDTH = 18
_STANDINGS = ("fitted", "assumed", "overridden")


def rows(entries: Iterable[tuple[str, str]]) -> list[str]:
    """Lines of a name and a value, the values one below the other."""
    return [f"  {name:{_NAME_WIDTH}} {value}" for name, value in entries]


def caveat_entries(caveats: Iterable[str]) -> list[tuple[str, str]]:
    """Which catalogue entries hold values that were not published; JSON has every value."""
    entries = [caveat.partition(": ") for caveat in caveats]
    by_standing = {
        word: list(dict.fromkeys(entry for entry, _, values in entries if word in values)) for word in _STANDINGS
    }
    return [(f"{word} values in", ", ".join(found)) for word, found in by_standing.items() if found]


def file_size(size: int) -> str:
    """A number of bytes with the fitting unit."""
    return f"{size / 1e6:.1f} MB" if size >= 1_000_000 else f"{size / 1e3:.1f} kB"


def resolutions(rounding: Mapping[str, float]) -> str:
    """To what the quantities of samples are rounded."""
    return ", ".join(f"{name.replace('_', ' ')} to {value:.6g} {UNITS[name]}" for name, value in rounding.items())


def lost_bytes(count: int, damage: str) -> str:
    """What is lost behind the last good byte of a file, and why; one cut off right there loses none that it has."""
    return f"the last {count} bytes: {damage}" if count else damage
