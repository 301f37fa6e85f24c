"""Runs with a pneumatic brake: commands, radio, traction, events, bits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from haul_ros.errors import CommandError
from haul_ros.model.air_brake import ATMOSPHERE
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import Effort
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario, load_scenario_text
from haul_ros.simulation.batch import periods
from haul_ros.simulation.session import Session

TRAIN = """\
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 20}
  - {vehicle: SS4, role: slave}
coupler: paper_set_b
brakes: pneumatic
initial_speed_kmh: 40
max_duration_s: 200
radio: {default: {delay_s: 1.0}}
"""


def scenario(**overrides: Any) -> Scenario:
    return load_scenario_text(TRAIN, "train", {key.replace("__", "."): value for key, value in overrides.items()})


def brake(locomotive: str, value: float, kind: CommandKind = CommandKind.BRAKE) -> Command:
    return Command(locomotive, kind, value)


def events(session: Session) -> list[tuple[EventKind, str]]:
    return [(entry.kind, entry.text) for entry in session.take_log().entries if isinstance(entry, Event)]


def test_a_train_brakes_releases_and_comes_to_rest() -> None:
    session = Session(scenario())
    session.request(brake("master", 0.5))
    session.advance(15_000)
    braked = session.sample()
    assert braked.pipe_pressure is not None
    assert braked.auxiliary_pressure is not None
    assert braked.pipe_pressure == pytest.approx(np.full(22, 405e3), abs=3e3)
    assert (braked.cylinder_pressure[1:21] > 200e3).all()
    assert braked.auxiliary_pressure[1:21] == pytest.approx(braked.pipe_pressure[1:21], abs=5e3)
    session.request(brake("master", 0.0))
    session.advance(40_000)
    assert (session.sample().cylinder_pressure < 1e3).all()
    assert not session.finished or session.at_standstill
    session.request(brake("master", 1.0, CommandKind.EMERGENCY))
    while not session.finished:
        session.advance()
    assert session.stop_time is not None
    assert abs(session.energy().relative_imbalance) < 1e-9
    assert session.energy().fault is None


def test_the_slave_hears_over_the_radio_and_brakes_then_from_its_end_too() -> None:
    session = Session(scenario(radio__default__delay_s=0.2))
    alone = Session(scenario(radio__default__connected=False))
    for run in (session, alone):
        run.request(brake("master", 1.0))
        run.advance(1500)
    assert session.sample().cylinder_pressure[20] > alone.sample().cylinder_pressure[20] + 5e3


def test_the_same_requests_give_the_same_bits_however_calls_are_grouped() -> None:
    requests = [
        TimedRequest(500_000_000, brake("master", 0.3)),
        TimedRequest(6_000_000_000, brake("master", 0.0)),
        TimedRequest(9_000_000_000, RadioLinkChange("slave_1", connected=False)),
        TimedRequest(12_000_000_000, brake("master", 1.0, CommandKind.EMERGENCY)),
    ]
    samples = []
    for steps in (1, 7, 500, 20_000):
        session = Session(scenario(), requests=requests)
        while session.step < 20_000:
            session.advance(min(steps, 20_000 - session.step))
        samples.append(session.sample())
    for name in ("coupler_force", "pipe_pressure", "auxiliary_pressure", "cylinder_pressure", "speed"):
        first, *others = (getattr(sample, name).tobytes() for sample in samples)
        assert all(other == first for other in others), name


@pytest.mark.parametrize("time_step", [0.5, 1.0, 2.0, 4.0])
def test_air_and_train_share_one_clock_whatever_the_time_step(time_step: float) -> None:
    session = Session(scenario(time_step_ms=time_step))
    session.request(brake("master", 1.0, CommandKind.EMERGENCY))
    session.advance(round(5000 / time_step))
    reference = Session(scenario(time_step_ms=1.0))
    reference.request(brake("master", 1.0, CommandKind.EMERGENCY))
    reference.advance(5000)
    got, expected = session.sample(), reference.sample()
    assert got.pipe_pressure is not None
    assert expected.pipe_pressure is not None
    assert got.pipe_pressure == pytest.approx(expected.pipe_pressure, abs=1.0)  # the same air steps
    assert got.cylinder_pressure == pytest.approx(expected.cylinder_pressure, rel=1e-6)
    assert got.speed == pytest.approx(expected.speed, rel=1e-4)


def test_an_emergency_ends_traction_everywhere_and_a_service_where_the_link_is_down() -> None:
    session = Session(scenario(initial_speed_kmh=20))
    session.request(brake("master", 200e3, CommandKind.TRACTION))
    session.advance(3000)
    session.request(RadioLinkChange("slave_1", connected=False))
    traction = session._model.train.vehicles.traction
    assert traction[0] > 0.0
    assert traction[21] > 0.0
    session.request(brake("master", 0.5))
    session.advance(8000)
    assert traction[0] == 0.0
    assert traction[21] == 0.0  # the pipe has told it
    session = Session(scenario(initial_speed_kmh=20))
    session.request(brake("master", 200e3, CommandKind.TRACTION))
    session.advance(3000)
    session.request(brake("slave_1", 1.0, CommandKind.EMERGENCY))
    session.advance(4000)
    assert session._model.train.vehicles.traction[0] == 0.0  # it felt the pipe fall


def test_a_braked_train_on_a_grade_stands() -> None:
    session = Session(
        scenario(initial_speed_kmh=10, track__grades=[{"from_m": -1e5, "grade_permille": -12}], max_duration_s=4000)
    )
    session.request(brake("master", 1.0))
    session.advance(60_000)
    assert session.at_standstill
    before = session.sample().chainage
    session.advance(100_000)
    assert (session.sample().chainage == before).all()


def test_events_tell_what_valves_do_at_locomotives_and_the_tail() -> None:
    session = Session(scenario())
    session.take_log()
    session.request(brake("master", 0.4))
    told: list[tuple[EventKind, str]] = []
    for _ in range(200):
        session.advance()
        told += events(session)
    waves = [text for kind, text in told if kind is EventKind.WAVE]
    assert any("master" in text and "application" in text for text in waves)
    assert any("slave_1" in text and "application" in text for text in waves)
    assert not [text for kind, text in told if kind is EventKind.VALVE]
    session.request(brake("master", 0.0))
    told = []
    for _ in range(800):
        session.advance()
        told += events(session)
    assert any("release" in text for kind, text in told if kind is EventKind.WAVE)
    assert not [text for kind, text in told if kind is EventKind.VALVE]  # it was asked for


def test_the_last_work_of_an_electric_brake_that_an_emergency_ends_is_its_own() -> None:
    session = Session(scenario(vehicles__SS4__effort_rise_time_s=1))
    session.request(Command("master", CommandKind.ELECTRIC_BRAKE, 200e3))
    session.advance(3_000)
    session._model.part_hose(10)
    session.advance(5_000)
    assert session._model.efforts[0] == 0.0
    assert session.energy().traction_work == 0.0
    assert session.energy().electric_brake_work > 0.0


def test_an_emergency_that_nobody_asked_for_is_told() -> None:
    session = Session(scenario())
    session.take_log()
    session._model.part_hose(10)
    told: list[tuple[EventKind, str]] = []
    for _ in range(100):
        session.advance()
        told += events(session)
    undesired = [text for kind, text in told if kind is EventKind.VALVE]
    assert undesired
    assert all("undesired emergency" in text for text in undesired)
    assert any("vehicle_011_C80" in text for text in undesired)


@pytest.mark.slow
def test_a_release_that_nobody_asked_for_is_told() -> None:
    long_train = load_scenario("daqin_1_1_0", {"brakes": "pneumatic_600", "commands": [], "time_step_ms": 4})
    session = Session(long_train)
    for wait, demand in ((60, 1e-9), (30, 0.0), (50, 1e-9)):
        session.request(brake("master", demand))
        told: list[tuple[EventKind, str]] = []
        for _ in range(wait):
            session.advance(250)
            told += events(session)
        unintended = [text for kind, text in told if kind is EventKind.VALVE]
        assert bool(unintended) == (wait == 50), demand
    assert all("unintended release" in text for text in unintended)


@pytest.mark.parametrize("fault", ["part_hose", "slave in emergency"])
def test_an_application_does_not_charge_a_pipe_that_an_emergency_has_emptied(fault: str) -> None:
    """With UIC distributors, whose brake valve maintains its reduction; the pipe held 350 kPa and cylinders let go."""
    session = Session(scenario(brakes="pneumatic_uic", radio__default__delay_s=0))
    if fault == "part_hose":
        session._model.part_hose(10)
    else:
        session.request(brake("slave_1", 1.0, CommandKind.EMERGENCY))
    session.advance(8_000)
    before = session.sample()
    session.request(brake("master", 1.0))
    session.advance(10_000)
    after = session.sample()
    assert before.pipe_pressure is not None
    assert after.pipe_pressure is not None
    assert (after.pipe_pressure <= before.pipe_pressure + 1e3).all()
    assert (after.cylinder_pressure >= before.cylinder_pressure - 1e3).all()


def test_a_release_that_is_still_under_way_when_the_brake_is_applied_again_was_asked_for() -> None:
    """100 wagons release within 5 s, at some 250 m/s; after 2 s the locomotive applies again."""
    consist = [{"vehicle": "SS4", "role": "master"}, {"vehicle": "C80", "count": 100}]
    session = Session(scenario(consist=consist, initial_speed_kmh=0))
    released = 0
    for demand, seconds in ((0.5, 55), (0.0, 2), (0.5, 10)):
        session.request(brake("master", demand))
        for _ in range(seconds * 10):
            before = session._model.valves()
            session.advance(100)
            now = session._model.valves()
            assert before is not None
            assert now is not None
            if seconds == 10:
                released += int(np.count_nonzero(before.applied & ~now.applied))
            assert not [text for kind, text in events(session) if kind is EventKind.VALVE]
    assert released > 30


def test_a_valve_that_is_cut_out_has_not_released_by_itself() -> None:
    session = Session(scenario(faults={"events": [{"at_s": 10, "cut_out_valve": 5}]}))
    session.request(brake("master", 0.5))
    told = []
    for _ in range(20 * 50):
        session.advance()
        told += events(session)
    assert (EventKind.FAULT, "vehicle_005_C80: control valve cut out") in told
    assert not [text for kind, text in told if kind is EventKind.VALVE]
    assert session.unintended_releases == 0


def test_a_run_is_over_when_train_and_air_have_come_to_rest() -> None:
    logs = list(
        periods(Session(scenario(commands=[{"at_s": 1, "locomotive": "master", "brake": 0.6}]), play_commands=True))
    )
    last = logs[-1].sample
    assert last is not None
    assert (last.speed == 0.0).all()
    assert last.time_ns < 200 * 10**9
    assert last.pipe_pressure is not None
    assert last.pipe_pressure == pytest.approx(np.full(22, 396e3), abs=3e3)


def test_gauge_and_absolute_pressures_differ_by_the_atmosphere() -> None:
    session = Session(scenario())
    pressure = session.sample().pipe_pressure
    assert pressure is not None
    assert pressure == pytest.approx(session._model.train.air_state.pipe - ATMOSPHERE)


def test_an_electric_brake_goes_over_the_radio_is_recorded_and_shows_what_acts() -> None:
    session = Session(scenario(initial_speed_kmh=60))
    session.take_log()
    session.request(brake("master", 300e3, CommandKind.ELECTRIC_BRAKE))
    efforts: dict[str, list[tuple[int, float]]] = {"master": [], "slave_1": []}
    for _ in range(1500):
        session.advance()
        for entry in session.take_log().entries:
            if isinstance(entry, Effort):
                efforts[entry.locomotive].append((entry.time_ns, entry.value))
    assert {name: values[-1][1] for name, values in efforts.items()} == {"master": -300e3, "slave_1": -300e3}
    assert efforts["slave_1"][0][0] - efforts["master"][0][0] == pytest.approx(10**9, abs=40_000_000)
    energy = session.energy()
    assert energy.electric_brake_work > 0.0
    assert abs(energy.relative_imbalance) < 1e-9


def test_more_than_the_electric_brake_has_is_refused() -> None:
    session = Session(scenario())
    with pytest.raises(CommandError, match=r"master: electric_brake = 400000.0 N, must be at most 382000.0 N"):
        session.request(brake("master", 400e3, CommandKind.ELECTRIC_BRAKE))
    with pytest.raises(CommandError, match="must be 0 or more"):
        session.request(brake("master", -1.0, CommandKind.ELECTRIC_BRAKE))


def test_a_service_application_leaves_the_electric_brake_and_ends_traction() -> None:
    session = Session(scenario(initial_speed_kmh=60))
    session.request(brake("master", 200e3, CommandKind.ELECTRIC_BRAKE))
    session.advance(15_000)
    session.request(brake("master", 0.3))
    session.advance(3_000)
    assert (session._model.efforts[[0, 21]] == -200e3).all()
    session.request(brake("master", 1.0, CommandKind.EMERGENCY))
    session.advance(2_000)
    assert (session._model.efforts == 0.0).all()
