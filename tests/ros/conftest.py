"""Live nodes on a ROS domain of their own, on this machine alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.ros.domain import own_domain

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer


@pytest.fixture(scope="session", autouse=True)
def own_ros_domain() -> Iterator[None]:
    """Tests that run at the same time, and whatever else runs here, do not meet."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in own_domain().items():
            patch.setenv(name, value)
        yield


@pytest.fixture
def observer(own_ros_domain: None) -> Iterator[Observer]:
    """A participant on the test's side."""
    from tests.ros.live_node import Observer

    observer = Observer()
    yield observer
    observer.close()


@pytest.fixture
def start_node(tmp_path: Path) -> Iterator[Callable[..., LiveNode]]:
    """Starts nodes: parameters by name (dots as ``__``), other ROS arguments as they are; all gone after the test."""
    from tests.ros.live_node import LiveNode

    nodes: list[LiveNode] = []
    folder = tmp_path / "run"
    folder.mkdir()

    def start(
        file_size_limit: int = 0, ros_arguments: Sequence[str] = (), prelude: str = "", **parameters: object
    ) -> LiveNode:
        named = {name.replace("__", "."): value for name, value in parameters.items()}
        log = tmp_path / f"node_{len(nodes)}.log"
        more: dict[str, Any] = {
            "ros_arguments": ros_arguments,
            "file_size_limit": file_size_limit,
            "prelude": prelude,
        }
        nodes.append(LiveNode(folder, log, named, **more))
        return nodes[-1]

    yield start
    for node in nodes:
        node.leave_nothing_running()
