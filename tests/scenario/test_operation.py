"""Line, radio, commands, time grid and brakes of a scenario."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields

import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.radio import RadioLink, RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.model.scenario import Scenario
from haul_ros.scenario.loader import load_scenario_text
from tests.empirical import wave_brakes

Load = Callable[..., Scenario]


@pytest.fixture
def load(small_train: str) -> Load:
    """The small train with more lines."""
    return lambda *lines: load_scenario_text(small_train + "\n".join(lines) + "\n", "x")


def test_grades_and_curves_become_steps_along_the_chainage(load: Load) -> None:
    track = load(
        "track:",
        "  start_chainage_m: 1000",
        "  grades: [{from_m: 0, grade_permille: 5}, {from_m: 500, grade_permille: -12}]",
        "  curves:",
        "    - {from_m: 100, to_m: 300, radius_m: 800}",
        "    - {from_m: 300, to_m: 400, radius_m: 400}",
        "    - {from_m: 600, to_m: 700, radius_m: 500}",
    ).track
    assert track.start_chainage == 1000.0
    assert track.grades == ((0.0, 0.005), (500.0, -0.012))
    assert track.curves == (
        (100.0, 1 / 800),
        (300.0, 1 / 400),
        (400.0, 0.0),
        (600.0, 1 / 500),
        (700.0, 0.0),
    )


def test_speed_limits_and_ramps_become_those_of_the_line(load: Load) -> None:
    track = load(
        "track:",
        "  grade_ramp_m: 200",
        "  grades:",
        "    - {from_m: 0, grade_permille: 5}",
        "    - {from_m: 100, grade_permille: 5}",
        "    - {from_m: 200, grade_permille: 6}",
        "  speed_limits: [{from_m: 0, limit_kmh: 72}, {from_m: 500}, {from_m: 900, limit_kmh: 36}]",
    ).track
    assert track.grade_ramp == 200.0
    assert track.speed_limits == ((0.0, 20.0), (500.0, math.inf), (900.0, 10.0))


def test_a_link_takes_from_the_default_what_it_does_not_say(load: Load) -> None:
    scenario = load("radio: {seed: 7, default: {delay_s: 2, loss_probability: 0.1}, slave_1: {jitter_s: 1}}")
    link = scenario.radio["slave_1"]
    assert (link.delay, link.jitter, link.loss_probability, link.connected) == (2.0, 1.0, 0.1, True)
    assert scenario.radio_seed == 7


def test_commands_are_in_order_of_time_and_in_si_units(load: Load) -> None:
    commands = load(
        "commands:",
        "  - {at_s: 9, locomotive: master, emergency: true}",
        "  - {at_s: 5, locomotive: slave_1, brake: 0.5}",
        "  - {at_s: 0, locomotive: master, traction_kN: 300}",
        "  - {at_s: 5, locomotive: slave_1, brake: 0.6}",
    ).commands
    assert commands == (
        TimedRequest(0, Command("master", CommandKind.TRACTION, 300e3)),
        TimedRequest(5_000_000_000, Command("slave_1", CommandKind.BRAKE, 0.5)),
        TimedRequest(5_000_000_000, Command("slave_1", CommandKind.BRAKE, 0.6)),
        TimedRequest(9_000_000_000, Command("master", CommandKind.EMERGENCY, 1.0)),
    )


@pytest.mark.parametrize(("step", "rate"), [(1, 50), (0.25, 50), (0.1, 1000), (2, 500), (1000 / 60, 60)])
def test_a_sample_of_a_whole_number_of_steps_is_accepted(load: Load, step: float, rate: float) -> None:
    scenario = load(f"time_step_ms: {step!r}", f"sample_rate_hz: {rate!r}")
    assert scenario.time_step == pytest.approx(step / 1e3)
    assert scenario.sample_rate == pytest.approx(rate)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            "time_step_ms: 0.3",
            "x: sample_rate_hz = 50, a sample takes 66.6666667 time steps of 0.3 ms, must be a whole",
        ),
        ("sample_rate_hz: 2000", "x:8: sample_rate_hz = 2000, a sample takes 0.5 time steps of 1 ms, must be a whole"),
        ("time_step_ms: 0", "x:8: time_step_ms = 0, must be at least 0.001"),
        ("max_duration_s: -1", "x:8: max_duration_s = -1, must be above 0"),
        (
            "track: {grades: [{from_m: 5, grade_permille: 1}, {from_m: 5, grade_permille: 2}]}",
            "x:8: track.grades.1.from_m = 5, must be above that of the grade before, 5",
        ),
        ("track: {grades: [{from_m: 5, grade: 1}]}", "track.grades.0.grade: unknown key, did you mean grade_permille?"),
        (
            "track: {grade_ramp_m: 20, grades: [{from_m: 5, grade_permille: 1}, {from_m: 20, grade_permille: 2}]}",
            "x:8: track.grades.1.from_m = 20, its ramp of 20 m overlaps that of the change at 5 m: must be at least "
            "25, or grade_ramp_m at most 15",
        ),
        ("track: {grade_ramp_m: 0.5}", "x:8: track.grade_ramp_m = 0.5, must be 0 or at least 1"),
        (
            "track: {speed_limits: [{from_m: 5, limit_kmh: 40}, {from_m: 4}]}",
            "x:8: track.speed_limits.1.from_m = 4, must be above that of the limit before, 5",
        ),
        ("track: {curves: [{from_m: 5, to_m: 5, radius_m: 400}]}", "track.curves.0.to_m = 5, must be above from_m, 5"),
        (
            "track: {curves: [{from_m: 0, to_m: 9, radius_m: 400}, {from_m: 8, to_m: 10, radius_m: 400}]}",
            "track.curves.1.from_m = 8, the curve before ends at 9",
        ),
        ("track: {curves: [{from_m: 0, to_m: 9, radius_m: 0}]}", "track.curves.0.radius_m = 0, must be at least 50"),
        ("radio: {slave_2: {delay_s: 1}}", "x:8: radio.slave_2: no such locomotive, slaves: slave_1"),
        ("radio: {default: {delay_s: -1}}", "x:8: radio.default.delay_s = -1, must be at least 0"),
        ("radio: {default: {loss_probability: 2}}", "radio.default.loss_probability = 2, must be at most 1"),
        (
            "commands: [{at_s: 0, locomotive: slave_2, brake: 1}]",
            "x:8: commands.0.locomotive = 'slave_2', must be one of master, slave_1",
        ),
        ("commands: [{at_s: 0, locomotive: master, brake: 1.01}]", "commands.0.brake = 1.01, must be at most 1"),
        ("commands: [{at_s: -1, locomotive: master, brake: 1}]", "commands.0.at_s = -1, must be at least 0"),
        ("commands: [{at_s: 0, locomotive: master, emergency: 1}]", "commands.0.emergency = 1, must be true or false"),
        (
            "commands: [{at_s: 0, locomotive: master, traction_kN: 628}]",
            "commands.0.traction_kN = 628, must be at most 627.8, all that SS4 has",
        ),
    ],
)
def test_what_cannot_be_is_refused(load: Load, line: str, expected: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load(line)
    assert expected in str(caught.value)


BRAKES = """\
brake_systems:
  paper_set_b:
    wave_speeds: {emergency_mps: 250, service_mps: 230, release_mps: 150}
    build_up: {BUILD_UP, service_time_s: 15, release_time_s: 20, friction_follows_pressure: true}
    full_service_fraction: 0.9"""


def test_a_linear_build_up_has_its_knee_at_the_end(load: Load) -> None:
    brakes = wave_brakes(load(BRAKES.replace("BUILD_UP", "full_time_s: 3")))
    assert (brakes.build_up.knee, brakes.build_up.knee_time, brakes.build_up.full_time) == (1.0, 3.0, 3.0)
    assert (brakes.wave_speeds.emergency, brakes.wave_speeds.service, brakes.wave_speeds.release) == (250, 230, 150)
    assert (brakes.build_up.service_time, brakes.build_up.release_time) == (15.0, 20.0)
    assert brakes.build_up.friction_follows_pressure
    assert brakes.full_service == 0.9


def test_a_two_stage_build_up_has_its_knee_where_it_is_given(load: Load) -> None:
    two_stage = "knee_fraction: 0.36, knee_time_s: 1, full_time_s: 10"
    build_up = wave_brakes(load(BRAKES.replace("BUILD_UP", two_stage))).build_up
    assert (build_up.knee, build_up.knee_time, build_up.full_time) == (0.36, 1.0, 10.0)


@pytest.mark.parametrize(
    ("build_up", "expected"),
    [
        (
            "knee_fraction: 0.36, knee_time_s: 5, full_time_s: 5",
            "build_up.knee_time_s = 5, must be below full_time_s, 5",
        ),
        ("knee_fraction: 0.36, full_time_s: 5", "build_up: knee_fraction needs knee_time_s beside it"),
        ("knee_fraction: 1, knee_time_s: 1, full_time_s: 5", "build_up.knee_fraction = 1, must be below 1"),
        ("full_time_s: 0", "build_up.full_time_s = 0, must be above 0"),
    ],
)
def test_a_build_up_that_cannot_be_is_refused(load: Load, build_up: str, expected: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load(BRAKES.replace("BUILD_UP", build_up))
    assert expected in str(caught.value)


def test_a_link_has_all_that_the_scenario_says(load: Load) -> None:
    link = load(
        "radio:",
        "  default:",
        "    {jitter_law: gamma, jitter_shape: 3, retries: 2, retry_interval_s: 1, tunnels: [{from_m: 5, to_m: 9}]}",
        "  slave_1:",
        "    {outages: [{from_s: 1, to_s: 2}, {from_s: 2, to_s: 3}], in_order: false, fails: from_slave,",
        "     duplicate_probability: 0.5, burst_length_s: 2, burst_spacing_s: 30, burst_loss_probability: 0.75,",
        "     heartbeat_s: 1, link_timeout_s: 5, link_lost: apply, jitter_quantiles: [0, 1, 4]}",
    ).radio["slave_1"]
    assert link == RadioLink(
        jitter_law="gamma",
        jitter_shape=3.0,
        retries=2,
        retry_interval=1.0,
        tunnels=((5.0, 9.0),),
        outages=((1.0, 2.0), (2.0, 3.0)),
        in_order=False,
        fails="from_slave",
        duplicate_probability=0.5,
        burst_length=2.0,
        burst_spacing=30.0,
        burst_loss_probability=0.75,
        heartbeat=1.0,
        link_timeout=5.0,
        link_lost="apply",
        jitter_quantiles=(0.0, 1.0, 4.0),
    )
    assert all(type(getattr(link, f.name)) is type(f.default) for f in fields(RadioLink))


def test_what_a_scenario_leaves_out_is_the_default_of_a_link(load: Load) -> None:
    assert load("radio: {}").radio["slave_1"] == RadioLink()


def test_changes_of_links_stand_among_the_commands(load: Load) -> None:
    commands = load(
        "commands:",
        "  - {at_s: 9, link: slave_1, connected: false, delay_s: 2, retries: 3}",
        "  - {at_s: 5, locomotive: slave_1, brake: 0.5}",
    ).commands
    assert commands[1] == TimedRequest(9 * 10**9, RadioLinkChange("slave_1", delay=2.0, connected=False, retries=3))


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "radio: {default: {jitter_law: cauchy}}",
            "jitter_law = 'cauchy', must be uniform or exponential or normal or",
        ),
        ("radio: {default: {retries: 17}}", "radio.default.retries = 17, must be at most 16"),
        ("radio: {default: {retry_interval_s: 0}}", "retry_interval_s = 0, must be at least 0.01"),
        ("radio: {default: {fails: both}}", "fails = 'both', must be none or to_slave or from_slave"),
        ("radio: {slave_1: {outages: [{from_s: 2, to_s: 2}]}}", "outages.0.to_s = 2, must be above from_s, 2"),
        (
            "radio: {slave_1: {tunnels: [{from_m: 0, to_m: 5}, {from_m: 4, to_m: 9}]}}",
            "tunnels.1.from_m = 4, the one before ends at 5",
        ),
        ("radio: {slave_1: {jitter_quantiles: [1, 0]}}", "jitter_quantiles.1 = 0, must be at least that before, 1"),
        (
            "radio: {default: {link_timeout_s: 2}}",
            "link_timeout_s = 2, must be above heartbeat_s, 0, which must be abo",
        ),
        ("radio: {default: {heartbeat_s: 2, link_timeout_s: 1}}", "link_timeout_s = 1, must be above heartbeat_s, 2"),
        ("radio: {default: {heartbeat_s: 0.01}}", "heartbeat_s = 0.01, must be 0 or at least 0.1"),
        ("radio: {slave_1: {link_lost: idle}}", "radio.slave_1: link_lost = 'idle' needs link_timeout_s above 0"),
        ("commands: [{at_s: 0, link: slave_2, delay_s: 1}]", "commands.0.link = 'slave_2', must be one of slave_1"),
        ("commands: [{at_s: 0, link: slave_1}]", "commands.0: link needs beside it what changes: delay_s, jitter_s, "),
        (
            "commands: [{at_s: 0, link: slave_1, brake: 1}]",
            "commands.0: needs one of emergency, brake, traction_kN, ele",
        ),
        ("commands: [{at_s: 0, locomotive: master, brake: 1, delay_s: 1}]", "commands.0: delay_s needs link beside it"),
        ("commands: [{at_s: 0, brake: 1}]", "commands.0: brake needs locomotive beside it"),
        ("commands: [{at_s: 0, link: slave_1, locomotive: master, delay_s: 1}]", "must not stand beside link"),
        ("commands: [{at_s: 0, link: slave_1, outages: []}]", "commands.0.outages: unknown key"),
    ],
)
def test_a_link_that_cannot_be_is_refused_in_one_line(load: Load, line: str, message: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        load(line)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)
