"""The README shows what works: its scenario loads, its first commands exist, its Python runs."""

import importlib.metadata
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import haul_ros
from haul_ros.scenario import load_scenario, load_scenario_text

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    """Fenced blocks of a language, in order."""
    return re.findall(rf"^```{language}\n(.*?)^```", README, flags=re.M | re.S)


def test_scenario_in_the_readme_loads() -> None:
    scenario = load_scenario_text(blocks("yaml")[0], "readme")
    assert len(scenario.consist.vehicles) == 208
    assert sum(gear is None for gear in scenario.consist.couplers) == 2 * 34


def test_the_line_in_the_readme_loads(tmp_path: Path) -> None:
    (tmp_path / "line.csv").write_text(blocks("csv")[0], encoding="utf-8")
    track = load_scenario("daqin_1_2_1", {"track.file": str(tmp_path / "line.csv")}).track
    assert track.grades == ((0.0, -0.004), (2000.0, -0.009))
    assert (track.curves, track.grade_ramp) == (((500.0, 1 / 800), (900.0, 0.0)), 200.0)


def test_what_rosdep_is_told_to_skip_pip_installs_within_the_bounds_of_the_package() -> None:
    # Keys that rosdep resolves to pip alone, and what each brings; Ubuntu 24.04 lets rosdep install neither
    by_pip = {"python3-rosbags-pip": "rosbags", "mcap-ros2-support": "mcap"}
    ((skipped, given),) = re.findall(r'^rosdep install .* --skip-keys "(.*)"\npip install --user (.*)$', README, re.M)
    package = ET.parse(ROOT / "package.xml")
    assert set(skipped.split()) == by_pip.keys() <= {element.text for element in package.iter("exec_depend")}
    requirements = {Requirement(text) for text in importlib.metadata.requires("haul_ros") or ()}
    installed = {Requirement(text) for text in re.findall(r"'(.*?)'", given)}
    assert {requirement.name for requirement in installed} == set(by_pip.values())
    assert installed <= requirements


def test_get_started_begins_with_two_bash_blocks_of_one_existing_command_each() -> None:
    section = README.split("## Get started")[1].split("\n## ")[0]
    commands = re.findall(r"^```bash\n(.*?)^```", section, flags=re.M | re.S)
    assert len(commands) == 2
    for command in commands:
        shell, script = command.split()
        assert shell == "bash"
        assert (ROOT / script).is_file()


def test_python_in_the_readme_runs(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    simulate, read = blocks("python")
    exec(simulate, {})
    force, tension = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"\d+\.\d+ kN", force)
    assert re.fullmatch(r"CouplerPeak\(value=\d+\..*", tension)

    session = haul_ros.Session(haul_ros.load_scenario("daqin_1_2_1"))
    encoder = haul_ros.TelemetryEncoder(session.consist)
    with haul_ros.McapRecorder(tmp_path / "run.mcap", session.scenario, encoder.channels) as recorder:
        recorder.put(encoder.messages(session.take_log()), 0)
    namespace: dict[str, object] = {}
    exec(read.replace("run.mcap", str(tmp_path / "run.mcap")), namespace)
    assert namespace["couplers"].force.shape == (1, 207)  # type: ignore[attr-defined]
    assert namespace["vehicles"].chainage.shape == (1, 208)  # type: ignore[attr-defined]
    assert namespace["largest"].compression.shape == (207,)  # type: ignore[attr-defined]


def test_pictures_of_the_readme_are_there() -> None:
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", README)
    assert pictures
    assert [picture for picture in pictures if not (ROOT / picture).is_file()] == []
