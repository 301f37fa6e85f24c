"""Parameter files that several nodes share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy")

from rcl_interfaces.srv import ListParameters

from tests.ros.live_node import Couplers

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

    StartNode = Callable[..., LiveNode]

SHARED = """\
/**:
  ros__parameters:
    use_sim_time: false
    record_path: none
    initial_speed: 10.0
    update_rate: 100
    frames: [base, head]
"""


def test_parameters_of_other_nodes_in_a_shared_file_are_told_of_and_do_not_stop_the_train(
    start_node: StartNode, observer: Observer, tmp_path: Path
) -> None:
    (tmp_path / "shared.yaml").write_text(SHARED)
    node = start_node(ros_arguments=["--params-file", str(tmp_path / "shared.yaml")])
    Couplers(observer).wait_for_time(0)
    assert observer.parameter("initial_speed").double_value == 10.0
    listed = observer.call(ListParameters, "list_parameters", ListParameters.Request()).result.names
    assert {"initial_speed", "use_sim_time"} <= set(listed)
    assert not {"update_rate", "frames"} & set(listed)
    assert node.end() == 0
    for name in ("update_rate", "frames"):
        assert f"parameter {name} is unknown and without effect here" in node.log


def test_a_slip_in_a_shared_file_stops_the_train(start_node: StartNode, tmp_path: Path) -> None:
    (tmp_path / "shared.yaml").write_text(SHARED.replace("initial_speed", "inital_speed"))
    node = start_node(ros_arguments=["--params-file", str(tmp_path / "shared.yaml")])
    assert node.wait_for_end() == 2
    assert "parameter inital_speed is unknown; did you mean initial_speed?" in node.log
    assert not list(node.folder.iterdir())
