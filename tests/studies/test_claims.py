"""Judges on made-up results, where it is known what holds; the numbers of the paper are in test_studies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from haul_ros.model.sample import CouplerExtremes
from haul_ros.studies.case import CaseResult, Finished
from haul_ros.studies.claims import Claim
from haul_ros.studies.kinds.along_train import distribution, validation
from haul_ros.studies.kinds.kind import Results
from haul_ros.studies.kinds.rigid_arm_map import rigid_arm_map
from haul_ros.studies.kinds.rigid_arms import rigid_arms
from haul_ros.studies.kinds.series import initial_speed, stiffness, synchronisation
from haul_ros.studies.sweep import Axis, PaperValues, Sweep, list_axis, variants_axis


def result(force: object, stroke: float = 0.02, geared: object = None) -> CaseResult:
    """A result of the given compression envelope [kN]."""
    compression = np.asarray(force, dtype=float) * 1e3
    n = len(compression)
    none = np.zeros(n)
    extremes = CouplerExtremes(compression, none, none, none, np.full(n, stroke), none, np.full(n, np.nan))
    mask = np.ones(n, dtype=bool) if geared is None else np.asarray(geared)
    return CaseResult(extremes, mask, np.array([0, 103, 104, 207]), 40.0, 500.0, 0.0, 0)


def holding(found: list[Claim]) -> list[bool | None]:
    return [claim.holds for claim in found]


def made_up(*axes: Axis, paper: PaperValues | None = None) -> Sweep:
    return Sweep("made up", "", ("train",), axes=axes, paper=() if paper is None else (paper,))


def finished(study: Sweep, *results: CaseResult) -> Results:
    return [Finished(case, result) for case, result in zip(study.cases(), results, strict=True)]


SPEEDS = list_axis("initial_speed_kmh", [40, 60, 80])
DELAYS = list_axis("radio.default.delay_s", [0, 1, 2])
LOADING = "couplers.ST.loading_stiffness_kN_per_mm"
GEARS = variants_axis("gear", {"a": {LOADING: 20}, "b": {LOADING: 9}})
WAGONS = variants_axis("wagons", {"single": {}, "pairs": {"consist.1.drawbar_group": 2}})
THREES = variants_axis("wagons", {"single": {}, "pairs": {"x": 2}, "threes": {"x": 3}})


@pytest.mark.parametrize(("peaks", "holds"), [([780, 740, 700], True), ([780, 700, 740], False)])
def test_initial_speed_wants_the_peak_to_fall(peaks: list[float], holds: bool) -> None:
    study = made_up(SPEEDS, paper=PaperValues({"initial_speed_kmh": 40}, force=700e3))
    assert holding(initial_speed(study, finished(study, *(result([1, p, 2]) for p in peaks)))) == [False, holds]


def test_a_number_holds_within_three_percent() -> None:
    study = made_up(SPEEDS, paper=PaperValues({"initial_speed_kmh": 60}, force=700e3))
    for force, holds in ((720, True), (722, False), (680, True), (678, False)):
        first, _ = initial_speed(study, finished(study, result([1]), result([force]), result([1])))
        assert first.holds is holds
        assert first.text == "initial_speed_kmh=60 about 700 kN"
        assert f"{force}.0 kN" in first.found


@pytest.mark.parametrize(("peaks", "holds"), [([1, 2, 3], True), ([1, 3, 2], False), ([1, 1, 2], False)])
def test_synchronisation_wants_the_peak_to_rise(peaks: list[float], holds: bool) -> None:
    study = made_up(DELAYS)
    assert holding(synchronisation(study, finished(study, *(result([p]) for p in peaks)))) == [holds]


def test_stiffness_wants_more_force_and_less_stroke_of_the_stiffer_gear_wherever_it_stands() -> None:
    study = made_up(GEARS)
    stiff, soft = result([700], 0.02), result([600], 0.03)
    assert holding(stiffness(study, finished(study, stiff, soft))) == [True, True]
    assert holding(stiffness(study, finished(study, soft, stiff))) == [False, False]


def test_rigid_arms_compare_draft_gears_and_tell_the_bars_apart() -> None:
    study = made_up(variants_axis("parameters", {"set B": {"y": 1}}), THREES)
    single = result([700, 650, 600])
    pairs = result([900, 650, 600], geared=[False, True, True], stroke=0.019)
    found = rigid_arms(study, finished(study, single, pairs, result([701, 1, 1], 0.01)))
    assert holding(found) == [True, False]
    assert found[0].text == "set B: wagons in pairs have smaller forces and strokes"
    assert "650.0 kN (-7.1 %)" in found[0].found
    assert "rigid bars 900.0 kN" in found[0].found


def test_rigid_arms_of_several_trains_are_compared_within_each() -> None:
    study = Sweep("made up", "", ("long", "short"), axes=(WAGONS,))
    found = rigid_arms(study, finished(study, *(result([force], 1 / force) for force in (9, 8, 2, 3))))
    assert [(claim.text.partition(":")[0], claim.holds) for claim in found] == [("long", False), ("short", False)]
    assert ["(-11.1 %)" in found[0].found, "(+50.0 %)" in found[1].found] == [True, True]


def test_the_map_counts_where_pairs_lower_the_force() -> None:
    waves = list_axis("brake_systems.x.wave_speeds.emergency_mps", [200, 300])
    times = list_axis("brake_systems.x.build_up.full_time_s", [1])
    study = made_up(variants_axis("gear", {"B": {"coupler": "ST"}}), waves, times, WAGONS)
    (claim,) = rigid_arm_map(study, finished(study, *(result([force]) for force in (100, 90, 100, 120))))
    assert claim.holds is False
    assert claim.text == "B: pairs lower the force everywhere on the map"
    assert "in 1 of 2 places, from -10.0 % to +20.0 %" in claim.found


def test_distribution_wants_equal_quarters_and_minima_mid_way() -> None:
    along = np.arange(207)
    force = 700 * np.abs(np.sin(along / 206 * 4 * np.pi))
    study = made_up(paper=PaperValues(force=700e3, stroke=0.025))
    assert holding(distribution(study, finished(study, result(force)))) == [True] * 4
    rising = result(700 * along / 206, 0.03)
    assert holding(distribution(study, finished(study, rising))) == [True, False, False, False]


def test_a_train_too_short_for_quarters_or_without_wagons_between_locomotives_decides_nothing() -> None:
    study = made_up(paper=PaperValues(force=700e3, stroke=0.025))
    short = replace(result([700, 600, 500]), locomotives=np.array([0, 1]))
    assert holding(distribution(study, finished(study, short))) == [True, True, None, None]


def test_trains_without_any_force_are_no_division_by_zero() -> None:
    study, none = made_up(THREES), result([0] * 207, 0.0)
    assert "0.0 kN (+0.0 %)" in rigid_arms(study, finished(study, none, none, none))[0].found
    assert "1.0 kN (+inf %)" in rigid_arms(study, finished(study, none, result([1]), none))[0].found
    single = made_up(paper=PaperValues(force=700e3, stroke=0.025))
    assert "0.0/0.0/0.0/0.0 kN, apart by 0.0 %" in distribution(single, finished(single, none))[2].found


def test_validation_wants_the_peak_at_two_thirds_and_least_at_the_ends() -> None:
    study = made_up(paper=PaperValues(force=1050e3, position=0.66))
    n = 122
    x = np.arange(1, n + 1) / (n + 1)
    peaked, arched = result(1050 - 1500 * np.abs(x - 0.66)), result(800 * np.sin(np.pi * x))
    assert holding(validation(study, finished(study, peaked))) == [True, True, False]
    assert holding(validation(study, finished(study, arched))) == [False, False, True]


def test_a_claim_reads_as_one_line() -> None:
    assert str(Claim("the peak falls", True, "by 3 %", fitted=True)) == "reproduced (fitted): the peak falls: by 3 %"
    assert str(Claim("the peak falls", True, "by 3 %")) == "predicted: the peak falls: by 3 %"
    assert str(Claim("the peak falls", False, "no", fitted=True)) == "contradicted: the peak falls: no"
    assert str(Claim("the peaks", None, "some")) == "result: the peaks: some"


def test_a_claim_is_fitted_where_its_case_was_in_the_fit() -> None:
    axes = (variants_axis("parameters", {"B": {"y": 1}, "A": {"y": 2}}), THREES)
    study = replace(made_up(*axes), fitted=({"parameters": "B", "wagons": "pairs"},))
    found = rigid_arms(study, finished(study, *(result([700 - n], 0.02 - n / 1e3) for n in range(6))))
    assert [claim.fitted for claim in found] == [True, False, False, False]
    assert [
        claim.fitted for claim in synchronisation(made_up(DELAYS), finished(made_up(DELAYS), *[result([1])] * 3))
    ] == [False]
