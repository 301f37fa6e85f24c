"""docs/ros2.md: its Python runs, and every topic, service, parameter and launch argument in it exists."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from haul_ros.recording.reader import Recording
from haul_ros.ros.parameters import parameter_rows
from haul_ros.ros.unrecorded import Unrecorded, UnrecordedRates, state_channel
from haul_ros.scenario import load_scenario
from tests.ros.live_node import TABLE
from tests.waiting import WAIT

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/ros2.md").read_text("utf-8")
SERVICES = {"/haul/pause", "/haul/step", "/haul/reset"}


def test_its_python_runs_and_records(tmp_path: Path) -> None:
    (code,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.M | re.S)
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, timeout=WAIT)
    with Recording(tmp_path / "own.mcap") as recording:
        assert recording.info().complete
        assert recording.channels.prefix == "/train_a/haul"


def test_every_topic_and_service_exists_with_its_type() -> None:
    rates = UnrecordedRates(clock=1.0, force_image=1.0, train_markers=1.0)
    beside = Unrecorded(load_scenario("daqin_1_2_1").consist, TABLE.prefix, rates, lambda: 1e6).channels
    types = {channel.topic: channel.msgtype for channel in (*TABLE, *beside, state_channel(TABLE.prefix))}
    named = set(re.findall(r"(?<![\w~])/haul/[\w/]+", PAGE)) - {"/haul/couplers:"}
    assert len(named) > 6
    assert named <= types.keys() | SERVICES
    for topic, msgtype in re.findall(r"(/haul/[\w/]+)(?:: | )(std_msgs/msg/\w+)", PAGE):
        assert types[topic] == msgtype


def test_every_parameter_and_launch_argument_exists() -> None:
    rows = parameter_rows(["slave_1"])
    given = re.findall(r"-p (\S+?):=", PAGE) + re.findall(r"ros2 param (?:set|describe) /haul (.*)", PAGE)
    names = {name for text in given for name in text.split() if not re.fullmatch(r"[\d.]+", name)}
    assert len(names) > 3
    assert names <= rows.keys()
    launch = ast.parse((ROOT / "launch/train.launch.py").read_text("utf-8"))
    known = {node.value for node in ast.walk(launch) if isinstance(node, ast.Constant)}
    arguments = {name for line in re.findall(r"train\.launch\.py (.*)", PAGE) for name in re.findall(r"(\w+):=", line)}
    assert {"namespace", "node_name", "record_path"} <= arguments <= known
