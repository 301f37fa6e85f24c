"""``recording`` of a scenario: rate and resolutions, checked."""

from __future__ import annotations

from typing import Any

import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.recording_plan import RecordingPlan, Rounding
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario_text


def load(short_train: str, **overrides: Any) -> Scenario:
    return load_scenario_text(short_train, "short", {key.replace("__", "."): v for key, v in overrides.items()})


def test_by_default_all_samples_are_recorded_with_all_their_bits(short_train: str) -> None:
    scenario = load(short_train)
    assert scenario.recording == RecordingPlan()
    assert scenario.record_rate == scenario.sample_rate == 50.0


def test_resolutions_in_their_units_become_powers_of_two_in_si(short_train: str) -> None:
    text = short_train + (
        "recording: {rate_hz: 10, rounding: {coupler_force_N: 10, stroke_mm: 0.01, stroke_rate_mm_per_s: 1, "
        "chainage_mm: 1, speed_mm_per_s: 0.9765625, brake_force_N: 0.125, pressure_Pa: 100}}\n"
    )
    scenario = load(text)
    assert scenario.recording == RecordingPlan(
        every=5,
        rounding=Rounding(
            coupler_force=8.0,
            stroke=2.0**-17,  # 7.63 um
            stroke_rate=2.0**-10,
            chainage=2.0**-10,
            speed=2.0**-10,  # 0.9765625 mm/s is that power itself
            brake_force=0.125,
            pressure=64.0,
        ),
    )
    assert scenario.record_rate == 10.0
    again = load_scenario_text(scenario.document, "again")
    assert again.recording == scenario.recording


def test_a_single_resolution_can_be_set_from_outside(short_train: str) -> None:
    scenario = load(short_train, recording__rounding__pressure_Pa=50, recording__rate_hz=25)
    assert scenario.recording == RecordingPlan(every=2, rounding=Rounding(pressure=32.0))


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"recording__rate_hz": 15}, "recording.rate_hz = 15, a recorded sample takes 3.33333333 samples"),
        ({"recording__rate_hz": 100}, "takes 0.5 samples of sample_rate_hz = 50, must be a whole number of them"),
        ({"recording__rate_hz": 0}, "recording.rate_hz = 0, must be at least 0.001"),
        ({"recording__rounding__pressure_Pa": -1}, "recording.rounding.pressure_Pa = -1, must be at least 0"),
        ({"recording__rounding__stroke_mm": 1e-7}, "recording.rounding.stroke_mm = 1e-07, must be 0 or at least 1e-06"),
        ({"recording__rounding__force_N": 1}, "recording.rounding.force_N: unknown key, did you mean brake_force_N"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(short_train: str, overrides: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load(short_train, **overrides)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
