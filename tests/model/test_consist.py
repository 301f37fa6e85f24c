"""The formation: names as published, mass, length and where the vehicles stand."""

from __future__ import annotations

import pytest

from haul_ros.model.consist import Consist, Locomotive
from haul_ros.model.draft_gear import DraftGear, SideCurves
from haul_ros.model.vehicle import RunningResistance, ShoeFriction, VehicleType

_NO_RESISTANCE = RunningResistance(0.0, 0.0, 0.0, 0.0)
_SHOE = ShoeFriction(0.3, 1.0, 1.0, 0.0, 1.0, 0.0, 1.0)
SS4 = VehicleType("SS4", 184e3, 32.83, _NO_RESISTANCE, 16, 30e3, _SHOE, 450e3)
C80 = VehicleType("C80", 100e3, 12.0, _NO_RESISTANCE, 8, 24.4e3, _SHOE, 360e3)
_SIDE = SideCurves(((0.0, 0.0), (1.0, 3e7)), ((0.0, 0.0), (1.0, 9e6)))
GEAR = DraftGear("gear", _SIDE, _SIDE, 0.01)

TRAIN = Consist((SS4, C80, C80, SS4), (GEAR, None, GEAR), (Locomotive("master", 0), Locomotive("slave_1", 3)))


def test_vehicles_and_couplers_are_numbered_from_1_at_the_head() -> None:
    assert TRAIN.vehicle_names == ("vehicle_001_SS4", "vehicle_002_C80", "vehicle_003_C80", "vehicle_004_SS4")
    assert TRAIN.coupler_names == ("coupler_001", "coupler_002", "coupler_003")


def test_mass_and_length_are_the_sums_of_the_vehicles() -> None:
    assert TRAIN.mass == pytest.approx(568e3)
    assert TRAIN.length == pytest.approx(89.66)


def test_centres_lie_half_a_vehicle_behind_each_vehicle_s_own_head() -> None:
    assert TRAIN.centre_offsets == pytest.approx([16.415, 38.83, 50.83, 73.245])


def test_locomotives_are_found_by_name() -> None:
    assert TRAIN.locomotive("slave_1") == Locomotive("slave_1", 3)
    assert TRAIN.locomotive("slave_2") is None


@pytest.mark.parametrize("n_couplers", [2, 4])
def test_a_train_has_one_coupler_less_than_vehicles(n_couplers: int) -> None:
    with pytest.raises(ValueError, match=f"4 vehicles need 3 couplers, not {n_couplers}"):
        Consist(TRAIN.vehicles, (GEAR,) * n_couplers, TRAIN.locomotives)
