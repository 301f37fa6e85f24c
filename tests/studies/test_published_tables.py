"""The tables beside the pictures of studies are what the program computes, and the page says what they have."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from haul_ros.studies.definition import load_study
from haul_ros.studies.kinds.rigid_arm_map import TIME, WAVE
from haul_ros.studies.pools import local_pool
from haul_ros.studies.study import run_study
from haul_ros.studies.sweep import Axis, Sweep

ROOT = Path(__file__).parents[2]
PAGE = " ".join((ROOT / "docs/studies.md").read_text("utf-8").split())

SAME = 1e-6
"""Relative, of peaks: other machines round otherwise."""


def table(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def published(name: str) -> list[dict[str, str]]:
    return table(ROOT / "docs" / "studies" / f"{name}.csv")


def peaks(rows: list[dict[str, str]]) -> list[float]:
    return [float(row["max_force_kN"]) for row in rows]


def effects(rows: list[dict[str, str]]) -> Mapping[tuple[str, float, float], float]:
    """Change of the largest draft gear force by pairs [%], by gear, wave speed [m/s] and build-up time [s]."""
    by_place: dict[tuple[str, float, float], dict[str, float]] = {}
    for row in rows:
        wave, time = (float(row[f"brake_systems.paper_set_b.{key}"]) for key in (WAVE, TIME))
        by_place.setdefault((row["coupler"], wave, time), {})[row["wagons"]] = float(row["max_draft_gear_force_kN"])
    return {place: (forces["pairs"] / forces["single"] - 1.0) * 100.0 for place, forces in by_place.items()}


def thinned(study: Sweep, values: Mapping[str, tuple[float, ...]]) -> Sweep:
    """With these values alone of the axes whose names end so."""

    def axis(old: Axis) -> Axis:
        kept = next((kept for end, kept in values.items() if old.name.endswith(end)), None)
        return old if kept is None else Axis(old.name, tuple(p for p in old.points if p.values[old.name] in kept))

    return replace(study, axes=tuple(map(axis, study.axes)))


@pytest.fixture(scope="module")
def effect() -> Mapping[tuple[str, float, float], float]:
    return effects(published("rigid-arm-map"))


def test_the_map_has_the_sign_that_build_up_and_wave_speed_give_it(
    effect: Mapping[tuple[str, float, float], float],
) -> None:
    # Slow build-up: the longer spring wave of joined wagons smooths. A braking wave near the elastic wave of the pairs
    # (294 m/s; 208 m/s of single wagons, physics of the paper's train): they add up.
    assert {gear for gear, _, _ in effect} == {"paper_set_a", "paper_set_b"}
    assert len(effect) == 2 * 7 * 7
    assert all(change < -5.0 for (_, _, time), change in effect.items() if time >= 3.0)
    assert all(change > 5.0 for (_, wave, time), change in effect.items() if wave >= 250.0 and time <= 1.5)
    assert effect["paper_set_b", 220.0, 2.0] < 0.0 < effect["paper_set_a", 250.0, 1.0]


def test_the_readme_says_of_the_map_what_its_table_has(effect: Mapping[tuple[str, float, float], float]) -> None:
    def lower(gear: str) -> str:
        found: NDArray[np.float64] = np.array([change for (name, _, _), change in effect.items() if name == gear])
        return f"in {(found < 0.0).sum()} of {len(found)}"

    b, a = lower("paper_set_b"), lower("paper_set_a")
    low, high = min(effect.values()), max(effect.values())
    assert f"{b} places of brake wave speed and build-up time with the draft gear of set B, {a} with" in PAGE
    assert f"from {low:.0f} to {high:+.0f} %" in PAGE


def test_the_readme_says_of_marshalling_and_monte_carlo_what_their_tables_have() -> None:
    combined, quarters, head = peaks(published("marshalling"))
    assert f"1+2+1 {combined:.0f} kN, 4 x 5000 t {quarters:.0f} kN, 1+1+0 {head:.0f} kN" in PAGE
    low, median, high = np.quantile(peaks(published("monte-carlo")), (0.05, 0.5, 0.95))
    assert f"median {median:.0f} kN, 5 to 95 % of the trains {low:.0f} to {high:.0f} kN" in PAGE


@pytest.mark.slow
def test_corners_of_the_map_are_those_of_the_table(
    tmp_path: Path, effect: Mapping[tuple[str, float, float], float]
) -> None:
    study = thinned(load_study("rigid-arm-map"), {WAVE: (180, 300), TIME: (0.5, 6)})
    outcome = run_study(study, tmp_path, local_pool)
    found = effects(table(tmp_path / "rigid-arm-map.csv"))
    assert len(found) == 8
    assert found == pytest.approx({place: effect[place] for place in found}, abs=SAME * 100.0)
    lower = [
        sum(change < 0.0 for (name, _, _), change in found.items() if name == gear)
        for gear in ("paper_set_b", "paper_set_a")
    ]
    assert [claim.found.partition(",")[0] for claim in outcome.claims] == [f"in {n} of 4 places" for n in lower]
    assert outcome.files[-1].name == "rigid-arm-map.png"


@pytest.mark.slow
def test_marshalling_and_the_first_samples_are_those_of_the_tables(tmp_path: Path) -> None:
    run_study(load_study("marshalling"), tmp_path, local_pool)
    assert peaks(table(tmp_path / "marshalling.csv")) == pytest.approx(peaks(published("marshalling")), rel=SAME)
    run_study(replace(load_study("monte-carlo"), samples=3), tmp_path, local_pool)
    assert peaks(table(tmp_path / "monte-carlo.csv")) == pytest.approx(peaks(published("monte-carlo"))[:3], rel=SAME)
