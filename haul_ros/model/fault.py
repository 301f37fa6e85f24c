"""Faults of a train: of its brake pipe, its control valves and its couplers."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from haul_ros.errors import CommandError

LARGEST_NUMBER = 2000
"""Of a vehicle, as in a scenario."""
LARGEST_LEAK = 0.05
"""Bore [m]; more than any brake pipe."""
HOSE_REACH = 0.3
"""Gap of a parted coupler at which its hose parts [m], if nothing else is said; assumed."""


class FaultKind(enum.Enum):
    """What goes wrong, or is mended; the place is a coupler, of leaks and control valves a vehicle."""

    PART_HOSE = "part_hose"
    """The brake hose parts: both ends of the pipe are open to the atmosphere where the angle cocks are."""
    CLOSE_ANGLE_COCK = "close_angle_cock"
    """The pipe is closed between two vehicles, at both of them."""
    OPEN_ANGLE_COCK = "open_angle_cock"
    """It is open again."""
    LEAK = "leak"
    """The pipe of a vehicle has a hole of the bore ``Fault.bore``; 0: none any more."""
    CUT_OUT_VALVE = "cut_out_valve"
    """The control valve is cut out from the pipe, its cylinder empties."""
    CUT_IN_VALVE = "cut_in_valve"
    """It is cut in again."""
    UNCOUPLE = "uncouple"
    """The coupler is opened, whatever it bears; its hose parts when the gap is wide enough."""

    @property
    def of_vehicle(self) -> bool:
        """Whether the place is a vehicle."""
        return self in (FaultKind.LEAK, FaultKind.CUT_OUT_VALVE, FaultKind.CUT_IN_VALVE)

    @property
    def of_air(self) -> bool:
        """Whether there is such a thing with a pneumatic brake only."""
        return self is not FaultKind.UNCOUPLE


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault: ``number`` is that in the name of the coupler or vehicle, 1 at the head; ``bore`` [m] of a leak."""

    kind: FaultKind
    number: int
    bore: float = 0.0

    def check(self) -> None:
        """Refuse what no train can have.

        Raises
        ------
        CommandError
            No such number, or no such leak.
        """
        if not 1 <= self.number <= LARGEST_NUMBER:
            what = "vehicle" if self.kind.of_vehicle else "coupler"
            raise CommandError(f"{self.kind.value}: {what} {self.number}, must be a number from 1 at the head")
        if not 0.0 <= self.bore <= LARGEST_LEAK:  # NaN too
            raise CommandError(f"{self.kind.value}: bore {self.bore} m, must be 0 to {LARGEST_LEAK:g}")


@dataclass(frozen=True, slots=True)
class PlannedFault:
    """A fault of a scenario: at a time [ns], or when the head has come to a chainage [m]; the other one is None."""

    fault: Fault
    time_ns: int | None = None
    chainage: float | None = None


@dataclass(frozen=True, slots=True)
class FaultPlan:
    """What goes wrong in a scenario.

    ``leakage`` [Pa/s]: by which the charged pipe would fall if nothing fed it, leaking everywhere; ``hose_reach`` [m]:
    gap of a parted coupler at which its hose parts.
    """

    leakage: float = 0.0
    hose_reach: float = HOSE_REACH
    planned: tuple[PlannedFault, ...] = ()
