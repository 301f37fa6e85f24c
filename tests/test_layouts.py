"""The layouts for viewers name topics, fields, couplers and services that there are, with their types."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from typing import Any

import pytest
from rosbags.typesys import Stores, get_typestore

from haul_ros.messages.channels import ChannelTable, channel_table
from haul_ros.messages.force_image import IMAGE
from haul_ros.messages.train_markers import MARKERS
from haul_ros.resources import config_dir
from haul_ros.scenario import load_scenario

LAYOUTS = config_dir() / "layouts"
TRAIN = load_scenario("daqin_1_2_1").consist
TABLE: ChannelTable = channel_table([locomotive.name for locomotive in TRAIN.locomotives])
TYPES = {channel.topic: channel.msgtype for channel in TABLE}
PICTURES = {"/haul/force_image": IMAGE, "/haul/train_markers": MARKERS}
SERVICES = {"/haul/pause", "/haul/step", "/haul/reset"}
LENGTHS = {TABLE.couplers.topic: len(TRAIN.couplers), TABLE.vehicles.topic: len(TRAIN.vehicles)}
LENGTHS[TABLE.brake_cylinder_pressure.topic] = len(TRAIN.vehicles)


def fields(msgtype: str) -> set[str]:
    return {name for name, _ in get_typestore(Stores.ROS2_JAZZY).fielddefs[msgtype][1]}


def panels(layout: dict[str, Any]) -> Iterator[str]:
    """Those that are shown."""
    here = layout["layout"]
    waiting = [here]
    while waiting:
        part = waiting.pop()
        if isinstance(part, str):
            yield part
        else:
            waiting += [part["first"], part["second"]]


@pytest.mark.parametrize("name", ["foxglove_recording", "foxglove_live"])
def test_foxglove_and_lichtblick_are_shown_what_there_is(name: str) -> None:
    layout = json.loads((LAYOUTS / f"{name}.json").read_text("utf-8"))
    configs = layout["configById"]
    assert sorted(panels(layout)) == sorted(configs)
    for panel, config in configs.items():
        for path in config.get("paths", ()):
            found = re.fullmatch(r"(/[\w/]+)\.(\w+)(?:\[(-?\d+|:)\])?", path["value"])
            assert found is not None, path["value"]
            topic, field, index = found.groups()
            assert field in fields(TYPES[topic])
            if index not in (None, ":"):
                assert int(index) < LENGTHS[topic]
                if topic == TABLE.couplers.topic:
                    assert path["label"] == TRAIN.coupler_names[int(index)]
        if panel.startswith("Publish!"):
            assert TYPES[config["topicName"]] == config["datatype"]
            assert set(json.loads(config["value"])) == {"data"}
        if panel.startswith("CallService!"):
            assert config["serviceName"] in SERVICES
        for key in ("topicToRender",):
            assert config.get(key, "/diagnostics") in TYPES
        shown = [config["imageMode"]["imageTopic"]] if "imageMode" in config else list(config.get("topics", ()))
        assert set(shown) <= PICTURES.keys()


def test_a_recording_is_shown_nothing_that_only_a_live_node_has() -> None:
    text = (LAYOUTS / "foxglove_recording.json").read_text("utf-8")
    assert not [topic for topic in (*PICTURES, *SERVICES) if topic in text]


def test_plotjuggler_is_shown_what_there_is() -> None:
    curves = [curve.attrib["name"] for curve in ET.parse(LAYOUTS / "plotjuggler.xml").iter("curve")]
    assert len(curves) > 10
    names = {TABLE.couplers.topic: TRAIN.coupler_names, TABLE.vehicles.topic: TRAIN.vehicle_names}
    for curve in curves:
        topic, rest = next((t, curve.removeprefix(f"{t}/")) for t in TYPES if curve.startswith(f"{t}/"))
        if topic in names:  # JointState: /topic/name/field
            joint, field = rest.split("/")
            assert joint in names[topic]
            assert field in ("position", "velocity", "effort")
        else:
            found = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", rest)
            assert found is not None
            assert found[1] in fields(TYPES[topic])
            assert found[2] is None or int(found[2]) < LENGTHS[topic]
