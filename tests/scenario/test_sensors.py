"""``sensors`` of a scenario: which, how often, and with what errors."""

from __future__ import annotations

import math
from typing import Any

import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.sensor import CouplerSensors, Transducer
from haul_ros.scenario import load_scenario_text


def test_sensors_in_the_units_of_the_field_become_those_of_si(short_train: str) -> None:
    text = short_train + (
        "sensors: {couplers: [1, 21, 4], rate_hz: 25, seed: 7, "
        "force: {noise_kN: 2.5, quantisation_kN: 0.5, range_kN: 2500}, stroke: {quantisation_mm: 0.5}}\n"
    )
    scenario = load_scenario_text(text, "short")
    assert scenario.sensors == CouplerSensors(
        couplers=(0, 20, 3),
        every=2,
        seed=7,
        force=Transducer(2500.0, 500.0, 2.5e6),
        stroke=Transducer(0.0, 0.0005, math.inf),
    )
    assert load_scenario_text(scenario.document, "again").sensors == scenario.sensors


def test_by_default_there_are_none_and_those_there_are_show_the_force(short_train: str) -> None:
    assert load_scenario_text(short_train, "short").sensors is None
    sensors = load_scenario_text(short_train, "short", {"sensors.couplers": [5], "radio.seed": 3}).sensors
    assert sensors == CouplerSensors((4,), 1, 3, Transducer(), None)


@pytest.mark.parametrize(
    ("sensors", "message"),
    [
        ({"couplers": [1, 22]}, "sensors.couplers.1 = 22, must be at most 21, the last coupler"),
        ({"couplers": [3, 1, 3]}, "sensors.couplers.2 = 3, must not stand there twice"),
        ({"couplers": [0]}, "sensors.couplers.0 = 0, must be at least 1"),
        ({"couplers": []}, "sensors.couplers = a list, must have at least 1 entry"),
        ({"rate_hz": 5}, "sensors: couplers is missing"),
        ({"couplers": [1], "rate_hz": 30}, "sensors.rate_hz = 30, a measurement takes 1.66666667 samples"),
        ({"couplers": [1], "force": {"noise_kN": -1}}, "sensors.force.noise_kN = -1, must be at least 0"),
        (
            {"couplers": [1], "stroke": {"quantisation_mm": 2, "range_mm": 1}},
            "sensors.stroke.range_mm = 1, must be at least quantisation_mm, 2",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(short_train: str, sensors: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load_scenario_text(short_train, "short", {"sensors": sensors})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
