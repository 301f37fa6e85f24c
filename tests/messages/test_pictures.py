"""Pictures for viewers: what colour, which row, which column, which box."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from haul_ros.messages.force_colours import force_colours
from haul_ros.messages.force_image import COLUMNS, IMAGE, ForceImage
from haul_ros.messages.train_markers import MARKERS, TrainMarkers
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session

RED, BLUE, NONE = (0x67, 0x00, 0x1F), (0x05, 0x30, 0x61), (0xF7, 0xF7, 0xF7)
"""Ends and middle of ColorBrewer's RdBu with eleven classes (colorbrewer2.org)."""
LIMIT = 1e6


def decoded(data: bytes, msgtype: str) -> Any:
    return get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(data, msgtype)


def pixels(data: bytes) -> Any:
    image = decoded(data, IMAGE)
    assert (image.encoding, image.step) == ("rgb8", 3 * image.width)
    return image.data.reshape(image.height, image.width, 3)


@pytest.mark.parametrize(
    ("force", "colour"),
    [
        (LIMIT, RED),
        (-LIMIT, BLUE),
        (0.0, NONE),
        (9e9, RED),
        (-9e9, BLUE),
        (0.2 * LIMIT, (0xFD, 0xDB, 0xC7)),
        (-0.8 * LIMIT, (0x21, 0x66, 0xAC)),
    ],
)
def test_compression_is_red_and_tension_blue(force: float, colour: tuple[int, int, int]) -> None:
    np.testing.assert_allclose(force_colours([force], LIMIT)[0].astype(int), colour, atol=3)


def test_a_column_has_the_largest_force_since_the_last_one_and_scrolls_to_the_left() -> None:
    image = ForceImage(2)
    for force in ([0.0, 0.0], [LIMIT, -0.1 * LIMIT], [-0.5 * LIMIT, -LIMIT], [0.2 * LIMIT, 0.0]):
        image.add(np.array(force))
    first = pixels(image.scroll(2_500_000_000, "train_a/haul", LIMIT))
    assert first.shape == (2, COLUMNS, 3)
    assert tuple(first[0, -1]) == RED
    assert tuple(first[1, -1]) == BLUE
    assert (first[:, :-1] == NONE).all()
    image.add(np.zeros(2))
    data = image.scroll(3_000_000_000, "train_a/haul", LIMIT)
    second = pixels(data)
    assert (second[:, -2] == first[:, -1]).all()
    assert (second[:, -1] == NONE).all()
    header = decoded(data, IMAGE).header
    assert (header.stamp.sec, header.stamp.nanosec, header.frame_id) == (3, 0, "train_a/haul")


def test_boxes_stand_where_the_vehicles_are_and_have_the_colour_of_the_larger_force_at_their_ends() -> None:
    scenario = load_scenario("daqin_1_2_1", {"max_duration_s": 6.0})
    session = Session(scenario, play_commands=True)
    while not session.finished:
        sample = session.advance()
    consist = scenario.consist
    markers = decoded(TrainMarkers(consist).encode(sample, "haul", 1e5), MARKERS).markers
    boxes, (text,) = [m for m in markers if m.ns != "largest"], [m for m in markers if m.ns == "largest"]
    assert sum(len(box.points) for box in boxes) == len(consist.vehicles)
    found = {round(p.x, 6): (box, c) for box in boxes for p, c in zip(box.points, box.colors, strict=True)}
    head = sample.chainage[0] + consist.vehicles[0].length / 2
    for i, vehicle in enumerate(consist.vehicles):
        box, colour = found[round(sample.chainage[i] - head, 6)]
        assert box.scale.x == pytest.approx(vehicle.length, abs=1.0)
        is_locomotive = i in {locomotive.vehicle for locomotive in consist.locomotives}
        assert box.ns == ("locomotives" if is_locomotive else "vehicles")
        at_ends = sample.coupler_force[max(i - 1, 0) : i + 1]
        larger = at_ends[np.argmax(np.abs(at_ends))]
        shade = (colour.r, colour.g, colour.b)
        np.testing.assert_allclose(shade, force_colours([larger], 1e5)[0] / 255, atol=1e-6)
        assert colour.a == 1.0
    largest = int(np.argmax(np.abs(sample.coupler_force)))
    assert text.text == f"coupler_{largest + 1:03d}: {sample.coupler_force[largest] / 1e3:.0f} kN"
    assert sample.chainage[largest + 1] < text.pose.position.x + head < sample.chainage[largest]
    assert {m.header.frame_id for m in markers} == {"haul"}
    assert len({(m.ns, m.id) for m in markers}) == len(markers)


def test_a_vehicle_alone_is_a_box_without_a_text() -> None:
    scenario = load_scenario("daqin_1_2_1")
    one = scenario.consist.__class__(scenario.consist.vehicles[:1], (), scenario.consist.locomotives[:1])
    sample = Session(load_scenario("daqin_1_2_1")).advance()
    alone = sample.__class__(
        step=0,
        time_ns=0,
        **{name: np.empty(0) for name in ("stroke", "stroke_rate", "coupler_force")},
        **{name: np.zeros(1) for name in ("chainage", "speed", "brake_force", "cylinder_pressure")},
    )
    (box,) = decoded(TrainMarkers(one).encode(alone, "haul", 1e5), MARKERS).markers
    assert (box.ns, len(box.points)) == ("locomotives", 1)
