"""What a locomotive's brake valve does to the train, with the empirical brake and with the pneumatic one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.scenario import Scenario
from haul_ros.physics.train_model import TrainModel, WaveKind


@dataclass(slots=True)
class DriverBrake:
    """What a locomotive's brake valve is set to."""

    vehicle: int
    demand: float = 0.0
    emergency: bool = False


class BrakeValves(Protocol):
    """How a setting acts; times [s]."""

    def set_demand(self, time: float, brake: DriverBrake, demand: float) -> None:
        """A demand, 0 released to 1 full service, that follows that of ``brake``."""

    def start_emergency(self, time: float, brake: DriverBrake) -> None:
        """Vent the brake pipe."""

    def end_emergency(self, time: float, brake: DriverBrake, others: bool) -> None:
        """Stop venting it; whether ``others`` go on."""


class WaveValves:
    """Valves of the empirical brake: each new setting starts a brake wave."""

    def __init__(self, model: TrainModel, brakes: BrakeSystem) -> None:
        self._model, self._full_service = model, brakes.full_service

    def set_demand(self, time: float, brake: DriverBrake, demand: float) -> None:
        """See `BrakeValves`."""
        level = demand * self._full_service
        # Given again, a demand acts on what the brake pipe has become at this locomotive meanwhile.
        before = brake.demand if demand != brake.demand else None
        held = self._model.brake_target(brake.vehicle)
        if (demand > before) if before is not None else (level > held):
            self._model.start_wave(time, brake.vehicle, WaveKind.SERVICE, level)
        elif before is not None or level < held:
            self._model.start_wave(time, brake.vehicle, WaveKind.RELEASE, level)

    def start_emergency(self, time: float, brake: DriverBrake) -> None:
        """See `BrakeValves`."""
        self._model.start_wave(time, brake.vehicle, WaveKind.EMERGENCY)

    def end_emergency(self, time: float, brake: DriverBrake, others: bool) -> None:
        """See `BrakeValves`; a brake pipe that is vented anywhere, or open at a parted hose, cannot be charged."""
        if not (others or self._model.hose_parted.any()):
            self._model.start_wave(time, brake.vehicle, WaveKind.EMERGENCY_RELEASE)


class AirValves:
    """Valves of the pneumatic brake: what they do to the pipe is all; they act from the next air step on."""

    def __init__(self, model: TrainModel) -> None:
        self._model = model

    def set_demand(self, time: float, brake: DriverBrake, demand: float) -> None:
        """See `BrakeValves`."""
        self._model.set_brake_valve(brake.vehicle, demand)

    def start_emergency(self, time: float, brake: DriverBrake) -> None:
        """See `BrakeValves`."""
        self._model.set_emergency_valve(brake.vehicle)

    def end_emergency(self, time: float, brake: DriverBrake, others: bool) -> None:
        """See `BrakeValves`: this valve charges; one that still vents takes it out again."""
        self._model.set_brake_valve(brake.vehicle, 0.0)


def brake_valves(model: TrainModel, scenario: Scenario) -> BrakeValves:
    """The valves that a scenario's brake has."""
    return WaveValves(model, scenario.brakes) if isinstance(scenario.brakes, BrakeSystem) else AirValves(model)
