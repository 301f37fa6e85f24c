"""What goes out at rates of its own and into no recording: clock, pictures, state."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from haul_ros.messages.channels import EVENT, Channel
from haul_ros.messages.force_colours import force_colours
from haul_ros.messages.force_image import IMAGE
from haul_ros.messages.train_markers import MARKERS
from haul_ros.model.command import CommandKind
from haul_ros.recording.reader import Recording
from haul_ros.ros.unrecorded import CLOCK_CHANNEL, Unrecorded, UnrecordedRates, state_channel
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session
from tests.ros.live_node import Couplers

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

SECOND = 10**9
FORCE_IMAGE = Channel("/haul/force_image", IMAGE, EVENT)
TRAIN_MARKERS = Channel("/haul/train_markers", MARKERS, EVENT)


def times(stamps: list[Any]) -> list[int]:
    return [stamp.sec * SECOND + stamp.nanosec for stamp in stamps]


def counts(rate: float, sample_rate: float, seconds: float) -> tuple[int, list[int]]:
    """How many samples there are at a rate, and the numbers of those with a clock."""
    sample = Session(load_scenario("daqin_1_2_1")).advance()
    unrecorded = Unrecorded(load_scenario("daqin_1_2_1").consist, "/haul", UnrecordedRates(clock=rate), lambda: 1e6)
    numbers = range(round(seconds * sample_rate) + 1)
    at = [replace(sample, time_ns=round(n / sample_rate * SECOND)) for n in numbers]
    return len(at), [n for n, one in zip(numbers, at, strict=True) if unrecorded.messages(one)]


@pytest.mark.parametrize(
    ("rate", "sample_rate", "every"),
    [(10.0, 50.0, 5), (1.0, 50.0, 50), (50.0, 50.0, 1), (200.0, 50.0, 1), (np.inf, 50.0, 1), (1.0, 30.0, 30)],
)
def test_each_has_its_rate_in_simulation_time_from_the_first_sample_on(
    rate: float, sample_rate: float, every: int
) -> None:
    number, due = counts(rate, sample_rate, 20.0)
    assert due == list(range(0, number, every))


def test_a_rate_that_does_not_divide_that_of_the_samples_is_kept_on_average() -> None:
    _, due = counts(15.0, 50.0, 20.0)
    assert len(due) == 15 * 20 + 1
    assert set(np.diff(due)) == {3, 4}


@pytest.fixture
def node_with_pictures(start_node: Callable[..., LiveNode]) -> Iterator[LiveNode]:
    yield start_node(
        record_path="run.mcap",
        publish_clock=True,
        clock_rate=5.0,
        force_image_rate=10.0,
        train_markers_rate=2.0,
        picture_force=2e5,
    )


@pytest.mark.slow
def test_clock_and_pictures_of_a_live_train_have_their_rates_and_its_forces(
    node_with_pictures: LiveNode, observer: Observer
) -> None:
    clock = observer.watch_typed(CLOCK_CHANNEL)
    images, markers = observer.watch_typed(FORCE_IMAGE), observer.watch_typed(TRAIN_MARKERS)
    couplers = Couplers(observer)
    observer.send("master", CommandKind.EMERGENCY, True)
    couplers.wait_for_time(5 * SECOND)
    observer.wait_until(lambda: len(images) > 10 and len(markers) > 4 and len(clock) > 10, "pictures and clock")
    assert node_with_pictures.end() == 0
    assert {time % (SECOND // 5) for time in times([message.clock for message in clock])} == {0}
    assert {time % (SECOND // 10) for time in times([image.header.stamp for image in images])} == {0}
    assert {time % (SECOND // 2) for time in times([array.markers[0].header.stamp for array in markers])} == {0}

    forces = dict(zip(times([s.header.stamp for s in couplers.received]), couplers.received, strict=True))
    shown = 0
    for image in images:
        (now,) = times([image.header.stamp])
        since = [now - back * SECOND // 50 for back in range(5)]
        if all(time in forces for time in since):
            at = np.array([forces[time].effort for time in since])
            largest = at[np.argmax(np.abs(at), axis=0), np.arange(at.shape[1])]
            pixels = np.array(image.data).reshape(image.height, image.width, 3)
            np.testing.assert_array_equal(pixels[:, -1], force_colours(largest, 2e5))
            shown += bool(np.abs(largest).max() > 1e5)
    assert shown > 5
    assert markers[-1].markers[0].header.frame_id == images[-1].header.frame_id == "haul"
    with Recording(node_with_pictures.folder / "run.mcap") as recording:
        topics = {info.topic for info in recording.info().topics}
    assert not {"/clock", "/haul/force_image", "/haul/train_markers", "/haul/state"} & topics


@pytest.mark.slow
def test_a_late_subscriber_knows_what_the_node_does(start_node: Callable[..., LiveNode], observer: Observer) -> None:
    node = start_node(record_path="none")
    first = observer.watch_typed(state_channel("/haul"))
    observer.wait_until(lambda: bool(first) and first[-1].data == "running", "the state")
    assert observer.pause().success
    late = observer.watch_typed(state_channel("/haul"))
    observer.wait_until(lambda: bool(late), "the state for a late subscriber")
    assert late[0].data == "paused"
    observer.pause(False)
    observer.wait_until(lambda: late[-1].data == "running", "that it runs again")
    assert node.end() == 0
