"""Live nodes on a ROS domain of their own, on this machine alone."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer


@pytest.fixture(scope="session", autouse=True)
def own_ros_domain() -> Iterator[None]:
    """Tests that run at the same time, and whatever else runs here, do not meet."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        patch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
        # Loopback alone: shared memory left behind by a process that was killed can swallow messages
        patch.setenv("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")
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
    """Starts nodes: parameters by name (dots as ``__``), all of them gone after the test."""
    from tests.ros.live_node import LiveNode

    nodes: list[LiveNode] = []
    folder = tmp_path / "run"
    folder.mkdir()

    def start(file_size_limit: int = 0, **parameters: object) -> LiveNode:
        named = {name.replace("__", "."): value for name, value in parameters.items()}
        log = tmp_path / f"node_{len(nodes)}.log"
        nodes.append(LiveNode(folder, log, named, file_size_limit=file_size_limit))
        return nodes[-1]

    yield start
    for node in nodes:
        node.leave_nothing_running()
