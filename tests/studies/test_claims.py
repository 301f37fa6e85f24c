"""Judges on made-up results, where it is known what holds; the numbers of the paper are in test_studies."""

from __future__ import annotations

import numpy as np
import pytest

from haul_ros.model.sample import CouplerExtremes
from haul_ros.studies import claims
from haul_ros.studies.case import CaseResult
from haul_ros.studies.sweep import PaperValues


def result(force: object, stroke: float = 0.02, geared: object = None) -> CaseResult:
    """A result of the given compression envelope [kN]."""
    compression = np.asarray(force, dtype=float) * 1e3
    n = len(compression)
    none = np.zeros(n)
    extremes = CouplerExtremes(compression, none, none, none, np.full(n, stroke), none, np.full(n, np.nan))
    mask = np.ones(n, dtype=bool) if geared is None else np.asarray(geared)
    return CaseResult(extremes, mask, np.array([0, 103, 104, 207]), 40.0, 500.0, 0.0, 0)


def holding(found: list[claims.Claim]) -> list[bool | None]:
    return [claim.holds for claim in found]


@pytest.mark.parametrize(("peaks", "holds"), [([780, 740, 700], True), ([780, 700, 740], False)])
def test_initial_speed_wants_the_peak_to_fall(peaks: list[float], holds: bool) -> None:
    cases = {str(n): result([1, p, 2]) for n, p in enumerate(peaks)}
    assert holding(claims.initial_speed(cases, {"0": PaperValues(force=700e3)})) == [False, holds]


def test_a_number_holds_within_three_percent() -> None:
    for force, holds in ((720, True), (722, False), (680, True), (678, False)):
        first, _ = claims.initial_speed({"a": result([force])}, {"a": PaperValues(force=700e3)})
        assert first.holds is holds
        assert f"{force}.0 kN" in first.found


@pytest.mark.parametrize(("peaks", "holds"), [([1, 2, 3], True), ([1, 3, 2], False), ([1, 1, 2], False)])
def test_synchronisation_wants_the_peak_to_rise(peaks: list[float], holds: bool) -> None:
    assert holding(claims.synchronisation({str(n): result([p]) for n, p in enumerate(peaks)}, {})) == [holds]


def test_stiffness_wants_more_force_and_less_stroke() -> None:
    rising = {"a": result([600], 0.03), "b": result([700], 0.02)}
    assert holding(claims.stiffness(rising, {})) == [True, True]
    assert holding(claims.stiffness(dict(reversed(rising.items())), {})) == [False, False]


def test_rigid_arms_compare_draft_gears_and_tell_the_bars_apart() -> None:
    single = result([700, 650, 600])
    pairs = result([900, 650, 600], geared=[False, True, True], stroke=0.019)
    cases = {"set B, single": single, "set B, pairs": pairs, "set B, threes": result([701, 1, 1], 0.01)}
    found = claims.rigid_arms(cases, {})
    assert holding(found) == [True, False]
    assert "650.0 kN (-7.1 %)" in found[0].found
    assert "rigid bars 900.0 kN" in found[0].found


def test_the_map_counts_where_pairs_lower_the_force() -> None:
    cases = {
        "B, v=1, single": result([100]), "B, v=1, pairs": result([90]),
        "B, v=2, single": result([100]), "B, v=2, pairs": result([120]),
    }  # fmt: skip
    (claim,) = claims.rigid_arm_map(cases, {})
    assert claim.holds is False
    assert "in 1 of 2 places, from -10.0 % to +20.0 %" in claim.found


def test_distribution_wants_equal_quarters_and_minima_mid_way() -> None:
    along = np.arange(207)
    force = 700 * np.abs(np.sin(along / 206 * 4 * np.pi))
    text = {"a": PaperValues(force=700e3, stroke=0.025)}
    assert holding(claims.distribution({"a": result(force)}, text)) == [True] * 4
    assert holding(claims.distribution({"a": result(700 * along / 206, 0.03)}, text)) == [True, False, False, False]


def test_validation_wants_the_peak_at_two_thirds_and_least_at_the_ends() -> None:
    text = {"a": PaperValues(force=1050e3, position=0.66)}
    n = 122
    x = np.arange(1, n + 1) / (n + 1)
    assert holding(claims.validation({"a": result(1050 - 1500 * np.abs(x - 0.66))}, text)) == [True, True, False]
    assert holding(claims.validation({"a": result(800 * np.sin(np.pi * x))}, text)) == [False, False, True]


def test_a_claim_reads_as_one_line() -> None:
    assert str(claims.Claim("the peak falls", True, "by 3 %")) == "holds: the peak falls: by 3 %"
    assert str(claims.Claim("the peak falls", False, "no")) == "does not hold: the peak falls: no"
