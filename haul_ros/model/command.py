"""Commands of the driver, as given at a locomotive."""

from __future__ import annotations

import enum
import sys
from dataclasses import dataclass

from haul_ros.errors import CommandError


class CommandKind(enum.Enum):
    """What a command sets."""

    BRAKE = "brake"
    """Service brake demand, 0 release .. 1 full service."""
    EMERGENCY = "emergency"
    """1: emergency, latched; 0: end it, at standstill only."""
    TRACTION = "traction"
    """Tractive effort [N], cut by any brake demand of the same locomotive."""
    ELECTRIC_BRAKE = "electric_brake"
    """Force of the electric brake [N]; the newer of this and traction counts."""

    @property
    def is_effort(self) -> bool:
        """Whether it is a force [N], not a part of something."""
        return self in (CommandKind.TRACTION, CommandKind.ELECTRIC_BRAKE)


_LARGEST = sys.float_info.max


@dataclass(frozen=True, slots=True)
class Command:
    """One command, addressed to a locomotive by name; value in the unit of its kind."""

    locomotive: str
    kind: CommandKind
    value: float

    def check(self) -> None:
        """Refuse a value that means nothing.

        Raises
        ------
        CommandError
            NaN, infinite or outside the range of the kind.
        """
        if not -_LARGEST <= self.value <= _LARGEST:  # false for NaN too
            raise CommandError(f"{self.locomotive}: {self.kind.value} = {self.value}, must be a finite number")
        if self.kind.is_effort:
            if self.value < 0.0:
                raise CommandError(f"{self.locomotive}: {self.kind.value} = {self.value} N, must be 0 or more")
        elif not 0.0 <= self.value <= 1.0:
            raise CommandError(f"{self.locomotive}: {self.kind.value} = {self.value}, must be 0 (release) to 1 (full)")
