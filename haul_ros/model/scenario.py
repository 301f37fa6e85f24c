"""A run, complete: train, line, radio, commands and the numbers of the simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.consist import Consist
from haul_ros.model.driver import DriverPlan
from haul_ros.model.fault import FaultPlan
from haul_ros.model.initial_state import InitialState
from haul_ros.model.radio import RadioLink
from haul_ros.model.recording_plan import RecordingPlan
from haul_ros.model.request import TimedRequest
from haul_ros.model.sensor import CouplerSensors
from haul_ros.model.track import Track


@dataclass(frozen=True)
class Scenario:
    """Everything a simulation needs, in SI units.

    ``radio`` has one link per slave locomotive. ``document`` is the same scenario as
    self-contained YAML text, overrides and catalogue data included: loading it gives an equal
    scenario, so a recording that carries it can be simulated again. ``driver``: who drives beside the timed commands,
    None: nobody. ``faults``: what goes wrong, whoever drives. ``caveats`` are one-line
    statements on fitted or assumed data used.
    """

    name: str
    description: str
    consist: Consist
    brakes: BrakeSystem | PneumaticBrake
    track: Track
    radio: Mapping[str, RadioLink]
    radio_seed: int
    initial_speed: float
    commands: tuple[TimedRequest, ...]
    time_step: float
    sample_rate: float
    max_duration: float
    document: str
    driver: DriverPlan | None = None
    caveats: tuple[str, ...] = ()
    initial_state: InitialState = field(default_factory=InitialState)
    faults: FaultPlan = field(default_factory=FaultPlan)
    recording: RecordingPlan = field(default_factory=RecordingPlan)
    sensors: CouplerSensors | None = None

    @property
    def steps_per_sample(self) -> int:
        """Time steps from one published sample to the next."""
        return round(1.0 / (self.sample_rate * self.time_step))

    @property
    def record_rate(self) -> float:
        """Recorded samples a second of simulation [Hz]."""
        return self.sample_rate / self.recording.every
