"""Which vehicles are one mass."""

from __future__ import annotations

import numpy as np

from haul_ros.physics.lumping import lump
from tests.physics.physics_cases import linear_gear, train_of, vehicle

GEAR = linear_gear()


def test_vehicles_joined_by_drawbars_are_one_mass_and_draft_gears_lie_between_masses() -> None:
    wagons = [vehicle(mass * 1e3) for mass in (184, 20, 30, 40, 50, 60)]
    lumped = lump(train_of(wagons, [GEAR, None, None, GEAR, None]))
    np.testing.assert_array_equal(lumped.mass, [184e3, 90e3, 110e3])
    np.testing.assert_array_equal(lumped.first, [0, 1, 4])
    np.testing.assert_array_equal(lumped.end, [1, 4, 6])
    np.testing.assert_array_equal(lumped.mass_index, [0, 1, 1, 1, 2, 2])
    np.testing.assert_array_equal(lumped.rigid, [False, True, True, False, True])
    assert lumped.gears == (GEAR, GEAR)


def test_a_single_vehicle_and_a_wholly_rigid_train_are_one_mass() -> None:
    assert lump(train_of([vehicle(1e5)], GEAR)).mass.tolist() == [1e5]
    rigid = lump(train_of([vehicle(1e5)] * 4, None))
    assert rigid.mass.tolist() == [4e5]
    assert rigid.gears == ()
