"""Kinds of studies: what they need, that they go by values and not by names, and files of one's own."""

from __future__ import annotations

import json
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Annotation

from haul_ros.errors import HaulError
from haul_ros.model.sample import CouplerExtremes
from haul_ros.resources import config_dir
from haul_ros.studies.case import Case, CaseResult, Finished
from haul_ros.studies.definition import load_study
from haul_ros.studies.figures import point_label, profiles_figure
from haul_ros.studies.kinds.rigid_arm_map import fitted_set, map_figure
from haul_ros.studies.kinds.table import KINDS
from haul_ros.studies.pools import local_pool
from haul_ros.studies.study import run_study
from haul_ros.studies.sweep import Axis, PaperValues, Point, Sweep, list_axis, variants_axis

ARMS = "consist.1.drawbar_group: 2"
WAVES = "brake_systems.paper_set_b.wave_speeds.emergency_mps"
TIMES = "brake_systems.paper_set_b.build_up.full_time_s"


def made_up(case: Case) -> Finished[CaseResult]:
    """A result by chance that depends on what the case sets, and on nothing else of it."""
    setting = json.dumps([case.scenario, dict(case.overrides)], sort_keys=True)
    force = np.random.default_rng(zlib.crc32(setting.encode())).uniform(5e5, 9e5, 207)
    none = np.zeros(207)
    extremes = CouplerExtremes(force, none, none, none, force / 3e7, none, np.full(207, np.nan))
    return Finished(case, CaseResult(extremes, force < 8e5, np.array([0, 103, 104, 207]), 40.0, 500.0, 0.0, 0))


def conclude(study: Sweep) -> list[tuple[bool | None, str]]:
    kind = KINDS[study.kind]
    kind.check(study)
    if kind.compute is None:
        finished = [made_up(case) for case in study.cases()]
        return sorted((claim.holds, claim.found) for claim in kind.conclude(study, finished).claims)
    computed = [Finished(case, kind.compute(case)) for case in study.cases()]
    return sorted((claim.holds, claim.found) for claim in kind.conclude(study, computed).claims)


def relabelled(axis: Axis) -> Axis:
    """The same points, the last one first, under other names."""

    def point(number: int, old: Point) -> Point:
        name = f"{number}, single"
        return Point(name, {**old.values, **({} if axis.name in old.overrides else {axis.name: name})}, old.overrides)

    return Axis(axis.name, tuple(point(number, old) for number, old in enumerate(reversed(axis.points))))


@pytest.mark.parametrize(
    "name", ["initial-speed", "synchronisation", "stiffness", "rigid-arms", "rigid-arm-map", "vibration"]
)
def test_other_names_in_another_order_change_no_verdict(name: str) -> None:
    study = load_study(name)
    other = replace(study, axes=tuple(map(relabelled, study.axes)))
    assert {case.name for case in other.cases()}.isdisjoint(case.name for case in study.cases())
    found = conclude(study)
    assert found
    assert conclude(other) == found


@pytest.mark.parametrize("name", ["rigid-arms", "rigid-arm-map"])
def test_another_order_of_the_axes_changes_no_verdict(name: str) -> None:
    study = load_study(name)
    assert conclude(replace(study, axes=study.axes[::-1])) == conclude(study)


def test_the_schema_lists_every_kind() -> None:
    schema = json.loads((config_dir() / "schema" / "study.schema.json").read_text("utf-8"))
    assert schema["properties"]["kind"]["enum"] == list(KINDS)


@pytest.mark.parametrize(
    ("kind", "text", "message"),
    [
        ("validation", "paper: [{force_kN: 700}]", "kind validation: expected position in paper, for its case"),
        ("distribution", "", "kind distribution: expected force_kN and stroke_mm in paper, for its case"),
        ("distribution", "over: {initial_speed_kmh: [20, 30]}", "kind distribution: expected one case, not 2"),
        ("initial_speed", "", "kind initial_speed: expected several cases that differ in initial_speed_kmh"),
        ("initial_speed", "over: {initial_speed_kmh: [20]}", "expected several cases"),
        ("initial_speed", "over: {initial_speed_kmh: [20, 20]}", "each with a number of its own"),
        ("initial_speed", "over: {initial_speed_kmh: [20, fast]}", "each with a number of its own"),
        ("initial_speed", "over: {initial_speed_kmh: [20, 30], a: [1, 2]}", "each with a number of its own"),
        ("initial_speed", "draw: {initial_speed_kmh: {uniform: [1, 2]}}\nsamples: 2", "expected no draw"),
        ("synchronisation", "over: {radio.default.delay_s: [1, 2]}", "expected a case with radio.default.delay_s = 0"),
        ("stiffness", "over: {gear: {a: {}, b: {couplers.x.loading_stiffness_kN_per_mm: 2}}}", "several cases"),
        ("rigid_arms", "", "kind rigid_arms: expected wagons (over) with one variant that sets nothing ({})"),
        ("rigid_arms", "over: {wagons: {single: {}}}", "and others beside it"),
        ("rigid_arms", f"over: {{wagons: {{a: {{}}, b: {{}}, c: {{{ARMS}}}}}}}", "one variant that sets nothing"),
        ("rigid_arms", f"over: {{wagons: {{a: {{}}, b: {{{ARMS}}}}}, consist.1.drawbar_group: [1, 2]}}", "wagons sets"),
        ("rigid_arms", "draw: {a: {uniform: [1, 2]}}\nsamples: 2", "kind rigid_arms: expected no draw"),
        ("rigid_arm_map", f"over: {{wagons: {{a: {{}}, b: {{{ARMS}}}}}}}", "expected brake_systems.*.wave_speeds"),
        ("rigid_arm_map", f"over: {{{WAVES}: [200, 220], wagons: {{a: {{}}, b: {{{ARMS}}}}}}}", "full_time_s among"),
        (
            "rigid_arm_map",
            f"over: {{{WAVES}: [9], {TIMES}: [1], wagons: {{a: {{}}, b: {{{ARMS}}}, c: {{x: 2}}}}}}",
            "expected two variants of wagons, single and joined",
        ),
        ("vibration", "over: {vehicles.C80.mass_t: [80, 90]}", "expected vehicles.C80.mass_t (over) with one variant"),
        ("comparison", "draw: {a: {uniform: [1, 2]}}\nsamples: 2", "kind comparison: expected no draw"),
    ],
)  # fmt: skip
def test_a_study_that_lacks_what_its_kind_needs_is_refused_when_loaded(
    tmp_path: Path, kind: str, text: str, message: str
) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(f"kind: {kind}\nscenario: daqin_1_2_1\n{text}\n", "utf-8")
    with pytest.raises(HaulError) as caught:
        load_study(str(path))
    assert str(caught.value).startswith(f"{path}: kind {kind}: ")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_vibrations_of_two_scenarios_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("kind: vibration\nscenarios: [daqin_1_2_1, daqin_1_1_0]\n", "utf-8")
    with pytest.raises(HaulError, match="kind vibration: expected one scenario, not 2"):
        load_study(str(path))


def test_one_s_own_train_is_judged_by_kind(tmp_path: Path, short: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(
        f"kind: rigid_arms\nscenario: {short}\nover: {{wagons: {{joined: {{{ARMS}}}, loose: {{}}}}}}\n", "utf-8"
    )
    outcome = run_study(load_study(str(path)), tmp_path / "out", local_pool)
    (claim,) = outcome.claims
    assert claim.text == "wagons in joined have smaller forces and strokes"
    assert claim.holds is not None
    assert outcome.files[-1].name == "mine.png"


def test_vibrations_of_one_s_own_train_are_compared_by_what_differs(tmp_path: Path, short: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(
        f"kind: vibration\nscenario: {short}\nover:\n  train:\n"
        "    light: {vehicles.C80.mass_t: 20}\n    plain: {}\n"
        "    both: {vehicles.C80.mass_t: 120, couplers.paper_set_b.loading_stiffness_kN_per_mm: 50}\n"
        "    longer: {consist.1.count: 11}\n    fives: {consist.1.drawbar_group: 5}\n",
        "utf-8",
    )
    finished: list[None] = []
    outcome = run_study(load_study(str(path)), tmp_path, local_pool, on_finished=lambda: finished.append(None))
    assert [claim.holds for claim in outcome.claims] == [True, None, None, True]
    light, both, longer, fives = (claim.text for claim in outcome.claims)
    assert light == "lighter wagons raise all frequencies (plain to light)"
    assert both == "plain to both, which differ in several things"
    assert longer == "plain to longer, which differ in several things"
    assert "wagons in groups of 5" in fives
    assert len(finished) == outcome.finished == 5


def marks(study: Sweep) -> list[tuple[str, tuple[float, float]]]:
    figure = map_figure(study, [made_up(case) for case in study.cases()])
    found = [text for axes in figure.axes for text in axes.texts if isinstance(text, Annotation)]
    return [(text.get_text(), text.xy) for text in found]


def test_the_map_marks_the_sets_of_the_catalogue_that_are_fitted_together() -> None:
    study = load_study("rigid-arm-map")
    waves, times = ([point.values[axis.name] for point in axis.points] for axis in study.axes[1:3])
    assert marks(study) == [
        ("fitted to the paper", (waves.index(220) + 0.5, times.index(2) + 0.5)),
        ("fitted to the paper", (waves.index(250) + 0.5, times.index(1) + 0.5)),
    ]


def test_the_map_marks_nothing_that_is_not_on_it_or_not_fitted() -> None:
    wagons = variants_axis("wagons", {"single": {}, "pairs": {"consist.1.drawbar_group": 2}})
    axes = (list_axis(WAVES, [220, 300]), list_axis(TIMES, [1]), wagons)
    assert marks(Sweep("mine", "", ("daqin_1_2_1",), {"coupler": "paper_set_b"}, axes, kind="rigid_arm_map")) == []
    assert fitted_set(Case("", "daqin_1_2_1", {"coupler": "MT-2"}, {})) is None
    assert fitted_set(Case("", "daqin_1_2_1", {}, {})) is None
    assert fitted_set(Case("", "daqin_1_2_1", {"coupler": "realistic_120"}, {})) is None


def test_of_two_axes_the_first_gives_the_panels_and_the_second_the_lines_in_words() -> None:
    axes = (variants_axis("set", {"B": {"y": 1}, "A": {"y": 2}}), list_axis("radio.default.delay_s", [0, 0.5, 1]))
    study = Sweep("made up", "", ("train",), axes=axes, paper=(PaperValues({"set": "A"}, force=6e5),))
    figure = profiles_figure(study, [made_up(case) for case in study.cases()])
    left, right = figure.axes[:2]
    assert [left.get_title(), right.get_title()] == ["B", "A"]
    shown = [line for line in left.get_lines() if str(line.get_label()).startswith("delay")]
    assert [line.get_label() for line in shown] == ["delay 0 s", "delay 0.5 s", "delay 1 s"]
    assert len({str(line.get_color()) for line in shown}) == len({line.get_linestyle() for line in shown}) == 3
    # The paper's force stands at the edge, in every case of its values, and nowhere along the train.
    assert [np.asarray(line.get_xydata()).tolist() for line in right.get_lines() if line.get_marker() == "<"] == [
        [[1.0, 600.0]]
    ] * 3
    assert left.get_ylim() == right.get_ylim()
    assert right.get_ylim()[1] > max(np.max(np.asarray(line.get_ydata())) for line in right.get_lines()[:3])


@pytest.mark.parametrize(
    ("key", "value", "label"),
    [
        ("initial_speed_kmh", 40, "initial speed 40 km/h"),
        ("vehicles.C80.mass_t", 101.5, "C80 mass 101.5 t"),
        ("radio.slave_2.delay_s", 0.5, "slave_2 delay 0.5 s"),
        ("couplers.ST.loading_stiffness_kN_per_mm", 20, "ST loading stiffness 20 kN/mm"),
        ("coupler", "MT-2", "coupler MT-2"),
    ],
)
def test_points_are_labelled_in_words_with_their_unit(key: str, value: object, label: str) -> None:
    axis = list_axis(key, [value])
    assert point_label(axis, axis.points[0]) == label
