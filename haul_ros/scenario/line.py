"""Taking over into a scenario the line that its ``track.file`` names."""

from __future__ import annotations

from pathlib import Path

from haul_ros.resources import shipped_lines
from haul_ros.scenario.document import Document
from haul_ros.scenario.line_csv import read_line_csv
from haul_ros.scenario.schema import LINE, check
from haul_ros.scenario.yaml_file import read_yaml

LINE_KEYS = ("source", "standing", "grade_ramp_m", "grades", "curves", "speed_limits")
"""What a file of a line holds, and ``track`` in its place."""

MOST_CHANGES = 5000
"""Most grades, curves and limits of a line from a file: they all go into the text of the scenario."""

_READERS = {".csv": read_line_csv, ".yaml": read_yaml, ".yml": read_yaml}
_FILE = ("track", "file")


def forget_line(document: Document) -> None:
    """Drop the line that a scenario has, for another one is to take its place."""
    track = document.data.get("track")
    if isinstance(track, dict):
        for key in LINE_KEYS:
            track.pop(key, None)


def take_over_line(document: Document, folder: Path | None) -> None:
    """Write the values of the line that ``track.file`` names, if it names one, into a scenario in its place.

    Files are looked for in ``folder``; without one the scenario has none, and shipped lines alone can be meant.

    Raises
    ------
    ScenarioError
        There is no such line, ``track`` has values beside it, or the file cannot be used.
    """
    track = document.data.get("track")
    if not isinstance(track, dict) or not isinstance(track.get("file"), str):
        return
    if beside := [key for key in LINE_KEYS if key in track]:
        raise document.error(("track",), f"has file and {beside[0]}, expected one of them: a file holds the whole line")
    line = _read(document, track["file"], folder)
    changes = sum(len(line.data.get(key, [])) for key in ("grades", "curves", "speed_limits"))
    if changes > MOST_CHANGES:
        raise document.refusal(
            _FILE, f"a line of {changes} grades, curves and limits, must have at most {MOST_CHANGES}"
        )
    del track["file"]
    track.update(line.data)
    for key in line.data:
        found = {("track", *path): where for path, where in line.origins.items() if path[0] == key}
        document.set_origins(("track", key), found)


def _read(document: Document, name: str, folder: Path | None) -> Document:
    shipped = shipped_lines()
    names = ", ".join(shipped)
    if name not in shipped and folder is None:
        raise document.refusal(_FILE, f"must be one of {names}: this text lies in no folder with files")
    path = shipped[name] if name in shipped else (folder or Path()) / name
    reader = _READERS.get(path.suffix.lower())
    expected = f"expected a file (.csv, .yaml) or one of {names}"
    if reader is None:
        raise document.refusal(_FILE, f"no line, {expected}")
    try:
        line = reader(path)
    except FileNotFoundError as error:
        raise document.refusal(_FILE, f"no such file, {expected}") from error
    except IsADirectoryError as error:
        raise document.refusal(_FILE, f"is a directory, {expected}") from error
    check(line, LINE)
    return line
