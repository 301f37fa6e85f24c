from __future__ import annotations

import math

import numpy as np
import pytest

from haul_ros.scenario import load_scenario
from haul_ros.simulation.batch import periods
from haul_ros.simulation.session import Session
from haul_ros.studies.case import Case, CaseResult, key, simulate


def test_a_case_has_the_peaks_of_the_same_run_sample_by_sample_bit_for_bit() -> None:
    scenario = load_scenario("daqin_1_2_1_rigid_pairs", {"initial_speed_kmh": 20})
    session = Session(scenario, play_commands=True)
    for _ in periods(session):
        pass
    result = simulate(scenario)
    np.testing.assert_array_equal(result.extremes.compression, session.extremes().compression)
    np.testing.assert_array_equal(result.extremes.tension, session.extremes().tension)
    np.testing.assert_array_equal(result.stroke, np.maximum(
        session.extremes().compression_stroke, session.extremes().tension_stroke))  # fmt: skip
    assert result.stop_time == session.stop_time
    assert result.distance == session.travelled
    assert result.gear_force == result.force[result.geared].max()
    assert not result.geared.all()


def test_a_result_survives_bytes_bit_for_bit(short: str) -> None:
    result = simulate(load_scenario(short))
    again = CaseResult.from_bytes(result.to_bytes())
    np.testing.assert_array_equal(again.force, result.force)
    np.testing.assert_array_equal(again.extremes.bottomed_time, result.extremes.bottomed_time)
    np.testing.assert_array_equal(again.geared, result.geared)
    np.testing.assert_array_equal(again.locomotives, [0, 11])
    assert (again.stop_time, again.distance) == (result.stop_time, result.distance)
    assert again.relative_imbalance == result.relative_imbalance


def test_bytes_that_are_no_result_are_refused() -> None:
    with pytest.raises(ValueError, match="not a result"):
        CaseResult.from_bytes(b"PK\x03\x04 cut off")


def test_a_train_that_does_not_stop_has_no_stop_time_and_ends_at_the_longest_duration(short: str) -> None:
    result = simulate(load_scenario(short, {"commands": [], "max_duration_s": 2.5}))
    assert math.isnan(result.stop_time)
    assert result.distance == pytest.approx(2.5 * 30 / 3.6, rel=0.01)


def test_the_key_changes_with_any_value_and_not_with_the_name(short: str) -> None:
    def key_of(name: str, overrides: dict[str, object]) -> str:
        return key(Case(name, short, overrides, {}).load())

    assert key_of("a", {}) == key_of("b", {"initial_speed_kmh": 30})
    assert key_of("a", {}) != key_of("a", {"initial_speed_kmh": 31})
    assert key_of("a", {}) != key_of("a", {"couplers.paper_set_b.transition_speed_mps": 0.011})
