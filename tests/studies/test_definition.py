from __future__ import annotations

from pathlib import Path

import pytest

from haul_ros.errors import HaulError
from haul_ros.studies.definition import free_sweep, load_study, parse_draw, parse_over, shipped_studies
from haul_ros.studies.sweep import Draw

NAMED = {
    "validation": "validation",
    "distribution": "distribution",
    "initial-speed": "initial_speed",
    "synchronisation": "synchronisation",
    "stiffness": "stiffness",
    "rigid-arms": "rigid_arms",
    "rigid-arm-map": "rigid_arm_map",
    "vibration": "vibration",
    "marshalling": "comparison",
    "monte-carlo": "sweep",
    "cyclic-braking": "map",
    "release-speed": "map",
    "unintended-release": "map",
    "burst-hose": "map",
    "radio-outage": "map",
}


@pytest.mark.parametrize("name", shipped_studies())
def test_shipped_studies_can_be_loaded_and_are_of_their_kind(name: str) -> None:
    study = load_study(name)
    study.check()
    assert study.kind == NAMED[name]


def test_the_named_studies_are_shipped() -> None:
    assert set(shipped_studies()) == set(NAMED)


def test_a_study_file_has_lists_ranges_variants_and_draws(tmp_path: Path, short: str) -> None:
    (tmp_path / "mine.yaml").write_text("""\
scenario: short.yaml
set: {max_duration_s: 50}
over:
  initial_speed_kmh: [20, 30]
  vehicles.C80.mass_t: {from: 20, to: 100, count: 3}
  radio: {good: {}, bad: {radio.default.delay_s: 2}}
draw:
  brake_systems.paper_set_b.build_up.full_time_s: {uniform: [1, 3]}
samples: 2
seed: 7
""")
    study = load_study(str(tmp_path / "mine.yaml"))
    study.check()
    cases = list(study.cases())
    assert (study.name, study.kind, len(cases)) == ("mine", "sweep", 2 * 3 * 2 * 2)
    assert cases[0].scenario == short
    assert cases[-1].name == "initial_speed_kmh=30, vehicles.C80.mass_t=100, bad, sample 2"
    assert cases[-1].overrides["radio.default.delay_s"] == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("over: {initial_speed_kmh: [20]}", "scenario"),
        ("scenario: daqin_1_2_1\nover: {initial_speed_kmh: []}", "mine.yaml:2: over.initial_speed_kmh"),
        ("scenario: daqin_1_2_1\nover: {initial_speed_kmh: {from: 9, to: 1, step: 2}}", "an empty range"),
        ("scenario: daqin_1_2_1\ndraw: {a: {uniform: [1, 2]}}", "samples"),
        ("scenario: daqin_1_2_1\nsamples: 5", "samples needs draw beside it"),
        ("scenario: daqin_1_2_1\nover: {initial_speed_kmh: {from: 9, to: 1}}", "expected a step or a count"),
        ("scenario: daqin_1_2_1\nover: {initial_speed_kmh: {from: 9, too: 1}}", "over.initial_speed_kmh.too"),
        ("scenario: daqin_1_2_1\nover: {initial_speed_kmh: {}}", "expected a list, a range"),
        ("scenario: daqin_1_2_1\nover: {initial_speed_kmh: 5}", "must be a list or a mapping"),
        ("scenario: daqin_1_2_1\nover: {a: {from: 9, to: {x: 1}}}", "over.a: expected a list"),
        ("scenario: daqin_1_2_1\ndraw: {a: {normal: [1]}}\nsamples: 2", "must have at least 2 entries"),
        ("scenario: daqin_1_2_1\ndraw: {a: {}}\nsamples: 2", "needs either uniform or normal"),
        ("scenario: daqin_1_2_1\ndraw: {}\nsamples: 2", "draw: is empty"),
        ("scenario: daqin_1_2_1\nsweep: {}", "sweep"),
        (
            "kind: vibrations\nscenario: daqin_1_2_1",
            "mine.yaml:1: kind = 'vibrations', must be sweep or comparison",
        ),
        ("scenario: daqin_1_2_1\npaper: {daqin_1_2_1: {force_kN: 700}}", "paper = a mapping, must be a list"),
        (
            "scenario: daqin_1_2_1\npaper:\n- {where: {x: 1}, force_kN: 7}",
            "mine.yaml:3: paper.0.where: no case of",
        ),
        ("scenario: daqin_1_2_1\nfitted:\n- {}\n- {x: 1}", "mine.yaml:4: fitted.1: no case of"),
        ("scenario: [", "not valid YAML"),
    ],
)
def test_study_files_that_cannot_be_are_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(text, "utf-8")
    with pytest.raises(HaulError, match=message) as caught:
        load_study(str(path))
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_the_paper_says_belongs_to_the_cases_of_its_values_and_the_first_that_fits_counts(
    tmp_path: Path, short: str
) -> None:
    (tmp_path / "mine.yaml").write_text("""\
scenario: short.yaml
over:
  radio: {good: {}, bad: {radio.default.delay_s: 2}}
  initial_speed_kmh: [20, 30]
paper:
  - {where: {radio.default.delay_s: 2, initial_speed_kmh: 30.0}, force_kN: 700, position: 0.5}
  - {where: {radio: good}, stroke_mm: 25}
  - {force_kN: 600}
""")
    study = load_study(str(tmp_path / "mine.yaml"))
    found = [(p.force, p.stroke, p.position) for p in map(study.paper_values, study.cases())]
    assert found == [(None, 0.025, None), (None, 0.025, None), (600e3, None, None), (700e3, None, 0.5)]


def test_the_study_in_the_docs_can_be_run(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs/studies.md").read_text("utf-8")
    text = page.split("```yaml\n")[1].split("```")[0]
    (tmp_path / "my_study.yaml").write_text(text, "utf-8")
    study = load_study(str(tmp_path / "my_study.yaml"))
    study.check()
    assert len(study) == 5 * 2 * 2 * 20


def test_an_unknown_study_is_refused_with_those_known() -> None:
    with pytest.raises(HaulError, match=r"no such study, .* validation"):
        load_study("validatoin")


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("k=40,60.5", [40, 60.5]),
        ("k=40", [40]),
        ("k=40:100:30", [40, 70, 100]),
        ("k=[true, false]", [True, False]),
        ("k=MT-2,ST", ["MT-2", "ST"]),
    ],
)
def test_axes_from_the_command_line(text: str, values: list[object]) -> None:
    assert [point.overrides["k"] for point in parse_over(text).points] == values


@pytest.mark.parametrize("text", ["k", "k=", "=1", "k=1:2:x", "k=]", "k=5:1:1", "k=[]"])
def test_axes_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(HaulError, match="over"):
        parse_over(text)


def test_draws_from_the_command_line() -> None:
    assert parse_draw("a.b=normal(100, 3)") == Draw("a.b", "normal", (100.0, 3.0))
    assert parse_draw("a=uniform(0,1)") == Draw("a", "uniform", (0.0, 1.0))


@pytest.mark.parametrize("text", ["k", "k=gamma(1,2)", "k=uniform(1)", "k=uniform(a,b)", "=uniform(0,1)"])
def test_draws_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(HaulError, match="--draw"):
        parse_draw(text)


@pytest.mark.parametrize(
    ("over", "draw", "samples", "message"),
    [
        ([], [], None, "nothing is varied"),
        ([], ["k=uniform(0,1)"], None, "given together"),
        (["k=1"], [], 5, "given together"),
        ([], ["k=uniform(0,1)"], 0, "--samples 0: must be 1 or more"),
    ],
)
def test_sweeps_that_are_none_are_refused(over: list[str], draw: list[str], samples: int | None, message: str) -> None:
    with pytest.raises(HaulError, match=message):
        free_sweep("daqin_1_2_1", [], over, draw, samples, 0)
