"""Finding the shipped data files, however the package was installed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from haul_ros import resources
from haul_ros.errors import HaulError
from haul_ros.recording.run_file import recovery_hint


@pytest.fixture
def installed_at(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[Path], None]]:
    """Pretends that the package lies at a path."""

    def install(package: Path) -> None:
        package.mkdir(parents=True)
        monkeypatch.setattr(resources, "__file__", str(package / "resources.py"))
        resources.config_dir.cache_clear()

    yield install
    resources.config_dir.cache_clear()


def test_in_a_source_tree_the_data_files_are_beside_the_package(
    installed_at: Callable[[Path], None], tmp_path: Path
) -> None:
    installed_at(tmp_path / "checkout" / "haul_ros")
    (tmp_path / "checkout/config/catalogue").mkdir(parents=True)
    assert resources.config_dir() == tmp_path / "checkout" / "config"


@pytest.mark.parametrize("packages", ["lib/python3.12/site-packages", "local/lib/python3.12/dist-packages", "."])
def test_installed_data_files_are_found_below_the_prefix(
    installed_at: Callable[[Path], None], tmp_path: Path, packages: str
) -> None:
    installed_at(tmp_path / packages / "haul_ros")
    (tmp_path / "share/haul_ros/config/catalogue").mkdir(parents=True)
    assert resources.config_dir() == tmp_path / "share/haul_ros/config"


def test_another_packages_config_folder_is_passed_over(installed_at: Callable[[Path], None], tmp_path: Path) -> None:
    installed_at(tmp_path / "site-packages" / "haul_ros")
    (tmp_path / "site-packages/config").mkdir()
    (tmp_path / "share/haul_ros/config/catalogue").mkdir(parents=True)
    assert resources.config_dir() == tmp_path / "share/haul_ros/config"


def test_missing_data_files_are_told(installed_at: Callable[[Path], None], tmp_path: Path) -> None:
    installed_at(tmp_path / "haul_ros")
    with pytest.raises(HaulError, match=r"^the data files of haul_ros .* are missing above .*: install it again$"):
        resources.config_dir()


def test_the_shipped_scenarios_go_by_the_names_of_their_files() -> None:
    shipped = resources.shipped_scenarios()
    assert shipped["daqin_1_2_1"].name == "daqin_1_2_1.yaml"
    assert list(shipped) == sorted(shipped)


@pytest.mark.parametrize(
    ("in_workspace", "on_path", "command"),
    [
        (True, False, "ros2 run haul_ros haul"),
        (True, True, "haul"),
        (False, False, "haul"),
    ],
)
def test_in_a_workspace_the_command_is_called_through_ros2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, in_workspace: bool, on_path: bool, command: str
) -> None:
    programs, prefix = tmp_path / "bin", tmp_path / "install/haul_ros"
    for folder, there in ((programs, on_path), (prefix / "lib/haul_ros", in_workspace)):
        folder.mkdir(parents=True)
        if there:
            (folder / "haul").touch(0o755)
    monkeypatch.setenv("PATH", str(programs))
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/opt/ros/jazzy:{prefix}:")
    assert resources.haul_command() == command
    assert recovery_hint(Path("run.mcap.active")) == (f"to recover it: {command} recover run.mcap.active -o run.mcap")
