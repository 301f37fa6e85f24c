"""The documented setting for recordings of hours: the same wherever it stands, and small enough."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from benchmarks import recording_size
from haul_ros.model.recording_plan import RecordingPlan, Rounding
from haul_ros.scenario import load_scenario, parse_override
from haul_ros.scenario.yaml_file import parse_yaml

ROOT = Path(__file__).parent.parent
PLAN = RecordingPlan(
    every=5,
    rounding=Rounding(
        coupler_force=8.0,
        brake_force=8.0,
        pressure=16.0,
        stroke=2.0**-17,
        stroke_rate=2.0**-17,
        speed=2.0**-17,
        chainage=2.0**-10,
    ),
)


def test_the_page_the_benchmark_and_the_shipped_parameters_have_the_same_setting() -> None:
    page = (ROOT / "docs/recordings.md").read_text("utf-8")
    found = re.search(r"--set sample_rate_hz=50 --set '(recording=.*?)' -o descent.mcap", page, re.S)
    assert found is not None
    key, value = parse_override(found[1])
    assert load_scenario("daqin_descent", {"sample_rate_hz": 50, key: value}).recording == PLAN
    documented = recording_size.SETTINGS[recording_size.DOCUMENTED]
    assert load_scenario("daqin_descent", {"sample_rate_hz": 50, "recording": documented}).recording == PLAN


def test_the_shipped_parameters_are_of_the_node() -> None:
    parameters = pytest.importorskip("haul_ros.ros.parameters", reason="needs message packages of ROS")
    text = (ROOT / "config" / "long_recording.yaml").read_text("utf-8")
    nested = parse_yaml(text, "long_recording.yaml").data["/**"]["ros__parameters"]
    rounding = nested.pop("rounding")
    given, unknown = parameters.check_given(nested | {f"rounding.{name}": v for name, v in rounding.items()})
    assert unknown == {}
    scenario = load_scenario("daqin_descent", parameters.scenario_overrides(given))
    assert (scenario.recording, scenario.sample_rate) == (PLAN, 50.0)
    values = parameters.values_in_effect(scenario, {})
    assert (values["record_rate"], values["rounding.stroke"]) == (10.0, 2.0**-17)


@pytest.mark.slow
def test_eight_hours_of_the_descent_stay_below_two_gigabytes() -> None:
    """The first minute, on level ground and a rise, with traction: the page has all of it, within 10 %."""
    sizes = {(size.setting, size.flushed_each_second): size for size in recording_size.measure(61.0)}
    for flushed, whole_line in ((False, 0.73), (True, 0.95)):
        size = sizes[recording_size.DOCUMENTED, flushed]
        assert size.gb_in_8_hours == pytest.approx(whole_line, rel=0.1)
        assert size.mb_in_largest_minute * 480 < 2000.0
    assert sizes[recording_size.ALL_BITS, False].gb_in_8_hours > 10.0
