"""The node as a class, in an executor of somebody else's."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter

from haul_ros.messages.channels import channel_table
from haul_ros.model.command import CommandKind
from haul_ros.recording.reader import Recording
from haul_ros.ros.train_node import TrainNode
from tests.ros.live_node import LOCOMOTIVES, Observer, brake


@pytest.fixture
def context(own_ros_domain: None) -> Iterator[Context]:
    context = Context()
    context.init()
    yield context
    context.try_shutdown()


def test_two_trains_in_one_executor_are_braked_recorded_and_stopped(
    context: Context, observer: Observer, tmp_path: Path
) -> None:
    executor = SingleThreadedExecutor(context=context)
    ended: list[str] = []
    trains = {
        name: TrainNode(
            namespace=name,
            context=context,
            on_end=partial(ended.append, name),
            parameter_overrides=[Parameter("record_path", value=str(tmp_path / f"{name}.mcap"))],
        )
        for name in ("front", "rear")
    }
    for train in trains.values():
        train.start()
        executor.add_node(train)
    applied = {}
    for number, name in enumerate(trains, 1):
        table = channel_table(LOCOMOTIVES, f"/{name}/haul")
        applied[name] = observer.watch_typed(table.applied_brake["master"])
        command = table.commands[CommandKind.BRAKE]["master"]
        observer.publish_on(command.topic, command, number / 4, table.applied_brake["master"])
    while not all(messages and messages[-1].data for messages in applied.values()):
        executor.spin_once(timeout_sec=0.05)
        observer.receive_for(0.05)
    assert [train.stop() for train in trains.values()] == [0, 0]
    executor.shutdown()
    for train in trains.values():
        train.destroy_node()
    assert ended == list(trains)
    for number, name in enumerate(trains, 1):
        with Recording(tmp_path / f"{name}.mcap") as recording:
            assert recording.info().complete
            assert [command for _, command in recording.commands()] == [brake("master", number / 4)]
