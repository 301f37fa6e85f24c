"""Faults of a run: what is asked for or planned is done to the train, and what gives way is told."""

from __future__ import annotations

import math
from collections import deque

from haul_ros.errors import CommandError
from haul_ros.model.event import Event, EventKind
from haul_ros.model.fault import Fault, FaultKind, FaultPlan
from haul_ros.model.log import LogEntry
from haul_ros.model.request import TimedRequest
from haul_ros.physics.parting import Parting, PartingKind
from haul_ros.physics.train_model import TrainModel
from haul_ros.units import seconds_to_ns

_IN_WORDS = {
    FaultKind.PART_HOSE: "brake hose parted",
    FaultKind.CLOSE_ANGLE_COCK: "angle cock closed",
    FaultKind.OPEN_ANGLE_COCK: "angle cock opened",
    FaultKind.CUT_OUT_VALVE: "control valve cut out",
    FaultKind.CUT_IN_VALVE: "control valve cut in",
}


class Faults:
    """Carries faults out; requests and events are handed to ``log``.

    ``plan`` has those by chainage, which happen in the time step that brings the head there; None: nothing is planned.
    """

    def __init__(self, model: TrainModel, plan: FaultPlan, log: list[LogEntry]) -> None:
        self._model = model
        self._log = log
        ahead = [(p.chainage, p.fault) for p in plan.planned if p.chainage is not None]
        self._ahead = deque(sorted(ahead, key=lambda entry: entry[0]))
        if plan.leakage > 0.0:
            model.set_leakage(plan.leakage)

    @property
    def waiting(self) -> bool:
        """Whether any is to come when the head has come to its chainage."""
        return bool(self._ahead)

    @property
    def next_chainage(self) -> float:
        """Where the next of those is to happen [m]; infinite: none is."""
        return self._ahead[0][0] if self._ahead else math.inf

    def look(self, head: float) -> list[Fault]:
        """Those that are due with the head at a chainage [m]."""
        due = []
        while self._ahead and self._ahead[0][0] <= head:
            due.append(self._ahead.popleft()[1])
        return due

    def carry_out(self, fault: Fault) -> None:
        """Let a fault happen now.

        Raises
        ------
        CommandError
            The train has no such place, or its brake no such thing; nothing has changed then.
        """
        name = self._check(fault)
        self._log.append(TimedRequest(self._now, fault))
        place, model = fault.number - 1, self._model
        match fault.kind:
            case FaultKind.UNCOUPLE:
                model.uncouple(place)
                self.tell_partings()
                return
            case FaultKind.PART_HOSE:
                model.part_hose(place)
            case FaultKind.CLOSE_ANGLE_COCK | FaultKind.OPEN_ANGLE_COCK:
                model.set_cock(place, is_open=fault.kind is FaultKind.OPEN_ANGLE_COCK)
            case FaultKind.LEAK:
                model.set_leak(place, fault.bore)
            case FaultKind.CUT_OUT_VALVE | FaultKind.CUT_IN_VALVE:
                model.cut_out_valve(place, cut_out=fault.kind is FaultKind.CUT_OUT_VALVE)
        leak = f"leak of {fault.bore * 1e3:g} mm in the brake pipe" if fault.bore else "leak in the brake pipe closed"
        self._log.append(Event(self._now, EventKind.FAULT, f"{name}: {_IN_WORDS.get(fault.kind, leak)}"))

    def tell_partings(self) -> None:
        """Log the couplers and hoses that have given way since the last call."""
        names = self._model.consist.coupler_names
        for parting in self._model.take_partings():
            text = f"{names[parting.coupler]}: {_what(parting)}"
            self._log.append(Event(seconds_to_ns(parting.time), EventKind.SEPARATION, text))

    @property
    def _now(self) -> int:
        return seconds_to_ns(self._model.time)

    def _check(self, fault: Fault) -> str:
        """The name of the place."""
        fault.check()
        consist, kind = self._model.consist, fault.kind
        if kind.of_air and self._model.pneumatic is None:
            raise CommandError(f"{kind.value}: needs a pneumatic brake")
        names = consist.vehicle_names if kind.of_vehicle else consist.coupler_names
        if fault.number > len(names):
            what = "vehicle" if kind.of_vehicle else "coupler"
            raise CommandError(f"{kind.value}: {what} {fault.number}, this train has 1 to {len(names)}")
        if kind is FaultKind.UNCOUPLE and consist.couplers[fault.number - 1] is None:
            raise CommandError(f"{kind.value}: {names[fault.number - 1]} is a rigid drawbar, it cannot be uncoupled")
        return names[fault.number - 1]


def _what(parting: Parting) -> str:
    if parting.kind is PartingKind.HOSE:
        return f"hose parted at a gap of {parting.gap:.2f} m"
    return f"{parting.kind.value} under {abs(parting.tension) / 1e3:.1f} kN of {_side(parting.tension)}"


def _side(tension: float) -> str:
    return "draft" if tension >= 0.0 else "buff"
