"""Lines from files: what they become, what they are told, and that a scenario carries them with it."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.scenario import Scenario
from haul_ros.resources import shipped_lines
from haul_ros.scenario.line import MOST_CHANGES
from haul_ros.scenario.line_csv import MOST_ROWS
from haul_ros.scenario.loader import load_scenario, load_scenario_text
from haul_ros.scenario.yaml_file import MOST_VALUES
from haul_ros.units import kmh_to_mps, mps_to_kmh

CSV = """\
# A line to try things with.
# source: made up
# standing: assumed
# grade_ramp_m: 50
chainage_m,grade_permille,curve_radius_m,speed_limit_kmh
0,4,,80
100,,800,80
300,-12.5,800,60

# a comment between rows
400,,400,60
500,-12.5,,
"""
YAML = """\
source: made up
standing: assumed
grade_ramp_m: 50
grades: [{from_m: 0, grade_permille: 4}, {from_m: 300, grade_permille: -12.5}]
curves: [{from_m: 100, to_m: 400, radius_m: 800}, {from_m: 400, to_m: 500, radius_m: 400}]
speed_limits: [{from_m: 0, limit_kmh: 80}, {from_m: 300, limit_kmh: 60}, {from_m: 500}]
"""
Write = Callable[[str, str], None]
Load = Callable[..., Scenario]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes a file beside the scenario."""
    (tmp_path / "lines").mkdir()

    def write(name: str, text: str) -> None:
        (tmp_path / name).write_text(text, "utf-8")

    return write


@pytest.fixture
def load(small_train: str, tmp_path: Path) -> Load:
    """Loads the small train with a file as its line, from a folder that is not the current one."""

    def load(file: str, **overrides: object) -> Scenario:
        path = tmp_path / "my.yaml"
        path.write_text(f"{small_train}track: {{file: {file}, start_chainage_m: 250}}\n", "utf-8")
        return load_scenario(path, {key.replace("__", "."): value for key, value in overrides.items()})

    return load


def _refusal(load: Load, file: str = "line.csv", **overrides: object) -> str:
    with pytest.raises(ScenarioError) as caught:
        load(file, **overrides)
    message = str(caught.value)
    assert "\n" not in message
    return message


@pytest.mark.parametrize(("name", "text"), [("line.csv", CSV), ("lines/l.yaml", YAML), ("lines/L.YML", YAML)])
def test_a_file_becomes_the_line_beside_the_scenario(load: Load, write: Write, name: str, text: str) -> None:
    write(name, text)
    track = load(name).track
    assert track.start_chainage == 250.0
    assert track.grades == ((0.0, 0.004), (300.0, -0.0125))
    assert track.curves == ((100.0, 1 / 800), (400.0, 1 / 400), (500.0, 0.0))
    assert track.speed_limits == ((0.0, kmh_to_mps(80)), (300.0, kmh_to_mps(60)), (500.0, math.inf))
    assert track.grade_ramp == 50.0


def test_csv_and_yaml_give_the_same_scenario(load: Load, write: Write) -> None:
    write("line.csv", CSV.replace("\n", "\r\n"))
    write("line.yaml", YAML)
    assert load("line.csv") == load("line.yaml")


def test_columns_may_be_few_and_in_any_order(load: Load, write: Write) -> None:
    write("line.csv", "\ufeffspeed_limit_kmh, chainage_m,,\n40,-5e1,,\n,+10.5,,\n")
    track = load("line.csv").track
    assert track.speed_limits == ((-50.0, kmh_to_mps(40)), (10.5, math.inf))
    assert (track.grades, track.curves, track.grade_ramp) == ((), (), 0.0)


def test_a_curve_that_no_row_ends_goes_on(load: Load, write: Write) -> None:
    write("line.csv", "chainage_m,curve_radius_m\n7,500\n9,500\n")
    assert load("line.csv").track.curves == ((7.0, 1 / 500), (1e7, 0.0))


def test_the_document_holds_the_line_itself(load: Load, write: Write, tmp_path: Path) -> None:
    write("line.csv", CSV)
    scenario = load("line.csv")
    (tmp_path / "line.csv").unlink()
    assert "line.csv" not in scenario.document
    assert load_scenario_text(scenario.document, "my") == scenario


def test_overrides_reach_the_values_of_a_file(load: Load, write: Write) -> None:
    write("line.csv", CSV)
    scenario = load("line.csv", track__grades__1__grade_permille=-9, track__grade_ramp_m=0)
    assert scenario.track.grades == ((0.0, 0.004), (300.0, -0.009))
    assert scenario.track.grade_ramp == 0.0
    assert "track: grades.1.grade_permille, grade_ramp_m overridden; other values assumed" in scenario.caveats
    assert "track: all values assumed" in load("line.csv", track__start_chainage_m=0).caveats


def test_an_override_takes_the_place_of_the_whole_line(
    load: Load, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write("line.csv", CSV)
    write("lines/other.csv", "chainage_m,grade_permille\n0,1\n")
    monkeypatch.chdir(tmp_path / "lines")
    other = load("line.csv", track__file="other.csv")
    assert (other.track.grades, other.track.speed_limits, other.track.grade_ramp) == (((0.0, 0.001),), (), 0.0)
    assert other.track.start_chainage == 250.0
    assert not any(caveat.startswith("track") for caveat in other.caveats)
    # What stands in the scenario is another folder's; one that is given for the run is the shell's.
    assert "track.file = 'line.csv', no such file" in _refusal(load, "line.csv", track__file="line.csv")
    assert load("line.csv", track={"file": "other.csv"}).track.start_chainage == 0.0


def test_a_text_without_a_folder_has_shipped_lines_alone(small_train: str) -> None:
    track = load_scenario_text(f"{small_train}track: {{file: daqin_descent_synthetic}}\n", "x").track
    assert track == load_scenario("daqin_1_2_1", {"track.file": "daqin_descent_synthetic"}).track
    expected = r"^x:8: track.file = '/etc/passwd', must be one of daqin_descent_synthetic: this text lies in no folder"
    with pytest.raises(ScenarioError, match=expected):
        load_scenario_text(f"{small_train}track: {{file: /etc/passwd}}\n", "x")


HEAD = "chainage_m,grade_permille,curve_radius_m,speed_limit_kmh\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"{HEAD}0,1,,\n5,x,,\n", "line.csv:3: grade_permille = 'x', must be a finite number"),
        (f"{HEAD}0,nan,,\n", "line.csv:2: grade_permille = 'nan', must be a finite number"),
        (f"{HEAD}0,1e999,,\n", "line.csv:2: grade_permille = inf, must be a finite number"),
        (f"{HEAD}0,1_0,,\n", "line.csv:2: grade_permille = '1_0', must be a finite number"),
        (f"{HEAD}0,-201,,\n", "line.csv:2: grade_permille = -201, must be at least -200"),
        (f"{HEAD}0,,49,\n", "line.csv:2: curve_radius_m = 49, must be at least 50"),
        (f"{HEAD}0,,,0\n", "line.csv:2: speed_limit_kmh = 0, must be at least 1"),
        (f"{HEAD},1,,\n", "line.csv:2: chainage_m is missing"),
        (f"{HEAD}0,1,,\n# c\n0,2,,\n", "line.csv:4: chainage_m = 0, must be above that of the row before, 0"),
        (f"{HEAD}0,1\n", "line.csv:2: 2 cells, expected 4: chainage_m, grade_permille, curve_radius_m, speed_limit"),
        (f"{HEAD}0,1,,,7\n", "line.csv:2: 5 cells, expected 4"),
        (f'{HEAD}0,"1,,\n', "line.csv:2: not a row of a CSV file: "),
        ("chainage_m;grade_permille\n0;1\n", "line.csv:1: 'chainage_m;grade_permille': no column of a line, did you"),
        ("chainage_m,grade_pm\n0,1\n", "line.csv:1: 'grade_pm': no column of a line, did you mean grade_permille?"),
        ("grade_permille\n0\n", "line.csv:1: columns grade_permille, expected chainage_m and any of grade_permille,"),
        ("chainage_m,chainage_m\n0,1\n", "line.csv:1: columns chainage_m, chainage_m, expected chainage_m and any of"),
        ("# nothing\n", "line.csv: no rows, expected a line chainage_m,grade_permille,curve_radius_m,speed_limit_kmh"),
        (f"# grade_ramp_m: long\n{HEAD}0,1,,\n", "line.csv:1: grade_ramp_m = 'long', must be a finite number"),
        (f"# standing: sure\n{HEAD}0,1,,\n", "line.csv:1: standing = 'sure', must be published or fitted or assumed"),
        (
            f"# grade_ramp_m: 60\n{HEAD}0,1,,\n50,1,,\n70,2,,\n120,3,,\n",
            "line.csv:6: track.grades.2.from_m = 120, its ramp of 60 m overlaps that of the change at 70 m: must be "
            "at least 130, or grade_ramp_m at most 50",
        ),
        (HEAD + "".join(f"{n},,,\n" for n in range(MOST_ROWS + 1)), f"line.csv:{MOST_ROWS + 2}: more than 10000 rows"),
        (
            HEAD + "".join(f"{n},{n % 7},,\n" for n in range(MOST_CHANGES + 1)),
            f"a line of {MOST_CHANGES + 1} grades, curves and limits, must have at most 5000",
        ),
        (f"{HEAD}0,1,,\n#" + "x" * 2**22, "more than 4 MiB, expected a CSV file of less"),
    ],
)
def test_what_a_csv_file_cannot_be_is_told_with_its_line(load: Load, write: Write, text: str, expected: str) -> None:
    write("line.csv", text)
    message = _refusal(load)
    assert expected in message
    assert len(message) < 500


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("grade: []", "line.yaml:1: grade: unknown key, did you mean grades?"),
        ("", "line.yaml: must be a mapping"),
        ("start_chainage_m: 3", "line.yaml:1: start_chainage_m: unknown key"),
        (
            "grades:\n- {from_m: 0, grade_permille: 1}\n- {from_m: 0, grade_permille: 2}",
            "line.yaml:3: track.grades.1.from_m = 0, must be above that of the grade before, 0",
        ),
        ("speed_limits: [{from_m: 1, limit_kmh: 900}]", "line.yaml:1: speed_limits.0.limit_kmh = 900, must be at most"),
    ],
)
def test_what_a_yaml_file_cannot_be_is_told_with_its_line(load: Load, write: Write, text: str, expected: str) -> None:
    write("line.yaml", text)
    assert expected in _refusal(load, "line.yaml")


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        (
            "none.csv",
            "my.yaml:8: track.file = 'none.csv', no such file, expected a file (.csv, .yaml) or one of daqin_",
        ),
        ("line.txt", "my.yaml:8: track.file = 'line.txt', no line, expected a file (.csv, .yaml) or one of daqin_"),
        ("folder.csv", "my.yaml:8: track.file = 'folder.csv', is a directory, expected a file"),
        ("bytes.csv", "bytes.csv: not a CSV file: not text in UTF-8"),
        ("3", "my.yaml:8: track.file = 3, must be text"),
        (
            "a.csv, grades: []",
            "my.yaml:8: track: has file and grades, expected one of them: a file holds the whole line",
        ),
    ],
)
def test_a_file_that_is_none_is_told(load: Load, tmp_path: Path, file: str, expected: str) -> None:
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "bytes.csv").write_bytes(b"chainage_m\n\xff\n")
    assert expected in _refusal(load, file)


@pytest.mark.no_cover
def test_a_scenario_too_large_to_be_read_again_is_refused(load: Load, write: Write) -> None:
    write("line.csv", HEAD + "".join(f"{n},{n % 7},,\n" for n in range(MOST_CHANGES)))
    few, many = ([{"at_s": n, "locomotive": "master", "brake": 0.5} for n in range(count)] for count in (3000, 4000))
    assert load_scenario_text(load("line.csv", commands=few).document, "x").track.grades[-1][0] == MOST_CHANGES - 1
    assert f"values and keys with all that it uses, expected at most {MOST_VALUES}" in _refusal(load, commands=many)


# -- the shipped line: figures of the text, beside those of the file --------------------------------

# (km from, km to, per mille)
PROFILE = [
    (0, 6, 0), (6, 10, 3), (10, 14, -3), (14, 19, -8), (19, 27, -10), (27, 30, -5), (30, 38, -11), (38, 41, -6),
    (41, 47, -12), (47, 50, -3), (50, 56, -9), (56, 61, -2), (61, 66, 4), (66, 70, 0),
]  # fmt: skip


@pytest.fixture(scope="module")
def descent() -> Scenario:
    return load_scenario("daqin_1_2_1", {"track.file": "daqin_descent_synthetic"})


def test_the_shipped_descent_has_the_grades_of_its_description(descent: Scenario) -> None:
    assert [(start / 1e3, round(grade * 1e3, 9)) for start, grade in descent.track.grades] == [
        (start, grade) for start, _, grade in PROFILE
    ]
    assert all(end == start for (_, end, _), (start, _, _) in pairwise(PROFILE))
    assert descent.track.grade_ramp >= 200.0


def test_the_shipped_descent_falls_as_described(descent: Scenario) -> None:
    starts = [start for start, _ in descent.track.grades]
    falls = [
        (end - start) * grade for (start, end), (_, grade) in zip(pairwise(starts), descent.track.grades, strict=False)
    ]
    first, last = starts.index(14e3), starts.index(61e3)
    assert 1e3 * sum(falls[first:last]) / 47e3 == pytest.approx(-8.2, abs=0.05)
    assert min(grade for _, grade in descent.track.grades) == -0.012


def test_the_shipped_descent_has_the_curves_and_limits_of_its_description(descent: Scenario) -> None:
    track = descent.track
    assert {curvature for _, curvature in track.curves} == {0.0, 1 / 800, 1 / 400}
    tight = [(start, end) for (start, curvature), (end, _) in pairwise(track.curves) if curvature == 1 / 400]
    assert tight == [(33e3, 33.5e3)]
    limits = [(start / 1e3, round(mps_to_kmh(limit), 9)) for start, limit in track.speed_limits]
    assert limits == [(0, 80), (14, 70), (33, 60), (33.5, 70), (61, 80)]


def test_the_shipped_descent_says_what_it_is(descent: Scenario) -> None:
    assert "track: all values assumed" in descent.caveats
    text = shipped_lines()["daqin_descent_synthetic"].read_text("utf-8")
    assert "synthetic" in text.splitlines()[0]
    assert "synthetic" in descent.document
