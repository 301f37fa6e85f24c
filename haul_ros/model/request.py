"""What can be asked of a run: commands of the driver, changes of radio links and faults, one type for all ways in."""

from __future__ import annotations

from dataclasses import dataclass

from haul_ros.model.command import Command
from haul_ros.model.fault import Fault
from haul_ros.model.radio import RadioLinkChange

Request = Command | RadioLinkChange | Fault


@dataclass(frozen=True, slots=True)
class TimedRequest:
    """A request and its simulation time [ns]: when it is to be carried out, or when it was."""

    time_ns: int
    request: Request
