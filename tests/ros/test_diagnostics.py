"""What is worth a warning."""

from __future__ import annotations

from dataclasses import replace

import pytest

from haul_ros.physics.train_model import StepStatistics
from haul_ros.recording.writer import RecorderStatus
from haul_ros.ros.diagnostics import ERROR, OK, WARN, RunReport, statuses
from haul_ros.ros.timing import LoopTiming
from haul_ros.simulation.radio import LinkStatus
from haul_ros.simulation.session import SessionStatus

TIMING = LoopTiming(
    real_time_factor=1.0,
    step_time_mean=5e-6,
    step_time_max=7e-6,
    lateness_max=2e-4,
    overruns=0,
    missed_periods=0,
    missed_now=0,
)
SESSION = SessionStatus(
    solver=StepStatistics(
        steps=1000,
        newton_iterations=1250,
        newton_iterations_max=3,
        divided_steps=0,
        fallback_steps=0,
        unconverged_steps=0,
        worst_residual=0.0,
    ),
    radio={"slave_1": LinkStatus(True, 0.5, sent=4, lost=1, retried=5, given_up=2, duplicates=3, out_of_order=6)},
)
RECORDER = RecorderStatus(written=100, dropped=0, bytes=4096, failure=None)
GOOD = RunReport(
    node="/haul",
    scenario="daqin_1_2_1",
    time=1.0,
    paused=False,
    timing=TIMING,
    session=SESSION,
    accepted=2,
    rejected=0,
    replaced=0,
    recorder=RECORDER,
)


def test_names_are_those_of_the_node_so_that_two_trains_are_told_apart() -> None:
    # diagnostic_updater puts the name of the node before ": ", with use_fqn its namespace too
    namespaced = statuses(replace(GOOD, node="/yard/train_a/haul"))
    assert [status.name for status in namespaced][:2] == ["yard/train_a/haul: pacing", "yard/train_a/haul: solver"]
    assert {status.hardware_id for status in (*namespaced, *statuses(GOOD))} == {"daqin_1_2_1"}


def test_what_a_flood_left_out_is_counted() -> None:
    (commands,) = (s for s in statuses(replace(GOOD, replaced=7)) if s.name == "haul: commands")
    assert commands.values["replaced by newer ones"] == "7"


def parts(report: RunReport) -> dict[str, tuple[int, str]]:
    return {status.name.removeprefix("haul: "): (status.level, status.message) for status in statuses(report)}


def test_a_run_in_order_is_ok_in_every_part() -> None:
    assert parts(GOOD) == {
        "pacing": (OK, "running"),
        "solver": (OK, "every step converged"),
        "radio": (OK, "all links up"),
        "commands": (OK, "every command accepted"),
        "recorder": (OK, "recording"),
    }


def test_figures_come_with_their_units() -> None:
    values = {key: value for status in statuses(GOOD) for key, value in status.values.items()}
    assert values["step time mean [us]"] == "5.00"
    assert values["lateness max [ms]"] == "0.200"
    assert values["Newton iterations mean"] == "1.250"
    assert values["slave_1 delay [s]"] == "0.5"
    assert (values["slave_1 sent"], values["slave_1 lost"]) == ("4", "1")
    wrong = ("retried", "given up", "duplicates", "out of order")
    assert [values[f"slave_1 {what}"] for what in wrong] == ["5", "2", "3", "6"]
    assert (values["written"], values["dropped"], values["bytes"]) == ("100", "0", "4096")


@pytest.mark.parametrize(
    ("report", "part", "level", "message"),
    [
        (replace(GOOD, paused=True), "pacing", OK, "paused"),
        (replace(GOOD, timing=replace(TIMING, overruns=3, missed_periods=30)), "pacing", OK, "running"),
        (
            replace(GOOD, timing=replace(TIMING, overruns=1, missed_periods=8, missed_now=8)),
            "pacing",
            WARN,
            "too slow: 8 periods missed",
        ),
        (
            replace(GOOD, session=replace(SESSION, solver=replace(SESSION.solver, unconverged_steps=2))),
            "solver",
            ERROR,
            "2 steps did not converge",
        ),
        (
            replace(GOOD, session=replace(SESSION, radio={"slave_1": LinkStatus(False, 0.5, 4, 4)})),
            "radio",
            WARN,
            "no link to slave_1",
        ),
        (replace(GOOD, rejected=3), "commands", WARN, "3 commands rejected"),
        (replace(GOOD, recorder=None), "recorder", OK, "no recording"),
        (replace(GOOD, recorder=replace(RECORDER, dropped=7)), "recorder", WARN, "7 messages dropped"),
        (replace(GOOD, recorder=replace(RECORDER, failure="disk full")), "recorder", ERROR, "disk full"),
    ],
)
def test_what_is_out_of_order_shows_in_its_part_alone(report: RunReport, part: str, level: int, message: str) -> None:
    expected = {**parts(GOOD), part: (level, message)}
    assert parts(report) == expected
