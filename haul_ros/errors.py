"""Errors that a user can cause, each with a message of one line: what, where, what is expected."""

from __future__ import annotations


class HaulError(Exception):
    """Base of every error that is the user's to mend; programs print it and exit with status 2."""


class ScenarioError(HaulError):
    """A scenario, catalogue or track file that cannot be used."""


class CommandError(HaulError):
    """A command, or a change of a radio link, that cannot be carried out; it changes nothing."""


class RecordingError(HaulError):
    """A recording that cannot be written, or a file that cannot be read as one."""
