"""The README shows what works: its commands exist, its pictures are there."""

import importlib.metadata
import re
import shlex
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from haul_ros.cli.commands import COMMANDS
from haul_ros.cli.main import build_parser
from haul_ros.version import __version__

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_what_rosdep_is_told_to_skip_pip_installs_within_the_bounds_of_the_package() -> None:
    # Keys that rosdep resolves to pip alone, and what each brings; Ubuntu 24.04 lets rosdep install neither
    by_pip = {"python3-rosbags-pip": "rosbags", "mcap-ros2-support": "mcap"}
    page = (ROOT / "docs/install.md").read_text(encoding="utf-8")
    ((skipped, given),) = re.findall(r'^rosdep install .* --skip-keys "(.*)"\npip install --user (.*)$', page, re.M)
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


def test_the_ten_lines_are_commands_that_there_are() -> None:
    lines = README.split("## In ten lines")[1].split("```")[1].strip().splitlines()
    assert len(lines) == 10
    for line in lines:
        program, *arguments = shlex.split(line, comments=True)
        assert program == "haul"
        build_parser().parse_args(arguments)


def test_the_table_has_every_command() -> None:
    rows = re.findall(r"^\| `haul (\w+) .*\|$|^\| `haul (\w+)`", README, re.M)
    assert {first or second for first, second in rows} == {command.name for command in COMMANDS}


def test_pictures_of_the_readme_are_there() -> None:
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", README)
    assert pictures
    assert [picture for picture in pictures if not (ROOT / picture).is_file()] == []


@pytest.mark.parametrize(
    ("file", "version"),
    [("package.xml", r"<version>(.*?)</version>"), ("CITATION.cff", r"^version: (.*)$")],
)
def test_every_file_has_the_version(file: str, version: str) -> None:
    assert re.findall(version, (ROOT / file).read_text("utf-8"), re.M) == [__version__]
