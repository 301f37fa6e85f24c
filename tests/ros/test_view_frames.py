"""Frames of the live page, and where it takes locomotives to be, without a node."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.consist import Consist
from haul_ros.model.log import PeriodLog
from haul_ros.model.sample import Sample
from haul_ros.page.train import locomotive_vehicles
from haul_ros.resources import shipped_scenarios
from haul_ros.ros.view.frames import FrameMaker
from haul_ros.scenario import load_scenario

MakeSample = Callable[[int], Sample]


def messages(encoder: TelemetryEncoder, *samples: Sample) -> list[list[bytes]]:
    """Of couplers, vehicles, cylinders and pipe."""
    made = [encoder.messages(PeriodLog(sample.time_ns, (), sample)) for sample in samples]
    return [[sent[k].data for sent in made] for k in range(3)] + [[]]


def test_a_frame_has_the_largest_forces_of_its_samples_and_the_rest_of_the_last(
    encoder: TelemetryEncoder, make_sample: MakeSample
) -> None:
    samples = [make_sample(step) for step in (50, 51, 52)]
    maker = FrameMaker(pneumatic=False)
    made = maker.frame(*messages(encoder, *samples))
    assert made is not None
    time, frame = made
    assert time == np.frombuffer(frame[:8], "<f8")[0] == 1.04
    forces, last = np.array([sample.coupler_force for sample in samples]) / 1e3, samples[-1]
    largest = forces[np.abs(forces).argmax(axis=0), np.arange(4)]
    assert len({*np.abs(forces).argmax(axis=0)}) > 1  # not all of one sample
    speed = 3.6 * last.speed[[0, 2, 4]]
    expected = np.concatenate([speed, largest, last.stroke * 1e3, last.cylinder_pressure / 1e3])
    np.testing.assert_allclose(np.frombuffer(frame[8:], "<f4"), expected, rtol=1e-6)


def test_there_is_no_frame_before_all_names_are_known_and_without_a_new_sample(
    encoder: TelemetryEncoder, make_sample: MakeSample
) -> None:
    couplers, vehicles, pressures, none = messages(encoder, make_sample(1))
    maker = FrameMaker(pneumatic=False)
    assert maker.frame(couplers, [], [], none) is None
    assert maker.frame([], vehicles, pressures, none) is None
    assert maker.frame(couplers, [], [], none) is not None
    assert maker.frame([], [], [], none) is None


def test_samples_of_another_train_are_not_taken_for_this_one(
    encoder: TelemetryEncoder, consist: Consist, make_sample: MakeSample
) -> None:
    maker = FrameMaker(pneumatic=False)
    maker.frame(*messages(encoder, make_sample(1)))
    longer = TelemetryEncoder(load_scenario("daqin_1_1_0").consist)
    sample = Sample(2, 40_000_000, *(np.zeros(205) for _ in range(3)), *(np.zeros(206) for _ in range(4)))
    with pytest.raises(ValueError, match="layout"):
        maker.frame(*messages(longer, sample))


@pytest.mark.parametrize("name", list(shipped_scenarios()))
def test_locomotives_of_shipped_scenarios_are_found_by_names_of_vehicles_alone(name: str) -> None:
    consist = load_scenario(name).consist
    expected = {locomotive.name: locomotive.vehicle for locomotive in consist.locomotives}
    assert locomotive_vehicles(consist.vehicle_names, list(expected)) == expected


def test_where_names_do_not_tell_nothing_is_guessed() -> None:
    vehicles = ["vehicle_001_SS4", "vehicle_002_C80", "vehicle_003_HXD1"]
    assert locomotive_vehicles(vehicles, ["master", "slave_1"]) == {"master": None, "slave_1": None}
