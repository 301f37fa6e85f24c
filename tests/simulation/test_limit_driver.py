"""A driver on a line with speed limits: he keeps them for the whole train, by brakes that take time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import PeriodLog
from haul_ros.model.request import TimedRequest
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario, load_scenario_text
from haul_ros.simulation.batch import periods
from haul_ros.simulation.limit_driver import LimitDriver
from haul_ros.simulation.route import COMFORTABLE, Route
from haul_ros.simulation.session import Session
from tests.simulation.log_entries import of_kind

TRAIN = """\
consist:
  - {vehicle: HXD1, role: master}
  - {vehicle: C80, count: 20}
  - {vehicle: HXD1, role: slave}
coupler: paper_set_b
brakes: pneumatic
initial_speed_kmh: 70
time_step_ms: 4
sample_rate_hz: 5
max_duration_s: 600
radio: {default: {delay_s: 1.0}}
"""
LENGTH = 2 * 35.22 + 20 * 12.0
HOLD = {"speed_kmh": 75, "traction_kN": 150, "electric_brake_kN": 50}
CYCLIC = HOLD | {
    "speed_kmh": 60,
    "cyclic": {"apply_above_kmh": 68, "release_below_kmh": 45, "full_service_above_kmh": 78, "recharge_s": 60},
}


def scenario(*limits: tuple[float, float], grade: float = 0.0, **overrides: Any) -> Scenario:
    values = {key.replace("__", "."): value for key, value in overrides.items()}
    values["track.speed_limits"] = [{"from_m": start, "limit_kmh": limit} for start, limit in limits]
    values["track.grades"] = [{"from_m": -10_000, "grade_permille": grade}]
    return load_scenario_text(TRAIN, "train", values)


def run(case: Scenario) -> tuple[Session, list[PeriodLog]]:
    session = Session(case, play_commands=True)
    return session, list(periods(session))


def events(logs: list[PeriodLog], kind: EventKind) -> list[str]:
    return [event.text for event in of_kind(Event, *logs) if event.kind is kind]


def commands(logs: list[PeriodLog]) -> list[tuple[int, Command]]:
    entries = of_kind(TimedRequest, *logs)
    return [(entry.time_ns, entry.request) for entry in entries if isinstance(entry.request, Command)]


def brakes_asked(logs: list[PeriodLog]) -> list[float]:
    return [command.value for _, command in commands(logs) if command.kind is CommandKind.BRAKE]


def speeds_by_front(logs: list[PeriodLog]) -> tuple[np.ndarray, np.ndarray]:
    samples = [log.sample for log in logs if log.sample is not None]
    return (
        np.array([sample.chainage[0] + 35.22 / 2 for sample in samples]),
        np.array([sample.speed[0] * 3.6 for sample in samples]),
    )


@pytest.mark.parametrize(
    ("brakes", "driver", "grade"),
    [
        ("pneumatic", CYCLIC, -11.0),
        ("paper_set_b", HOLD, 3.0),
        *(
            pytest.param(brakes, driver, grade, marks=pytest.mark.slow)
            for brakes in ("pneumatic", "pneumatic_uic", "paper_set_b")
            for driver in (HOLD, CYCLIC)
            for grade in (-11.0, 0.0, 3.0)
            if (brakes, driver, grade) not in (("pneumatic", CYCLIC, -11.0), ("paper_set_b", HOLD, 3.0))
        ),
    ],
)
def test_limits_down_and_up_are_kept_by_every_part_of_the_train(
    brakes: str, driver: dict[str, Any], grade: float
) -> None:
    limits = ((-10_000, 80), (2500, 60), (4000, 40), (5000, 80))
    if brakes == "paper_set_b" and "cyclic" in driver:  # 0.01 is nothing to the empirical brake
        driver = driver | {"cyclic": driver["cyclic"] | {"demand": 0.3}}
    session, logs = run(scenario(*limits, grade=grade, brakes=brakes, driver=driver, max_duration_s=900))
    assert session.overspeeds().count == 0, session.overspeeds().worst
    front, speed = speeds_by_front(logs)
    assert front[-1] > 5000.0 + LENGTH
    # He makes use of the line: no slower than his margin and, on a descent, what the recharge of his brakes takes.
    assert speed[(front > 4000.0) & (front < 5000.0 + LENGTH)].max() > (28.0 if grade < 0.0 else 31.0)
    # Only when the tail is past
    after = np.interp([5000.0 + LENGTH], front, speed)[0]
    assert after < 40.0
    assert speed[front > 5000.0 + LENGTH].max() > 45.0
    assert not events(logs, EventKind.VALVE)
    assert abs(session.energy().relative_imbalance) < 1e-9


def test_a_limit_shorter_than_the_train_holds_until_its_tail_has_passed() -> None:
    session, logs = run(scenario((-10_000, 80), (3000, 45), (3060, 80), driver=HOLD, max_duration_s=500))
    assert session.overspeeds().count == 0
    front, speed = speeds_by_front(logs)
    assert np.interp([3000.0, 3060.0 + LENGTH], front, speed) == pytest.approx([42.0, 40.0], abs=3.0)
    assert speed[-1] > 60.0


def test_over_the_limit_at_the_start_he_takes_full_service_at_once() -> None:
    session, logs = run(scenario((-10_000, 50), driver=HOLD, max_duration_s=200))
    first_ns, _ = commands(logs)[0]
    assert first_ns == 0
    assert brakes_asked(logs)[0] == 1.0
    assert session.overspeeds().count == 1
    _, speed = speeds_by_front(logs)
    # 0.4 m/s^2 and more once the brake is there, some 5 s: 5.6 m/s have to go.
    assert (speed[100:] < 50.0).all()


def test_a_limit_that_comes_too_soon_is_met_as_fast_as_full_service_can() -> None:
    """From 70 to 20 km/h on 350 m: 0.50 m/s^2, more than full service gives after the time it takes to act."""
    session, logs = run(scenario((-10_000, 80), (350, 20), driver=HOLD, max_duration_s=200))
    assert brakes_asked(logs)[0] == 1.0
    assert session.overspeeds().count == 1
    _, speed = speeds_by_front(logs)
    assert (speed[200:] < 20.1).all()


def test_on_a_level_line_he_approaches_a_limit_in_comfort_and_without_the_air_brake() -> None:
    driver = HOLD | {"electric_brake_kN": 200}
    session, logs = run(scenario((-10_000, 80), (5000, 50), driver=driver, max_duration_s=400))
    assert session.overspeeds().count == 0
    assert not brakes_asked(logs)
    front, speed = speeds_by_front(logs)
    assert np.interp([5000.0], front, speed)[0] == pytest.approx(45.0, abs=3.0)


def test_he_does_not_pull_where_the_train_gains_speed_by_itself_and_pulls_where_it_loses() -> None:
    for grade, pulls in ((-6.0, False), (4.0, True)):
        driver = LimitDriver(
            scenario((-10_000, 80), grade=grade, driver=HOLD).driver,  # type: ignore[arg-type]
            Route(scenario((-10_000, 80), grade=grade)),
        )
        asked = [command.kind for command in driver.look(0.0, 10.0, 0.0)]
        assert (CommandKind.TRACTION in asked) is pulls


def test_his_commands_are_recorded_and_repeat_the_run_bit_for_bit() -> None:
    case = scenario((-10_000, 80), (1500, 40), grade=-8.0, driver=CYCLIC, max_duration_s=250)
    session, logs = run(case)
    requests = [entry for entry in of_kind(TimedRequest, *logs) if isinstance(entry.request, Command)]
    assert brakes_asked(logs)
    again = Session(case, requests=requests)
    again.advance(session.step)
    assert again.sample().coupler_force.tobytes() == session.sample().coupler_force.tobytes()
    in_pieces = Session(case, play_commands=True)
    while in_pieces.step < session.step:
        in_pieces.advance(min(777, session.step - in_pieces.step))
    assert in_pieces.sample().coupler_force.tobytes() == session.sample().coupler_force.tobytes()


# -- what he knows -------------------------------------------------------------------------------------


def test_the_train_left_alone_does_what_he_expects_of_it() -> None:
    """Against the accelerations of the vehicles themselves, on the shipped line: they have ramps, he has none."""
    for start in (12_000.0, 20_500.0, 33_600.0, 47_200.0, 62_000.0):
        case = load_scenario("daqin_descent", {"track.start_chainage_m": start, "initial_speed_kmh": 50})
        session = Session(case)
        mass = np.array([vehicle.mass for vehicle in case.consist.vehicles])
        actual = np.sum(mass * session._model.acceleration) / mass.sum()
        assert Route(case).coasting(start, 50 / 3.6) == pytest.approx(actual, abs=0.001), start


def test_from_the_ceiling_the_planned_braking_reaches_the_limit_where_it_begins() -> None:
    """On a level line the train loses its running resistance and a quarter of full service, over 0.05 m/s^2."""
    case = scenario((-10_000, 80), (6000, 30), (6020, 80))
    route = Route(case)
    assert route.ceiling(2000.0) == pytest.approx(80 / 3.6)
    assert route.ceiling(6000.0) == route.ceiling(6010.0 + LENGTH) == pytest.approx(30 / 3.6)
    assert route.ceiling(6100.0 + LENGTH) == pytest.approx(80 / 3.6)
    full = sum(
        vehicle.shoes * vehicle.shoe_force * vehicle.friction.coefficient(vehicle.shoe_force, 80 / 3.6, 80 / 3.6)
        for vehicle in case.consist.vehicles
    )
    deceleration = 0.25 * full / case.consist.mass - route.coasting(0.0, 15.0)
    assert deceleration > 2.0 * COMFORTABLE
    # v^2 = l^2 + 2 b s, the resistance taken at its middle: 0.01 m/s^2 less to more
    for way in (300.0, 700.0, 1200.0):
        expected = math.sqrt((30 / 3.6) ** 2 + 2.0 * deceleration * way)
        assert route.ceiling(6000.0 - way) == pytest.approx(expected, rel=0.02)


def test_on_a_grade_that_a_light_application_does_not_hold_he_plans_to_brake_harder() -> None:
    route = Route(scenario((-10_000, 80), (6000, 30), grade=-20.0))
    way = 1500.0
    assert route.ceiling(6000.0 - way) == pytest.approx(math.sqrt((30 / 3.6) ** 2 + 2.0 * COMFORTABLE * way), rel=0.01)


# The second only where it is steepest, with the slowest limit on its way
HOLDING: dict[str, Any] = {"driver": {"speed_kmh": 65, "traction_kN": 400, "electric_brake_kN": 400}}
STEEPEST: dict[str, Any] = {"track.start_chainage_m": 28_000, "initial_speed_kmh": 55, "max_duration_s": 1400}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "ends"),
    [pytest.param({}, 61_000.0, marks=pytest.mark.hours), (HOLDING | STEEPEST, 49_000.0)],
    ids=["cyclic", "hold"],
)
def test_on_the_shipped_descent_no_part_of_the_train_is_over_a_limit(changes: dict[str, Any], ends: float) -> None:
    """70 km with 80, 70 and 60 km/h, from 3 per mille up to 12 down: 20 000 t, and no wagon releases unasked."""
    session, logs = run(load_scenario("daqin_descent", changes | {"time_step_ms": 4}))
    assert session.overspeeds().count == 0, session.overspeeds().worst
    assert not events(logs, EventKind.VALVE)
    front, _ = speeds_by_front(logs)
    assert front[-1] > ends
    assert session.extremes().compression.max() < 1.2e6
