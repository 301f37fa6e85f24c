"""The package installs with colcon as ROS users do it, and works from there in an empty folder."""

import importlib.metadata
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import haul_ros
from tests.waiting import WAIT

ROOT = Path(__file__).parent.parent


def _environment(**more: str) -> dict[str, str]:
    """That of this process; how colcon runs is not measured, for that takes long."""
    return {name: value for name, value in os.environ.items() if name != "COVERAGE_PROCESS_CONFIG"} | more


def test_versions_agree() -> None:
    assert ET.parse(ROOT / "package.xml").findtext("version") == haul_ros.__version__


@pytest.mark.skipif("PYTEST_XDIST_WORKER" not in os.environ, reason="nothing runs side by side")
def test_processes_share_the_tests_out_by_group(request: pytest.FixtureRequest) -> None:
    assert request.node.nodeid.endswith("@test_packaging.py")


def test_every_dependency_is_bound_at_both_ends_and_tried_at_the_lower_one() -> None:
    lines = (ROOT / "scripts/oldest.txt").read_text("utf-8").splitlines()
    oldest = dict(line.split("==") for line in lines if not line.startswith("#"))
    requirements = [Requirement(text) for text in importlib.metadata.requires("haul_ros") or ()]
    assert len(requirements) > 20
    for requirement in requirements:
        bounds = {bound.operator: bound.version for bound in requirement.specifier}
        assert bounds.keys() in ({">=", "<"}, {"=="}), requirement
        if "==" not in bounds and not requirement.name.startswith("ros-jazzy-"):
            assert f"{oldest[requirement.name]}.".startswith(f"{bounds['>=']}."), requirement
            assert oldest[requirement.name] in requirement.specifier


@pytest.fixture(params=["", "--symlink-install"], scope="module")
def installed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The install space of a colcon build, with and without links to the sources."""
    pytest.importorskip("colcon_core")
    bases = tmp_path_factory.mktemp("workspace")
    command = [sys.executable, "-m", "colcon", "--log-base", str(bases / "log"), "build", "--base-paths", str(ROOT)]
    command += ["--build-base", str(bases / "build"), "--install-base", str(bases / "install")]
    command += [request.param] if request.param else []
    result = subprocess.run(
        command, cwd=bases, env=_environment(), capture_output=True, text=True, timeout=WAIT, check=False
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return bases / "install" / "haul_ros"


@pytest.mark.slow
def test_colcon_installs_programs_and_data_files(installed: Path) -> None:
    shipped = [path.relative_to(ROOT) for path in (ROOT / "config").rglob("*") if path.is_file()]
    assert len(shipped) > 10
    assert Path("config/security/haul.policy.xml") in shipped  # where SECURITY.md says it is
    expected = {
        "lib/haul_ros/train_node",
        "lib/haul_ros/haul",
        "share/ament_index/resource_index/packages/haul_ros",
        "share/haul_ros/package.xml",
        "share/haul_ros/launch/train.launch.py",
        *(f"share/haul_ros/{path}" for path in shipped),
    }
    assert {path for path in expected if not (installed / path).exists()} == set()


@pytest.mark.slow
def test_installed_program_finds_its_scenarios(installed: Path, tmp_path: Path) -> None:
    # What sourcing install/setup.bash does for Python, read from what colcon wrote
    found = subprocess.run(
        ["bash", "-c", f'. "{installed}/share/haul_ros/package.bash" && echo "$PYTHONPATH"'],
        env=_environment(PYTHONPATH=""),
        capture_output=True,
        text=True,
        check=True,
    ).stdout.strip()
    assert found
    result = subprocess.run(
        [sys.executable, installed / "lib/haul_ros/haul", "scenarios", "--json"],
        cwd=tmp_path,
        env=_environment(PYTHONPATH=found),
        capture_output=True,
        text=True,
        timeout=WAIT,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert "daqin_1_2_1" in result.stdout
    # The page is made of files inside the package
    made = subprocess.run(
        [sys.executable, "-c", "from haul_ros.page.document import page; print(page({'title': 'made'}))"],
        cwd=tmp_path,
        env=_environment(PYTHONPATH=found),
        capture_output=True,
        text=True,
        timeout=WAIT,
        check=True,
    ).stdout
    assert "<title>made</title>" in made
    assert "uPlot" in made
    assert "ColorBrewer" in made
