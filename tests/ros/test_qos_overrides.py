"""Quality of service overridden with ROS's own parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy")

from mcap.reader import make_reader
from rosbags.interfaces import QosReliability
from ruamel.yaml import YAML

from haul_ros.messages.channels import channel_table
from haul_ros.ros.parameters import ParameterError
from haul_ros.ros.qos_overrides import check_qos, qos_rows, with_qos
from tests.ros.live_node import TABLE, Couplers

if TYPE_CHECKING:
    from pathlib import Path

    from tests.ros.live_node import LiveNode, Observer

COUPLERS = "qos_overrides./haul/couplers.publisher"
SHARED = """\
/**:
  ros__parameters:
    qos_overrides:
      /haul/couplers:
        publisher: {depth: 7, reliability: best_effort}
      /tf:
        publisher: {durability: volatile}
"""


def test_the_overridden_profile_is_offered_recorded_and_described(
    start_node: Callable[..., LiveNode], observer: Observer, tmp_path: Path
) -> None:
    (tmp_path / "shared.yaml").write_text(SHARED)
    node = start_node(record_path="run.mcap", ros_arguments=["--params-file", str(tmp_path / "shared.yaml")])
    vehicles = observer.watch_typed(TABLE.vehicles)
    couplers = Couplers(observer)  # asks for reliable ones, which are not offered
    observer.wait_until(lambda: bool(vehicles), "a sample")
    assert observer.offered(TABLE.couplers) == ["BEST_EFFORT"]
    assert observer.offered(TABLE.vehicles) == ["RELIABLE"]
    assert observer.parameter(f"{COUPLERS}.depth").integer_value == 7
    assert observer.parameter("qos_overrides./haul/vehicles.publisher.depth").integer_value == 50
    assert "read-only" in observer.set_parameter(f"{COUPLERS}.depth", 8).reason
    assert couplers.time_ns == -1
    assert node.end() == 0
    with (node.folder / "run.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    (channel,) = (c for c in summary.channels.values() if c.topic == "/haul/couplers")
    (profile,) = YAML(typ="safe").load(channel.metadata["offered_qos_profiles"])
    assert (profile["depth"], profile["reliability"]) == (7, "best_effort")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        (f"{COUPLERS}.depth", 0, r"publisher\.depth = 0, must be 1 to 1000"),
        (f"{COUPLERS}.depth", "many", r"publisher\.depth = 'many', must be a whole number"),
        (f"{COUPLERS}.reliability", "best", r"publisher\.reliability = 'best', must be one of reliable, best_effort"),
        (f"{COUPLERS}.durability", "volatile", r"cannot be overridden for /haul/couplers, only publisher\.depth and"),
        ("qos_overrides./haul/events.publisher.depth", 9, r"cannot be overridden for /haul/events, only .* /haul/coup"),
        (
            "qos_overrides./haul/master/brake_command.subscription.reliability",
            "best_effort",
            r"cannot be overridden for /haul/master/brake_command",
        ),
    ],
)
def test_what_cannot_be_overridden_is_refused_in_one_line(name: str, value: object, message: str) -> None:
    with pytest.raises(ParameterError, match=message) as refused:
        check_qos({name: value}, TABLE)
    assert "\n" not in str(refused.value)


def test_only_what_was_given_differs_and_other_nodes_topics_are_theirs() -> None:
    given = {f"{COUPLERS}.reliability": "best_effort", "qos_overrides./tf.publisher.depth": "deep"}
    values = check_qos(given, TABLE)
    assert values.keys() == qos_rows(TABLE).keys()
    changed = with_qos(values, TABLE)
    assert changed.couplers.qos == TABLE.couplers.qos._replace(reliability=QosReliability.BEST_EFFORT)
    assert [c for c in changed if c.topic != "/haul/couplers"] == [c for c in TABLE if c.topic != "/haul/couplers"]


def test_pneumatic_pressures_are_samples_too() -> None:
    rows = qos_rows(channel_table(["master"], pneumatic=True))
    assert "qos_overrides./haul/brake_pipe_pressure.publisher.depth" in rows
