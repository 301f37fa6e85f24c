"""Longitudinal dynamics of heavy-haul trains in real time, for ROS 2.

What stands in ``__all__`` is the public face and stays; everything else may move between versions.

    import haul_ros

    session = haul_ros.Session(haul_ros.load_scenario("daqin_1_2_1"), play_commands=True)
    while not session.finished:
        sample = session.advance()
    print(haul_ros.summarize_session(session).compression)

Each name is imported where it is first used: ``import haul_ros`` alone takes no time.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from haul_ros.version import __version__

if TYPE_CHECKING:
    from haul_ros.analysis.numbers import Numbers, Window, numbers_of
    from haul_ros.analysis.recorded import summarize_recording
    from haul_ros.analysis.scenarios import scenario_of
    from haul_ros.analysis.summary import RunSummary, summarize_session
    from haul_ros.errors import HaulError
    from haul_ros.messages.encoder import TelemetryEncoder
    from haul_ros.model.command import Command, CommandKind
    from haul_ros.model.log import PeriodLog
    from haul_ros.model.radio import RadioLinkChange
    from haul_ros.model.sample import CouplerExtremes, Sample
    from haul_ros.model.scenario import Scenario
    from haul_ros.recording.reader import Recording
    from haul_ros.recording.trains import open_train
    from haul_ros.recording.writer import McapRecorder
    from haul_ros.scenario import load_scenario, load_scenario_text
    from haul_ros.simulation.session import Session

__all__ = [
    "Command",
    "CommandKind",
    "CouplerExtremes",
    "HaulError",
    "McapRecorder",
    "Numbers",
    "PeriodLog",
    "RadioLinkChange",
    "Recording",
    "RunSummary",
    "Sample",
    "Scenario",
    "Session",
    "TelemetryEncoder",
    "Window",
    "__version__",
    "load_scenario",
    "load_scenario_text",
    "numbers_of",
    "open_train",
    "scenario_of",
    "summarize_recording",
    "summarize_session",
]

_MODULES = {
    "haul_ros.analysis.numbers": ("Numbers", "Window", "numbers_of"),
    "haul_ros.analysis.scenarios": ("scenario_of",),
    "haul_ros.analysis.recorded": ("summarize_recording",),
    "haul_ros.analysis.summary": ("RunSummary", "summarize_session"),
    "haul_ros.errors": ("HaulError",),
    "haul_ros.messages.encoder": ("TelemetryEncoder",),
    "haul_ros.model.command": ("Command", "CommandKind"),
    "haul_ros.model.log": ("PeriodLog",),
    "haul_ros.model.radio": ("RadioLinkChange",),
    "haul_ros.model.sample": ("CouplerExtremes", "Sample"),
    "haul_ros.model.scenario": ("Scenario",),
    "haul_ros.recording.reader": ("Recording",),
    "haul_ros.recording.trains": ("open_train",),
    "haul_ros.recording.writer": ("McapRecorder",),
    "haul_ros.scenario": ("load_scenario", "load_scenario_text"),
    "haul_ros.simulation.session": ("Session",),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(_HOME[name]), name)
    globals()[name] = found  # the next use takes no detour
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
