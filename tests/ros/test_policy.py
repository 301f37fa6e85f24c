"""The policy for SROS 2 allows what the programs do, and lets no observer act: with Enforce it ends who does more."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable
from contextlib import suppress
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy")

from rclpy.node import Node, NodeNameNonExistentError

from haul_ros.messages.channels import channel_table
from haul_ros.model.command import Command, CommandKind
from haul_ros.ros import brake_client
from tests.ros.live_node import TABLE, Couplers

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

POLICY = Path(__file__).parents[2] / "config/security/haul.policy.xml"
FAULTS = [channel.topic for channel in channel_table(["master"], pneumatic=True).faults.values()]
COMMANDS = [channel.topic for by_locomotive in TABLE.commands.values() for channel in by_locomotive.values()]


def refused(enclave: str, kind: str, act: str, names: Iterable[str]) -> list[str]:
    """Those of the names that an enclave may not publish, subscribe, request or reply."""
    rules = ET.parse(POLICY).findall(f"enclaves/enclave[@path='{enclave}']/profiles/profile/{kind}[@{act}='ALLOW']/*")
    return [name for name in names if not any(fnmatchcase(name, rule.text or "") for rule in rules)]


def _replies(observer: Observer) -> int:
    """Services of the node that have been found; its messages may come before its name."""
    with suppress(NodeNameNonExistentError):
        return len(observer.graph_of("haul")["reply"])
    return 0


def test_the_node_may_do_all_that_it_does(start_node: Callable[..., LiveNode], observer: Observer) -> None:
    start_node(record_path="none", publish_clock=True)
    Couplers(observer).wait_for_time(0)
    observer.wait_until(lambda: _replies(observer) >= 10, "the services of the node")
    found = observer.graph_of("haul")
    assert {TABLE.couplers.topic, "/clock", "/rosout"} <= set(found["publish"])
    assert set(COMMANDS) <= set(found["subscribe"])
    assert refused("/haul", "topics", "subscribe", FAULTS) == []
    assert {"/haul/pause", "/haul/set_parameters"} <= set(found["reply"])
    for act, names in found.items():
        assert refused("/haul", "services" if act == "reply" else "topics", act, names) == []


def test_a_driver_may_do_all_that_haul_brake_does_whatever_the_name_of_its_node(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    replies: list[str] = []

    def look(node: Node, *_: object) -> None:
        replies.extend(name for name, _ in node.get_service_names_and_types_by_node(node.get_name(), "/"))

    monkeypatch.setattr(brake_client, "_publish", look)
    brake_client.publish_command(Command("master", CommandKind.EMERGENCY, 1.0))
    assert replies == ["/haul_brake/get_type_description"]
    assert refused("/driver", "services", "reply", replies) == []
    assert refused("/driver", "topics", "publish", [*COMMANDS, "/parameter_events"]) == []
    assert refused("/driver", "topics", "subscribe", [c.topic for c in TABLE.applied_brake.values()]) == []
    assert refused("/driver", "services", "request", ["/haul/pause", "/haul/reset", "/haul/set_parameters"]) == []
    assert refused("/driver", "topics", "publish", [TABLE.couplers.topic]) != []


def test_an_observer_may_see_all_and_do_nothing() -> None:
    seen = [channel.topic for channel in TABLE if not channel.received]
    assert refused("/observer", "topics", "subscribe", [*seen, *COMMANDS]) == []
    assert refused("/observer", "topics", "publish", COMMANDS) == COMMANDS
    acts = ["/haul/pause", "/haul/step", "/haul/reset", "/haul/set_parameters"]
    assert refused("/observer", "services", "request", acts) == acts
    assert refused("/observer", "services", "reply", acts) == acts
    assert refused("/observer", "services", "reply", ["/_ros2cli_1/get_type_description"]) == []


def test_an_instructor_may_let_the_train_fail_and_a_driver_may_not() -> None:
    assert refused("/instructor", "topics", "publish", FAULTS) == []
    assert refused("/instructor", "topics", "publish", COMMANDS) == COMMANDS
    for enclave in ("/driver", "/observer"):
        assert refused(enclave, "topics", "publish", FAULTS) == FAULTS
