"""Values replaced for one run."""

from __future__ import annotations

import numpy as np
import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.scenario import Scenario
from haul_ros.scenario.loader import load_scenario, load_scenario_text
from haul_ros.scenario.overrides import parse_override
from tests.empirical import wave_brakes


def _equal_again(scenario: Scenario) -> bool:
    return load_scenario_text(scenario.document, scenario.name) == scenario


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("initial_speed_kmh=1e1", "initial_speed_kmh", 10.0),
        ("radio.default.connected=false", "radio.default.connected", False),
        ("coupler=MT-2", "coupler", "MT-2"),
        ("description=a=b", "description", "a=b"),
        (
            "commands=[{at_s: 0, locomotive: master, brake: 1}]",
            "commands",
            [{"at_s": 0, "locomotive": "master", "brake": 1}],
        ),
    ],
)
def test_an_override_in_text_has_a_yaml_value(text: str, key: str, value: object) -> None:
    assert parse_override(text) == (key, value)


@pytest.mark.parametrize("text", ["initial_speed_kmh", "=3", ""])
def test_an_override_without_key_or_value_is_refused(text: str) -> None:
    with pytest.raises(ScenarioError, match="expected KEY=VALUE"):
        parse_override(text)


def test_an_override_that_is_not_yaml_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"^override commands:1: not valid YAML: "):
        parse_override("commands=[")


def test_a_value_of_the_scenario_is_replaced() -> None:
    scenario = load_scenario("daqin_1_2_1", {"initial_speed_kmh": 36, "consist.1.count": 50, "consist.0.count": 1})
    assert scenario.initial_speed == pytest.approx(10.0)
    assert len(scenario.consist.vehicles) == 208 - 52
    assert _equal_again(scenario)


def test_one_slave_may_differ_from_the_default_link() -> None:
    scenario = load_scenario("daqin_1_2_1", {"radio.default.delay_s": 1, "radio.slave_2.jitter_s": 0.5})
    assert [(link.delay, link.jitter) for link in scenario.radio.values()] == [(1.0, 0.0), (1.0, 0.5), (1.0, 0.0)]
    assert _equal_again(scenario)


def test_a_catalogue_value_is_replaced_for_this_run_and_called_so() -> None:
    key = "couplers.paper_set_b.loading_stiffness_kN_per_mm"
    scenario = load_scenario("daqin_1_2_1", {key: 40})
    gear = scenario.consist.couplers[0]
    assert gear is not None
    assert gear.compression.loading == ((0.0, 0.0), (1.0, 40e6))
    assert "couplers.paper_set_b: loading_stiffness_kN_per_mm overridden; other values fitted" in scenario.caveats
    assert _equal_again(scenario)


def test_a_nested_catalogue_value_is_replaced() -> None:
    scenario = load_scenario("daqin_1_2_1", {"brake_systems.paper_set_b.build_up.full_time_s": 3})
    assert (wave_brakes(scenario).build_up.knee_time, wave_brakes(scenario).build_up.full_time) == (3.0, 3.0)
    assert any("build_up.full_time_s overridden" in line for line in scenario.caveats)


def test_naming_another_catalogue_entry_takes_it_over() -> None:
    scenario = load_scenario("daqin_1_2_1", {"coupler": "MT-2", "vehicles.C80.brake_shoe": "low_friction_composite"})
    assert {gear and gear.name for gear in scenario.consist.couplers} == {"MT-2"}
    assert "paper_set_b: {loading" not in scenario.document
    assert _equal_again(scenario)


def test_an_entry_can_be_named_and_altered_in_any_order() -> None:
    scenario = load_scenario("daqin_1_2_1", {"couplers.MT-2.slack_mm": 10, "coupler": "MT-2"})
    gear = scenario.consist.couplers[0]
    assert gear is not None
    assert gear.slack == pytest.approx(0.01)


def test_a_whole_list_is_replaced() -> None:
    assert load_scenario("daqin_1_2_1", {"commands": []}).commands == ()


def test_an_own_entry_may_come_whole() -> None:
    wagon = {
        "mass_t": 84, "length_m": 12, "resistance": "wagon_loaded", "shoes": 8, "brake_shoe": "high_friction_composite",
        "shoe_force_kN": 20, "cylinder_pressure_kPa": 360,
    }  # fmt: skip
    scenario = load_scenario("daqin_1_2_1", {"consist.1.vehicle": "MINE", "vehicles": {"MINE": wagon}})
    assert scenario.consist.vehicles[1].name == "MINE"
    assert _equal_again(scenario)


def test_numpy_numbers_and_tuples_are_taken_as_what_they_hold() -> None:
    grades = ({"from_m": np.int64(0), "grade_permille": np.float32(0.5)},)
    scenario = load_scenario("daqin_1_2_1", {"track.grades": grades, "consist.1.count": np.int64(3)})
    assert scenario.track.grades == ((0.0, 0.0005),)
    assert _equal_again(scenario)


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("initial_speed", 9, "override: initial_speed: unknown key, did you mean initial_speed_kmh?"),
        ("initial_speed_kmh", 999, "override: initial_speed_kmh = 999, must be at most 200"),
        ("vehicles.C80.mass_t", float("nan"), "override: vehicles.C80.mass_t = nan, must be a finite number"),
        ("vehicles.C80.brake_shoe", "felt", "override: vehicles.C80.brake_shoe = 'felt', unknown name, brake_shoes: "),
        ("couplers.paper_set_b.slack", 1, "override: couplers.paper_set_b.slack: unknown key, did you mean slack_mm?"),
        ("couplers.MT-2.slack_mm", 1, "override: couplers.MT-2: not used by this scenario, couplers: paper_set_b"),
        ("coupler", "MT2", "override: coupler = 'MT2', unknown name, couplers: MT-2, "),
        ("coupler.name", "ST", "override: coupler.name: coupler is a single value"),
        ("consist.5.count", 1, "override: consist.5: consist is a list, expected an index from 0 to 4"),
        ("consist.first.count", 1, "override: consist.first: consist is a list, expected an index from 0 to 4"),
        (
            "track.grades.0.from_m",
            1,
            "override: track.grades.0: track.grades is a list, expected no index, it is empty",
        ),
        ("radio.slave_4.delay_s", 1, "override: radio.slave_4: no such locomotive, slaves: slave_1, slave_2, slave_3"),
        ("radio.guard.delay_s", 1, "override: radio.guard: unknown key, known: "),
        ("commands", [{"at_s": 0, "locomotive": "master"}], "override: commands.0: needs one of emergency, brake, "),
        ("consist", 3, "override: consist = 3, must be a list"),
        ("vehicles.C80", 3, "override: vehicles.C80"),
        ("description", None, "override: description = nothing, must be text"),
        ("description", object(), "override: a value of type object means nothing in a scenario"),
        ("", 1, "unknown key"),
    ],
)
def test_a_mistaken_override_is_told(key: str, value: object, expected: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load_scenario("daqin_1_2_1", {key: value})
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)
