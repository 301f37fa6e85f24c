"""Coupler entries to draft gears."""

from __future__ import annotations

import math

import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.draft_gear import DraftGear
from haul_ros.physics.stiffness import steepest_slope
from haul_ros.scenario.document import Document
from haul_ros.scenario.draft_gears import DEFAULT_SOLID_STIFFNESS, draft_gears


def _gear(**entry: object) -> DraftGear:
    return draft_gears(Document("x", {"couplers": {"G": {"transition_speed_mps": 0.01, **entry}}}))["G"]


def test_stiffnesses_give_straight_curves_in_both_directions() -> None:
    gear = _gear(loading_stiffness_kN_per_mm=30, unloading_stiffness_kN_per_mm=27)
    assert gear.compression.loading == ((0.0, 0.0), (1.0, 30e6))
    assert gear.compression.unloading == ((0.0, 0.0), (1.0, 27e6))
    assert gear.tension == gear.compression
    assert (gear.slack, gear.maximum_stroke) == (0.0, math.inf)
    assert (gear.bottoming_stiffness, gear.solid_stiffness) == (0.0, 0.0)


def test_a_preload_is_given_back_in_the_ratio_of_the_stiffnesses() -> None:
    gear = _gear(loading_stiffness_kN_per_mm=30, unloading_stiffness_kN_per_mm=15, preload_kN=200)
    assert gear.compression.loading == ((0.0, 200e3), (1.0, 200e3 + 30e6))
    assert gear.compression.unloading == ((0.0, 100e3), (1.0, 100e3 + 15e6))
    assert gear.solid_stiffness == DEFAULT_SOLID_STIFFNESS


def test_a_given_solid_stiffness_is_used() -> None:
    gear = _gear(
        loading_stiffness_kN_per_mm=30, unloading_stiffness_kN_per_mm=15, preload_kN=200, solid_stiffness_kN_per_mm=100
    )
    assert gear.solid_stiffness == 100e6


def test_tables_are_in_mm_and_kn_and_may_differ_in_tension() -> None:
    gear = _gear(
        loading=[[0, 10], [50, 500], [80, 2000]],
        unloading=[[0, 5], [80, 400]],
        tension={"loading_stiffness_kN_per_mm": 20, "unloading_stiffness_kN_per_mm": 20},
        slack_mm=12,
        maximum_stroke_mm=80,
        bottoming_stiffness_kN_per_mm=500,
    )
    assert gear.compression.loading == ((0.0, 10e3), (0.05, 500e3), (0.08, 2000e3))
    assert gear.tension.loading == ((0.0, 0.0), (1.0, 20e6))
    assert (gear.slack, gear.maximum_stroke, gear.bottoming_stiffness) == (0.012, 0.08, 500e6)
    assert gear.solid_stiffness == DEFAULT_SOLID_STIFFNESS


def test_a_gear_without_hysteresis_is_allowed() -> None:
    table = [[0, 0], [3, 7], [70, 1000.1]]
    gear = _gear(loading=table, unloading=[[0, 0], [1.5, 3.5], [3, 7], [70, 1000.1]])
    assert gear.compression.loading[-1] == gear.compression.unloading[-1]


@pytest.mark.parametrize(
    ("loading", "unloading", "expected"),
    [
        ([[1, 0], [2, 1]], [[0, 0], [2, 1]], "couplers.G.loading.0.0 = 1, the first stroke must be 0"),
        ([[0, 0], [2, 1], [2, 3]], [[0, 0], [2, 1]], "couplers.G.loading.2.0 = 2, strokes must rise: must be above 2"),
        ([[0, 0], [2, 9], [3, 8]], [[0, 0], [2, 1]], "loading.2.1 = 8, forces must not fall: must be at least 9"),
        ([[0, 0], [2, 9]], [[0, 0], [2, 0]], "couplers.G.unloading.1.1 = 0, the last force must be above 0"),
        ([[0, 0], [9, 9]], [[0, 0], [5, 6], [9, 7]], "unloading: at stroke 5 mm it is 6 kN, above loading, 5 kN"),
        ([[0, 0], [5, 4], [9, 9]], [[0, 0], [9, 9]], "unloading: at stroke 5 mm it is 5 kN, above loading, 4 kN"),
        ([[0, 0], [5, 80], [9, 84]], [[0, 0], [9, 80]], "at stroke 19.0141 mm it is 169.014 kN, above loading"),
        # The last slopes, 10 and 40 kN/mm, cross at 2 mm + 70 / (40 - 10) mm.
        ([[0, 0], [1, 100], [2, 110]], [[0, 0], [1, 0], [2, 40]], "at stroke 8.66667 mm it is 306.667 kN, above load"),
    ],
)
def test_curves_that_no_gear_can_have_are_refused(
    loading: list[list[float]], unloading: list[list[float]], expected: str
) -> None:
    with pytest.raises(ScenarioError) as caught:
        _gear(loading=loading, unloading=unloading)
    assert expected in str(caught.value)


def test_unloading_stiffer_than_loading_is_refused_also_in_tension() -> None:
    side = {"loading_stiffness_kN_per_mm": 30, "unloading_stiffness_kN_per_mm": 31}
    with pytest.raises(ScenarioError, match=r"tension.unloading_stiffness_kN_per_mm = 31, must be at most .*, 30$"):
        _gear(loading_stiffness_kN_per_mm=30, unloading_stiffness_kN_per_mm=27, tension=side)


def test_unloading_steeper_than_the_solid_part_of_a_preloaded_gear_is_no_error() -> None:
    # 698 kN/mm on 250 kN/mm by default: the solid part holds, see `haul_ros.physics.hinges`.
    gear = _gear(loading=[[0, 300], [1, 400]], unloading=[[0, 1], [0.5, 350], [1, 400]])
    assert steepest_slope(gear) == DEFAULT_SOLID_STIFFNESS
