"""Errors that a user can cause, each with a message of one line: what, where, what is expected."""

from __future__ import annotations

_LONGEST_LINE = 1000


def one_line(text: str, longest: int = _LONGEST_LINE) -> str:
    """A text that may come from a file or from anyone, to be shown: control characters escaped, shortened if long."""
    shown = text if len(text) <= longest else f"{text[: longest * 4 // 5]} ... {text[-longest * 3 // 20 :]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in shown)


class HaulError(Exception):
    """Base of every error that is the user's to mend; programs print it and exit with status 2."""

    def __str__(self) -> str:
        return one_line(super().__str__())


class ScenarioError(HaulError):
    """A scenario, catalogue or track file that cannot be used."""


class CommandError(HaulError):
    """A command, or a change of a radio link, that cannot be carried out; it changes nothing."""


class RecordingError(HaulError):
    """A recording that cannot be written, or a file that cannot be read as one."""
