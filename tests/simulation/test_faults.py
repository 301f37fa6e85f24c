"""Faults of the brake pipe and its valves, from a scenario and live: one way in, and the same bits again."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.event import Event, EventKind
from haul_ros.model.fault import Fault, FaultKind
from haul_ros.model.request import Request, TimedRequest
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.session import Session

TRAIN = """\
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 20, drawbar_group: 2}
  - {vehicle: SS4, role: slave}
coupler: paper_set_b
brakes: pneumatic
initial_speed_kmh: 36
max_duration_s: 200
"""
EMERGENCY = Command("master", CommandKind.EMERGENCY, 1.0)


def scenario(faults: dict[str, Any] | None = None, **overrides: Any) -> Scenario:
    values = {key.replace("__", "."): value for key, value in overrides.items()}
    return load_scenario_text(TRAIN, "train", values | ({"faults": faults} if faults else {}))


def events(session: Session) -> list[tuple[int, EventKind, str]]:
    return [(entry.time_ns, entry.kind, entry.text) for entry in session.take_log().entries if isinstance(entry, Event)]


def asked(session: Session) -> list[TimedRequest]:
    entries = session.take_log().entries
    return [entry for entry in entries if isinstance(entry, TimedRequest) and isinstance(entry.request, Fault)]


def cylinder(session: Session) -> Any:
    return session.sample().cylinder_pressure


def pipe(session: Session) -> Any:
    return session.sample().pipe_pressure


def test_a_planned_fault_happens_whoever_drives_at_its_time_or_where_the_head_comes_to_its_chainage() -> None:
    plan = {"events": [{"at_m": 25, "leak": 5, "bore_mm": 3}, {"at_s": 1.5004, "close_angle_cock": 4}]}
    session = Session(scenario(plan))
    while session.time < 4.0:
        session.advance()
    first, second = asked(session)
    assert first == TimedRequest(1_501_000_000, Fault(FaultKind.CLOSE_ANGLE_COCK, 4))
    # at some 9.98 m/s the head has come 25 m after 2.50 s
    assert 2_500_000_000 <= second.time_ns <= 2_520_000_000
    assert second.request == Fault(FaultKind.LEAK, 5, 3e-3)


@pytest.mark.parametrize("rate", [1.0, 50.0])
def test_a_fault_by_chainage_happens_in_the_time_step_that_brings_the_head_there_whatever_the_sample_rate(
    rate: float,
) -> None:
    case = scenario({"events": [{"at_m": 23.4, "leak": 5, "bore_mm": 3}]}, sample_rate_hz=rate)
    witness = Session(case, play_faults=False)
    while witness.travelled < 23.4:
        witness.advance(1)
    session = Session(case)
    session.advance(4000)
    assert [fault.time_ns for fault in asked(session)] == [witness.time_ns]


def test_a_fault_by_chainage_counts_from_where_the_head_stands_at_the_start() -> None:
    plan = {"events": [{"at_m": 1025, "uncouple": 3}]}
    session = Session(scenario(plan, track__start_chainage_m=1000))
    session.advance(2400)
    assert not asked(session)
    session.advance(200)
    assert len(asked(session)) == 1


def test_what_was_asked_live_is_repeated_from_the_log_bit_for_bit() -> None:
    faults = [Fault(FaultKind.LEAK, 3, 4e-3), Fault(FaultKind.CUT_OUT_VALVE, 9), Fault(FaultKind.PART_HOSE, 7)]
    plan = {"leakage_kPa_per_min": 30, "events": [{"at_s": 1, "uncouple": 13}]}
    live, logged = Session(scenario(plan)), []
    for fault in faults:
        live.advance(713)
        live.request(fault)
    live.advance(8000)
    logged = asked(live)
    assert [entry.request for entry in logged] == [*faults[:1], Fault(FaultKind.UNCOUPLE, 13), *faults[1:]]
    again = Session(scenario(plan), requests=logged, play_faults=False)
    while again.step < live.step:
        again.advance(min(97, live.step - again.step))
    for name in ("coupler_force", "pipe_pressure", "cylinder_pressure", "chainage"):
        assert getattr(again.sample(), name).tobytes() == getattr(live.sample(), name).tobytes(), name


def test_a_parted_hose_brakes_both_ways_and_is_told() -> None:
    session = Session(scenario())
    session.request(Fault(FaultKind.PART_HOSE, 10))
    session.advance(8000)
    assert pipe(session).max() < 20e3
    assert (cylinder(session)[1:21] > 300e3).all()
    told = events(session)
    assert told[0] == (0, EventKind.FAULT, "coupler_010: brake hose parted")
    assert any(kind is EventKind.VALVE and "undesired emergency" in text for _, kind, text in told)
    session.advance(60_000)
    assert session.finished
    assert session.energy().fault is None


def test_behind_a_closed_cock_nothing_is_heard_of_an_emergency() -> None:
    session = Session(scenario(radio__default__connected=False))
    session.request(Fault(FaultKind.CLOSE_ANGLE_COCK, 10))
    session.request(EMERGENCY)
    session.advance(8000)
    assert (cylinder(session)[1:10] > 300e3).all()
    assert np.abs(cylinder(session)[10:21]).max() < 1e3
    session.request(Fault(FaultKind.OPEN_ANGLE_COCK, 10))
    session.advance(8000)
    assert (cylinder(session)[1:21] > 300e3).all()


def test_a_hose_that_parts_between_closed_cocks_lets_nothing_out_until_they_are_opened() -> None:
    session = Session(scenario())
    for kind in (FaultKind.CLOSE_ANGLE_COCK, FaultKind.PART_HOSE):
        session.request(Fault(kind, 10))
    session.advance(4000)
    assert pipe(session) == pytest.approx(np.full(22, 500e3), abs=1e3)
    session.request(Fault(FaultKind.OPEN_ANGLE_COCK, 10))
    session.advance(6000)
    assert pipe(session).max() < 50e3


def test_a_valve_that_is_cut_out_does_not_brake_and_lets_the_wave_pass() -> None:
    session = Session(scenario())
    session.request(Fault(FaultKind.CUT_OUT_VALVE, 6))
    session.request(EMERGENCY)
    session.advance(9000)
    assert abs(cylinder(session)[5]) < 100.0
    assert (cylinder(session)[[1, 2, 3, 4, 6, 7, 20]] > 300e3).all()
    session.request(Fault(FaultKind.CUT_OUT_VALVE, 7))
    session.advance(12_000)
    assert cylinder(session)[6] < 30e3, "its cylinder empties"
    session.request(Fault(FaultKind.CUT_IN_VALVE, 6))
    session.advance(5000)
    assert cylinder(session)[5] > 150e3, "its reservoir was charged, and finds no pressure in the pipe"
    assert session.energy().air_error < 1e-12


def test_a_leak_is_a_hole_of_its_bore_and_ends_with_none() -> None:
    session = Session(scenario())
    session.request(Fault(FaultKind.LEAK, 8, 5e-3))
    train = session._model.train
    assert train.air_state.hole[7] == pytest.approx(0.8 * np.pi / 4.0 * 5e-3**2)
    session.request(Fault(FaultKind.LEAK, 8, 0.0))
    assert not train.air_state.hole.any()
    told = [text for _, _, text in events(session)]
    assert told == [
        "vehicle_008_C80: leak of 5 mm in the brake pipe", "vehicle_008_C80: leak in the brake pipe closed"
    ]  # fmt: skip


def test_a_stopped_train_with_a_leak_that_is_fed_for_ever_has_finished() -> None:
    plan = {"leakage_kPa_per_min": 20, "events": [{"at_s": 0, "leak": 15, "bore_mm": 4}]}
    session = Session(scenario(plan), requests=[TimedRequest(0, Command("master", CommandKind.BRAKE, 1.0))])
    while not session.finished:
        session.advance()
    assert session.at_standstill
    assert session.time < 100.0


@pytest.mark.parametrize(
    ("fault", "problem"),
    [
        (Fault(FaultKind.PART_HOSE, 22), "part_hose: coupler 22, this train has 1 to 21"),
        (Fault(FaultKind.LEAK, 23, 1e-3), "leak: vehicle 23, this train has 1 to 22"),
        (Fault(FaultKind.UNCOUPLE, 0), "uncouple: coupler 0, must be a number from 1 at the head"),
        (Fault(FaultKind.UNCOUPLE, 2), "coupler_002 is a rigid drawbar"),
        (Fault(FaultKind.LEAK, 1, float("nan")), "bore nan m, must be 0 to 0.05"),
    ],
)
def test_what_the_train_cannot_have_changes_nothing(fault: Fault, problem: str) -> None:
    session = Session(scenario())
    session.take_log()
    with pytest.raises(CommandError, match=problem.replace("(", "\\(")):
        session.request(fault)
    assert session.take_log().entries == ()


def test_without_air_a_train_can_but_be_uncoupled() -> None:
    session = Session(scenario(brakes="paper_set_b"))
    request: Request = Fault(FaultKind.PART_HOSE, 3)
    with pytest.raises(CommandError, match="part_hose: needs a pneumatic brake"):
        session.request(request)
    session.request(Fault(FaultKind.UNCOUPLE, 3))


@pytest.mark.parametrize("brakes", ["pneumatic", "paper_set_b"])
def test_a_train_that_comes_apart_is_told_of_stops_in_both_parts_and_then_has_finished(brakes: str) -> None:
    plan = {"events": [{"at_s": 2, "uncouple": 11}]}
    pull = Command("master", CommandKind.TRACTION, 400e3)
    train = scenario(plan, brakes=brakes, radio__default__connected=False)
    session = Session(train, requests=[TimedRequest(500_000_000, pull)])
    told: list[tuple[int, EventKind, str]] = []
    while not session.finished:
        session.advance()
        told += events(session)
    parted = [(time, text) for time, kind, text in told if kind is EventKind.SEPARATION]
    assert parted[0][0] == 2_000_000_000
    assert parted[0][1].startswith("coupler_011: uncoupled under ")
    assert parted[0][1].endswith(" kN of draft")
    assert parted[1][1] == "coupler_011: hose parted at a gap of 0.30 m"
    assert [time for time, _ in parted] == sorted(time for time, _ in parted)
    stops = [(time, text) for time, kind, text in told if kind is EventKind.STOPPED]
    assert stops[-1][1] == "train: stopped" or stops[-2][1] == "train: stopped"
    sample = session.sample()
    assert session.stop_time is not None
    assert (sample.speed == 0.0).all()
    assert sample.stroke[10] < -0.3, "a gap is left"
    assert sample.chainage[10] - sample.chainage[11] == pytest.approx(12.0 - sample.stroke[10])
    assert session.energy().fault is None
    assert abs(session.energy().relative_imbalance) < 1e-12
    assert session.status().solver.unconverged_steps == 0


def test_parts_that_meet_again_are_told_of_with_their_speed() -> None:
    """The rear part, its valves cut out, rolls into the front part that has stopped."""
    events_ = [{"at_s": 0, "cut_out_valve": number} for number in range(12, 23)]
    plan = {"events": [*events_, {"at_s": 2, "uncouple": 11}]}
    pull = Command("master", CommandKind.TRACTION, 400e3)
    train = scenario(plan, initial_speed_kmh=18, radio__default__connected=False)
    session = Session(train, requests=[TimedRequest(500_000_000, pull)])
    told: list[tuple[int, EventKind, str]] = []
    speed = np.empty(0)
    for _ in range(3000):
        before = session.sample()
        session.advance()
        new = [entry for entry in events(session) if "met again" in entry[2]]
        if new and not told:
            speed = before.stroke_rate[10]
        told += new
    assert told
    assert told[0][2] == f"coupler_011: the parts have met again at {speed:.2f} m/s"
    assert session.extremes().compression[10] > 50e3
    assert session.energy().fault is None


def test_a_broken_coupler_is_told_of_with_its_force() -> None:
    session = Session(scenario(couplers__paper_set_b__strength_kN=250, initial_speed_kmh=0))
    session.request(Command("master", CommandKind.TRACTION, 600e3))
    session.advance(60_000)
    kinds = [(kind, text) for _, kind, text in events(session) if kind is EventKind.SEPARATION]
    force = float(kinds[0][1].partition("broke under ")[2].partition(" kN of draft")[0])
    assert 250.0 <= force < 260.0


def test_an_open_pipe_cannot_be_charged_so_the_emergency_of_a_train_that_came_apart_stays() -> None:
    session = Session(scenario({"events": [{"at_s": 1, "uncouple": 11}]}, brakes="paper_set_b"))
    session.request(Command("master", CommandKind.TRACTION, 400e3))
    session.request(Command("slave_1", CommandKind.TRACTION, 0.0))
    session.advance(8000)
    session.request(EMERGENCY)
    while not session.at_standstill:
        session.advance()
    session.request(Command("master", CommandKind.EMERGENCY, 0.0))
    session.advance(5000)
    assert (cylinder(session)[1:11] > 300e3).all()
