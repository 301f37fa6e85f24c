from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

import pytest

from haul_ros.model.command import Command, CommandKind
from haul_ros.ros import node as ros_node

if TYPE_CHECKING:
    from tests.cli.conftest import Haul


@pytest.fixture
def node_given(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Argument lists that reached the node, which does not run."""
    given: list[list[str]] = []

    def main(arguments: Sequence[str]) -> int:
        given.append(list(arguments))
        return 0

    monkeypatch.setattr(ros_node, "main", main)
    return given


@pytest.fixture
def without_rclpy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)


def test_options_become_parameters_of_the_node_and_ros_arguments_follow_as_they_are(
    haul: Haul, node_given: list[list[str]]
) -> None:
    outcome = haul(
        "node", "--scenario", "daqin_1_1_0", "--record", "12", "--param", "radio.slave_1.delay:=0.5",
        "--ros-args", "-r", "__ns:=/line", "--param", "dt:=0.002",
    )  # fmt: skip
    assert outcome.status == 0
    assert node_given == [
        [
            "--ros-args",
            *("-p", 'scenario:="daqin_1_1_0"'),
            *("-p", 'record_path:="12"'),
            *("-p", "radio.slave_1.delay:=0.5"),
            *("--ros-args", "-r", "__ns:=/line", "--param", "dt:=0.002"),
        ]
    ]


def test_a_node_without_options_gets_no_arguments(haul: Haul, node_given: list[list[str]]) -> None:
    assert haul("node").status == 0
    assert node_given == [[]]


def test_the_status_of_the_node_is_that_of_the_command(haul: Haul, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ros_node, "main", lambda _arguments: 1)
    assert haul("node").status == 1


@pytest.mark.parametrize("parameter", ["dt", "dt=0.001", ":=1"])
def test_a_parameter_without_assignment_is_refused(haul: Haul, node_given: list[list[str]], parameter: str) -> None:
    outcome = haul("node", "--param", parameter)
    assert outcome.status == 2
    assert outcome.err.startswith(f"haul: --param {parameter}: expected NAME:=VALUE")
    assert node_given == []


@pytest.mark.usefixtures("without_rclpy")
@pytest.mark.parametrize("arguments", [("node",), ("brake", "master", "0.5")])
def test_without_ros_the_line_says_how_to_get_it(haul: Haul, arguments: tuple[str, ...]) -> None:
    outcome = haul(*arguments)
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    assert "pip install 'haul_ros[ros]', or source ROS 2 Jazzy" in outcome.err


@pytest.mark.usefixtures("without_rclpy")
def test_everything_else_works_without_ros(haul: Haul) -> None:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--quiet").status == 0
    assert haul("info", "run.mcap").status == 0
    assert haul("analyze", "run.mcap").status == 0


@pytest.mark.parametrize("demand", ["nan", "inf", "1.5", "-0.1"])
def test_a_demand_out_of_range_is_refused_before_any_ros(haul: Haul, without_rclpy: None, demand: str) -> None:
    outcome = haul("brake", "master", demand)
    assert outcome.status == 2
    assert outcome.err.startswith(f"haul: master: brake = {float(demand)}, must be ")


@pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy")
@pytest.mark.parametrize(
    ("arguments", "command"),
    [
        (("slave_1", "0.25"), Command("slave_1", CommandKind.BRAKE, 0.25)),
        (("master", "0"), Command("master", CommandKind.BRAKE, 0.0)),
        (("master", "--emergency"), Command("master", CommandKind.EMERGENCY, 1.0)),
        (("slave_2", "--release-emergency"), Command("slave_2", CommandKind.EMERGENCY, 0.0)),
    ],
)
def test_the_brake_command_is_published_as_given(
    haul: Haul, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], command: Command
) -> None:
    from haul_ros.ros import brake_client

    sent: list[tuple[Command, str]] = []

    def publish(command: Command, node: str) -> None:
        sent.append((command, node))

    monkeypatch.setattr(brake_client, "publish_command", publish)
    assert haul("brake", *arguments).status == 0
    assert haul("brake", *arguments, "--node", "/train_a/haul").status == 0
    assert haul("brake", "--node", "yard/train_b", *arguments).status == 0
    assert sent == [(command, "/haul"), (command, "/train_a/haul"), (command, "/yard/train_b")]


@pytest.mark.parametrize("name", ["", "/", "/train a/haul", "/train_a//haul", "/1", "/train_a/haul/"])
def test_a_name_that_no_node_can_have_is_refused_before_any_ros(haul: Haul, without_rclpy: None, name: str) -> None:
    outcome = haul("brake", "master", "0.5", "--node", name)
    assert outcome.status == 2
    assert outcome.err == f"haul: --node {name!r}: expected the full name of a node, such as /train_a/haul\n"
