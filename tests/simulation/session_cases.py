"""A small train with slaves, and what tests of its sessions do with it."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.log import AppliedBrake
from haul_ros.model.radio import RadioLink
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import FloatArray, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.scenario.loader import load_scenario
from haul_ros.simulation.session import Session
from haul_ros.units import seconds_to_ns
from tests.empirical import wave_brakes
from tests.simulation.log_entries import of_kind

# Locomotive + 10 wagons + 2 locomotives + 10 wagons + locomotive, service waves 200 m/s, release 150, emergency 220.
# Their tractive effort is there within a step.
SMALL = load_scenario(
    "daqin_1_2_1", {"consist.1.count": 10, "consist.3.count": 10, "vehicles.SS4.effort_rise_time_s": 1e-9}
)
SLAVES = ("slave_1", "slave_2", "slave_3")
FULL_SERVICE = wave_brakes(SMALL).full_service
DOWN = RadioLink(connected=False)


def brake(demand: float, locomotive: str = "master") -> Command:
    return Command(locomotive, CommandKind.BRAKE, demand)


def emergency(value: float = 1.0, locomotive: str = "master") -> Command:
    return Command(locomotive, CommandKind.EMERGENCY, value)


def traction(force: float, locomotive: str = "master") -> Command:
    return Command(locomotive, CommandKind.TRACTION, force)


def scenario(*plan: tuple[float, Command], base: Scenario = SMALL, **changes: object) -> Scenario:
    timed = tuple(TimedRequest(seconds_to_ns(time), command) for time, command in plan)
    return replace(base, commands=timed, **changes)  # type: ignore[arg-type]


def links(**changes: RadioLink) -> dict[str, RadioLink]:
    return {slave: changes.get(slave, RadioLink()) for slave in SLAVES}


def fractions(session: Session) -> FloatArray:
    """Cylinder pressures over those in emergency."""
    full = np.array([v.cylinder_pressure for v in session.consist.vehicles])
    return np.asarray(session.sample().cylinder_pressure / full)


def assert_same(one: Sample, other: Sample) -> None:
    for field in fields(Sample):
        np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name), err_msg=field.name)


def run_to_rest(session: Session) -> Session:
    while not session.finished:
        session.advance()
    return session


def applied_times(session: Session) -> dict[str, float]:
    """When each locomotive last changed what it applies [s]."""
    return {entry.locomotive: entry.time_ns / 1e9 for entry in of_kind(AppliedBrake, session.take_log())}


JITTERY = {slave: RadioLink(delay=0.3, jitter=0.5, loss_probability=0.2) for slave in SLAVES}
PLAN = (
    (0.0, brake(0.2)),
    (0.5013, brake(0.6, "slave_2")),
    (1.7, brake(0.35)),
    (2.0, brake(0.0, "slave_1")),
    (2.2, traction(200e3, "slave_1")),
    (3.0, emergency()),
)


# -- repeatability ---------------------------------------------------------------------------------------------------
