"""The driver of a scenario: what he does at which speed, and that a run with him is repeated from its commands."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.driver import CyclicBraking, DriverPlan
from haul_ros.model.log import AppliedBrake
from haul_ros.model.request import TimedRequest
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario, load_scenario_text
from haul_ros.simulation.driver import Driver
from haul_ros.simulation.session import Session
from tests.simulation.log_entries import of_kind

CYCLIC = CyclicBraking(18.0, 12.0, 0.1, 100.0, 22.0)
PLAN = DriverPlan(speed=15.0, traction=200e3, electric_brake=300e3, band=2.0, reaction_time=1.0)

TRAIN = """\
consist:
  - {vehicle: HXD1, role: master}
  - {vehicle: C80, count: 20}
  - {vehicle: HXD1, role: slave}
coupler: paper_set_b
brakes: pneumatic
initial_speed_kmh: 50
max_duration_s: 400
radio: {default: {delay_s: 1.0}}
"""


def scenario(**overrides: Any) -> Scenario:
    return load_scenario_text(TRAIN, "train", overrides)


def kinds(commands: list[Command]) -> list[tuple[CommandKind, float]]:
    return [(command.kind, command.value) for command in commands]


def test_below_his_speed_he_pulls_above_it_he_brakes_electrically_and_changes_over_in_order() -> None:
    driver = Driver(PLAN)
    assert kinds(driver.look(0.0, 10.0)) == [(CommandKind.TRACTION, 200e3)]
    assert driver.look(1.0, 10.5) == []
    assert kinds(driver.look(2.0, 14.0)) == [(CommandKind.TRACTION, 100e3)]
    assert kinds(driver.look(3.0, 16.0)) == [(CommandKind.TRACTION, 0.0), (CommandKind.ELECTRIC_BRAKE, 150e3)]
    assert kinds(driver.look(4.0, 15.0)) == [(CommandKind.ELECTRIC_BRAKE, 0.0)]
    assert driver.look(5.0, 15.01) == []


def test_on_a_descent_he_brakes_between_two_speeds_and_lets_the_reservoirs_recharge() -> None:
    driver = Driver(DriverPlan(15.0, 0.0, 0.0, 2.0, 1.0, CYCLIC))
    assert driver.look(0.0, 17.9) == []
    assert kinds(driver.look(1.0, 18.1)) == [(CommandKind.BRAKE, 0.1)]
    assert driver.look(2.0, 19.0) == []
    assert kinds(driver.look(60.0, 11.9)) == [(CommandKind.BRAKE, 0.0)]
    assert driver.look(159.0, 18.5) == []  # 99 s
    assert kinds(driver.look(160.0, 18.5)) == [(CommandKind.BRAKE, 0.1)]


def test_too_fast_he_waits_for_nothing() -> None:
    driver = Driver(DriverPlan(15.0, 0.0, 0.0, 2.0, 1.0, CYCLIC))
    driver.look(0.0, 18.1)
    driver.look(50.0, 11.0)
    assert kinds(driver.look(60.0, 22.1)) == [(CommandKind.BRAKE, 1.0)]
    assert driver.look(70.0, 18.5) == []
    assert kinds(driver.look(90.0, 11.0)) == [(CommandKind.BRAKE, 0.0)]


def test_he_does_not_pull_against_his_own_brake() -> None:
    driver = Driver(DriverPlan(15.0, 200e3, 0.0, 2.0, 1.0, CYCLIC))
    driver.look(0.0, 18.1)
    assert driver.look(10.0, 12.5) == []
    assert kinds(driver.look(20.0, 11.9)) == [(CommandKind.BRAKE, 0.0)]
    assert kinds(driver.look(21.0, 11.9)) == [(CommandKind.TRACTION, 200e3)]


def test_he_holds_a_speed_up_a_grade_and_down_another() -> None:
    for grade, sense in ((3.0, 1.0), (-6.0, -1.0)):
        session = Session(
            scenario(
                **{
                    "track.grades": [{"from_m": -1e5, "grade_permille": grade}],
                    "driver": {"speed_kmh": 50, "traction_kN": 300, "electric_brake_kN": 300},
                }
            ),
            play_commands=True,
        )
        session.advance(200_000)
        assert abs(session.sample().speed[0] * 3.6 - 50.0) < 5.0
        assert (session._model.efforts[[0, 21]] * sense > 20e3).all()
        assert abs(session.energy().relative_imbalance) < 1e-9


def test_a_run_with_a_driver_is_repeated_from_the_commands_that_were_recorded() -> None:
    driven = scenario(
        **{
            "track.grades": [{"from_m": -1e5, "grade_permille": -10}],
            "driver": {
                "speed_kmh": 30,
                "electric_brake_kN": 20,
                "cyclic": {"apply_above_kmh": 55, "release_below_kmh": 45, "full_service_above_kmh": 75},
            },
        }
    )
    samples, requests = [], None
    for steps in (20, 333, 100_000):
        session = Session(driven, play_commands=True)
        while session.step < 100_000:
            session.advance(min(steps, 100_000 - session.step))
        samples.append(session.sample())
        log = session.take_log().entries
        requests = [entry for entry in log if isinstance(entry, TimedRequest) and isinstance(entry.request, Command)]
    assert requests
    assert any(entry.request.kind is CommandKind.BRAKE for entry in requests if isinstance(entry.request, Command))
    again = Session(driven, requests=requests)
    again.advance(100_000)
    samples.append(again.sample())
    for sample in samples[1:]:
        assert sample.coupler_force.tobytes() == samples[0].coupler_force.tobytes()
        assert sample.speed.tobytes() == samples[0].speed.tobytes()


def test_without_playing_commands_nobody_drives() -> None:
    session = Session(scenario(driver={"speed_kmh": 80, "traction_kN": 300}))
    session.advance(5000)
    assert (session._model.efforts == 0.0).all()


@pytest.mark.parametrize(
    ("driver", "expected"),
    [
        ({"speed_kmh": 50, "electric_brake_kN": 500}, "electric_brake_kN = 500, must be at most 461"),
        ({"traction_kN": 100}, "speed_kmh is missing"),
        (
            {
                "speed_kmh": 50,
                "cyclic": {"apply_above_kmh": 60, "release_below_kmh": 65, "full_service_above_kmh": 70},
            },
            "apply_above_kmh = 60, must lie between release_below_kmh and full_service_above_kmh",
        ),
    ],
)
def test_a_driver_that_cannot_be_is_refused(driver: dict[str, object], expected: str) -> None:
    with pytest.raises(ScenarioError, match=expected):
        scenario(driver=driver)


@pytest.mark.slow
@pytest.mark.parametrize(("delay", "peak"), [(0.0, 645e3), (2.0, 737e3), (4.0, 833e3)])
def test_cyclic_braking_on_10_per_mille_has_the_period_and_peak_of_another_model(delay: float, peak: float) -> None:
    """1+1 of two 200 t locomotives, 600 kPa, 50 kPa from 68 to 42 km/h, 400 kN of electric brake each: 293 s."""
    descent = load_scenario(
        "daqin_1_1_0",
        {
            "consist.0.vehicle": "HXD1",
            "consist.2.vehicle": "HXD1",
            "brakes": "pneumatic_600",
            "coupler": "paper_set_a",
            "initial_speed_kmh": 60,
            "commands": [],
            "time_step_ms": 4,
            "sample_rate_hz": 5,
            "radio.default.delay_s": delay,
            "track.grades": [{"from_m": -1e5, "grade_permille": -10}],
            "driver": {
                "speed_kmh": 30,
                "electric_brake_kN": 400,
                "cyclic": {"apply_above_kmh": 68, "release_below_kmh": 42, "full_service_above_kmh": 80},
            },
        },
    )
    session = Session(descent, play_commands=True)
    session.advance(500_000)
    log = session.take_log().entries
    applied = [
        entry.time_ns / 1e9
        for entry in log
        if isinstance(entry, AppliedBrake) and entry.locomotive == "master" and entry.value > 0.0
    ]
    periods = [later - earlier for earlier, later in pairwise(applied)]
    if delay == 2.0:  # the other model's period is of that delay; it is 5 % shorter here
        assert np.mean(periods[1:]) == pytest.approx(293.0, rel=0.06)
    assert session.extremes().compression.max() == pytest.approx(peak, rel=0.05)
    assert abs(session.energy().relative_imbalance) < 1e-9


@pytest.mark.parametrize("limits", [[], [{"from_m": -1000, "limit_kmh": 80}]])
@pytest.mark.parametrize(
    "cyclic", [None, {"apply_above_kmh": 60, "release_below_kmh": 40, "full_service_above_kmh": 70}]
)
def test_he_releases_a_brake_that_he_finds_applied_and_then_pulls(
    limits: list[dict[str, float]], cyclic: dict[str, float] | None
) -> None:
    braked = {"brake_pipe_kPa": 430, "auxiliary_reservoir_kPa": 430, "cylinder_kPa": 150}
    driver = {"speed_kmh": 50, "traction_kN": 400} | ({"cyclic": cyclic} if cyclic else {})
    changes = {"initial_state": braked, "initial_speed_kmh": 0, "driver": driver, "track": {"speed_limits": limits}}
    session = Session(scenario(**changes), play_commands=True)
    session.advance(100_000)
    applied = [entry.value for entry in of_kind(AppliedBrake, session.take_log()) if entry.locomotive == "master"]
    assert applied[0] > 0.0
    assert applied[-1] == 0.0
    assert session.sample().speed[0] * 3.6 == pytest.approx(50.0, abs=10.0)
