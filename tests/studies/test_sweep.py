from __future__ import annotations

import numpy as np
import pytest

from haul_ros.errors import HaulError
from haul_ros.studies.errors import StudyError
from haul_ros.studies.sweep import Draw, Sweep, list_axis, range_values, variants_axis

MASS = "vehicles.C80.mass_t"


def sweep(short: str, *axes: object, **more: object) -> Sweep:
    return Sweep("test", "", (short,), axes=axes, **more)  # type: ignore[arg-type]


def test_cases_are_all_combinations_the_last_axis_fastest(short: str) -> None:
    study = sweep(short, list_axis("a", [1, 2]), list_axis("b", [0.5, 1.5, 2.5]))
    cases = list(study.cases())
    assert [case.name for case in cases][:4] == ["a=1, b=0.5", "a=1, b=1.5", "a=1, b=2.5", "a=2, b=0.5"]
    assert len(cases) == len(study) == 6
    assert cases[3].overrides == cases[3].values == {"a": 2, "b": 0.5}


def test_several_scenarios_are_named_in_their_cases() -> None:
    study = Sweep("test", "", ("daqin_1_2_1", "some/folder/other.yaml"), axes=(list_axis("a", [1]),))
    assert [case.name for case in study.cases()] == ["daqin_1_2_1, a=1", "other, a=1"]


def test_variants_set_several_keys_and_later_axes_win_over_fixed_values(short: str) -> None:
    study = sweep(short, variants_axis("kind", {"soft": {"x": 1, "y": 2}, "plain": {}}), overrides={"x": 9, "z": 3})
    soft, plain = study.cases()
    assert soft.overrides == {"x": 1, "y": 2, "z": 3}
    assert plain.overrides == {"x": 9, "z": 3}
    assert soft.values == {"kind": "soft", "x": 1, "y": 2}


@pytest.mark.parametrize(
    ("first", "last", "step", "count", "expected"),
    [
        (40, 100, 20, None, [40, 60, 80, 100]),
        (0.1, 0.5, 0.1, None, [0.1, 0.2, 0.3, 0.4, 0.5]),
        (0, 1, 0.3, None, [0, 0.3, 0.6, 0.9]),
        (5, 1, -2, None, [5, 3, 1]),
        (3, 3, 1, None, [3]),
        (0, 1, None, 5, [0, 0.25, 0.5, 0.75, 1]),
    ],
)
def test_ranges_include_both_ends(
    first: float, last: float, step: float | None, count: int | None, expected: list[float]
) -> None:
    assert range_values("k", first, last, step, count) == expected


@pytest.mark.parametrize(
    ("first", "last", "step", "count", "message"),
    [
        (100, 40, 20, None, r"over k: from 100 to 40 by 20: an empty range"),
        (0, 1, 0, None, "an empty range"),
        (0, 1, None, None, "expected a step or a count"),
        (0, 1, 0.1, 3, "expected a step or a count"),
        (0, 1, None, 1, "must be 2 or more"),
        (0, float("inf"), 1, None, "must be finite"),
        (0, 1, 1e-9, None, "more than 1000000 values"),
        (0, 1e308, 1e-308, None, "more than 1000000 values"),
    ],
)
def test_ranges_that_are_none_are_refused(
    first: float, last: float, step: float | None, count: int | None, message: str
) -> None:
    with pytest.raises(StudyError, match=message):
        range_values("k", first, last, step, count)


def test_an_empty_list_is_refused() -> None:
    with pytest.raises(StudyError, match="over k: no values"):
        list_axis("k", [])


def test_samples_depend_on_the_seed_alone_and_more_of_them_begin_with_the_same(short: str) -> None:
    def drawn(samples: int, seed: int, *more: Draw) -> list[object]:
        draws = (Draw(MASS, "normal", (100, 3)), *more)
        return [case.overrides[MASS] for case in sweep(short, draws=draws, samples=samples, seed=seed).cases()]

    assert drawn(5, 1) == drawn(9, 1)[:5] == drawn(5, 1, Draw("b", "uniform", (0, 1)))
    assert drawn(5, 1) != drawn(5, 2)


def test_draws_have_the_laws_asked_for(short: str) -> None:
    draws = (Draw("a", "normal", (100, 3)), Draw("b", "uniform", (2, 6)))
    values = np.array([list(case.overrides.values()) for case in sweep(short, draws=draws, samples=4000).cases()])
    np.testing.assert_allclose(values.mean(axis=0), [100, 4], rtol=0.01)
    np.testing.assert_allclose(values.std(axis=0), [3, 4 / np.sqrt(12)], rtol=0.05)
    assert 2 <= values[:, 1].min() < values[:, 1].max() <= 6


def test_every_combination_has_the_same_samples(short: str) -> None:
    draws = (Draw(MASS, "uniform", (90, 110)),)
    cases = list(sweep(short, list_axis("initial_speed_kmh", [20, 30]), draws=draws, samples=3).cases())
    assert len(cases) == 6
    assert [case.overrides[MASS] for case in cases[:3]] == [case.overrides[MASS] for case in cases[3:]]
    assert cases[5].values["sample"] == 3


@pytest.mark.parametrize(
    ("law", "parameters", "message"),
    [("uniform", (2.0, 1.0), "must not be below"), ("normal", (1.0, -1.0), "standard deviation -1"),
     ("normal", (float("nan"), 1.0), "finite")],
)  # fmt: skip
def test_laws_that_are_none_are_refused(law: str, parameters: tuple[float, float], message: str) -> None:
    with pytest.raises(StudyError, match=f"draw k: .*{message}"):
        Draw("k", law, parameters)


@pytest.mark.parametrize(
    ("key", "values", "message"),
    [
        ("initial_sped_kmh", [20], "unknown key, did you mean initial_speed_kmh"),
        ("initial_speed_kmh", [20, -5, 30], "initial_speed_kmh = -5"),
        ("initial_speed_kmh", list(range(20, 230)), "initial_speed_kmh = 229"),
        ("couplers.MT-2.slack_mm", [1], "not used by this scenario"),
    ],
)
def test_keys_and_values_that_cannot_be_are_found_before_anything_runs(
    short: str, key: str, values: list[object], message: str
) -> None:
    with pytest.raises(HaulError, match=message):
        sweep(short, list_axis("max_duration_s", [10, 20]), list_axis(key, values)).check()
