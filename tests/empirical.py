"""The empirical brake of a scenario that has one."""

from __future__ import annotations

from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.scenario import Scenario


def wave_brakes(scenario: Scenario) -> BrakeSystem:
    assert isinstance(scenario.brakes, BrakeSystem)
    return scenario.brakes
