"""The state of the train at t = 0, as it is written."""

from __future__ import annotations

import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.initial_state import CouplerState, InitialAir, InitialState
from haul_ros.scenario import load_scenario, load_scenario_text


@pytest.mark.parametrize("state", list(CouplerState))
def test_couplers_stand_as_it_is_written(small_train: str, state: CouplerState) -> None:
    scenario = load_scenario_text(f"{small_train}initial_state: {{couplers: {state.value}}}\n", "x")
    assert scenario.initial_state == InitialState(state)
    assert load_scenario_text(scenario.document, "x") == scenario
    assert load_scenario_text(small_train, "x").initial_state == InitialState(CouplerState.FREE)


@pytest.mark.parametrize(
    ("given", "air"),
    [
        ({"brake_pipe_kPa": 440, "auxiliary_reservoir_kPa": 450, "cylinder_kPa": 150}, InitialAir(440e3, 450e3, 150e3)),
        ({"brake_pipe_kPa": 440}, InitialAir(440e3, 440e3, 0.0)),
        ({"cylinder_kPa": 50}, InitialAir(500e3, 500e3, 50e3)),
        ({}, None),
    ],
)
def test_pressures_are_those_given_or_follow_from_the_pipe(given: dict[str, float], air: InitialAir | None) -> None:
    scenario = load_scenario("daqin_1_2_1_pneumatic", {f"initial_state.{key}": value for key, value in given.items()})
    assert scenario.initial_state.air == air


@pytest.mark.parametrize(
    ("scenario", "given", "expected"),
    [
        (
            "daqin_1_2_1",
            {"cylinder_kPa": 50},
            "cylinder_kPa = 50, is for pneumatic brakes alone, and paper_set_b is none",
        ),
        (
            "daqin_1_2_1_pneumatic",
            {"brake_pipe_kPa": 501},
            "brake_pipe_kPa = 501, must be at most 500, that of the charged",
        ),
        (
            "daqin_1_2_1_pneumatic",
            {"auxiliary_reservoir_kPa": 501},
            "auxiliary_reservoir_kPa = 501, must be at most 500",
        ),
        (
            "daqin_1_2_1_pneumatic",
            {"brake_pipe_kPa": 90, "cylinder_kPa": 91},
            "cylinder_kPa = 91, must be at most 90, ",
        ),
        ("daqin_1_2_1_pneumatic", {"cylinder_kPa": -1}, "cylinder_kPa = -1, must be at least 0"),
        ("daqin_1_2_1", {"couplers": "tight"}, "couplers = 'tight', must be free or stretched or bunched"),
        ("daqin_1_2_1", {"pipe_kPa": 3}, "initial_state.pipe_kPa: unknown key, did you mean"),
    ],
)
def test_a_state_that_cannot_be_is_refused(scenario: str, given: dict[str, object], expected: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load_scenario(scenario, {f"initial_state.{key}": value for key, value in given.items()})
    assert expected in str(caught.value)
