"""A train that comes apart: forces, energy, each part as a train of its own, and the two of them meeting again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from haul_ros.model.consist import Consist
from haul_ros.model.draft_gear import DraftGear
from haul_ros.physics.energy import energy_balance
from haul_ros.physics.parting import PartingKind
from haul_ros.physics.train_model import TrainModel, WaveKind
from tests.physics.air_cases import air_train
from tests.physics.physics_cases import MT2, WAGON_RESISTANCE, brake_system, linear_gear, model, train_of, vehicle

STIFFNESS = 3e7


def at_speeds(consist: Consist, speeds: Sequence[float], strokes: Sequence[float]) -> TrainModel:
    """A train whose hoses never part, so that nothing brakes."""
    initial_speed, initial_stroke = np.array(speeds), np.array(strokes)
    return TrainModel(
        consist, brake_system(), initial_speed=initial_speed, initial_stroke=initial_stroke, hose_reach=np.inf
    )


def stopping_ways(train: TrainModel) -> NDArray[np.float64]:
    """Ways of the vehicles [m] to where they stand for good."""
    start = train.displacement
    while not (train.at_standstill and train.brakes_settled):
        assert train.time < 120.0
        train.advance(1000)
    return np.array(train.displacement - start)


def test_an_opened_coupler_bears_no_draft_and_what_its_gear_held_is_lost() -> None:
    """Gears without hysteresis: what is dissipated in the end is the energy under the curve where it was opened."""
    train = at_speeds(train_of([vehicle()] * 3, linear_gear()), [10.1, 10.0, 9.9], [0.0, 0.0])
    train.advance(40)
    stroke, force = train.train.gears.stroke[1], train.train.gears.force[1]
    assert force < -50e3
    train.uncouple(1)
    (parting,) = train.take_partings()
    assert (parting.kind, parting.coupler, parting.time) == (PartingKind.UNCOUPLED, 1, 0.04)
    assert parting.tension == -force
    speed = train.speed[2]
    train.advance(20_000)
    assert train.speed[2] == speed, "nothing pulls the last vehicle any more"
    energy = energy_balance(train)
    assert energy.gear_dissipated == pytest.approx(0.5 * STIFFNESS * stroke**2, rel=1e-9)
    assert abs(energy.relative_imbalance) < 1e-13
    assert energy.fault is None


def test_buff_is_borne_as_before() -> None:
    """Opened while pushed, a coupler lets go only where the draft would begin: half a period of two masses."""
    trains = [at_speeds(train_of([vehicle()] * 2, linear_gear()), [10.0, 10.5], [0.0]) for _ in range(2)]
    trains[0].uncouple(0)
    half_period = np.pi / np.sqrt(STIFFNESS * 2.0 / 100e3)
    for train in trains:
        train.advance(int(half_period * 1000))
    assert trains[0].sample().coupler_force.tobytes() == trains[1].sample().coupler_force.tobytes()
    for train in trains:
        train.advance(100)
    assert trains[0].sample().coupler_force[0] == 0.0
    assert trains[1].sample().coupler_force[0] < -100e3


@pytest.mark.parametrize("masses", [(100e3, 100e3), (184e3, 60e3)])
def test_parts_that_meet_again_without_loss_exchange_their_momentum_as_two_bodies_do(
    masses: tuple[float, float],
) -> None:
    front, rear = masses
    consist = train_of([vehicle(front), vehicle(rear)], linear_gear())
    train = at_speeds(consist, [5.0, 6.5], [-0.75])
    train.uncouple(0)
    train.advance(2000)
    mean = (front * 5.0 + rear * 6.5) / (front + rear)
    assert train.speed == pytest.approx([2.0 * mean - 5.0, 2.0 * mean - 6.5], rel=1e-9)
    assert energy_balance(train).fault is None
    assert abs(energy_balance(train).relative_imbalance) < 1e-12


def test_parts_that_meet_across_a_lossy_gear_keep_their_momentum_and_lose_what_it_dissipates() -> None:
    gear = linear_gear(3e7, 0.9e7)
    train = at_speeds(train_of([vehicle()] * 2, gear), [5.0, 6.5], [-0.75])
    train.uncouple(0)
    train.advance(3000)
    front, rear = train.speed
    assert front + rear == pytest.approx(11.5, rel=1e-12)
    assert front > rear, "they part again"
    # By the velocity method they come back on the unloading curve: (v'/v)^2 = K2/K1, less what its transition takes
    assert (front - rear) ** 2 / 1.5**2 == pytest.approx(0.3, rel=0.02)
    lost = 0.5 * 100e3 * (5.0**2 + 6.5**2 - front**2 - rear**2)
    # what the gear held in draft when it was opened was lost too, and did not come from this motion
    held = 0.5 * (3e7 + 0.9e7) / 2.0 * 0.75**2
    assert energy_balance(train).gear_dissipated == pytest.approx(lost + held, rel=1e-9)


def test_a_coupler_breaks_at_the_step_that_takes_its_tension_past_its_strength_however_steps_are_grouped() -> None:
    strong, weak = linear_gear(), replace(linear_gear(), strength=200e3)
    consist = train_of([vehicle(tractive_effort=600e3), *[vehicle()] * 4], [strong, strong, weak, strong])
    samples = []
    for group in (1, 7, 4000):
        train = model(consist, 5.0)
        train.set_traction(0, 600e3)
        whole = model(replace(consist, couplers=(strong,) * 4), 5.0)
        whole.set_traction(0, 600e3)
        while train.step < 4000:
            train.advance(min(group, 4000 - train.step))
        broken, hose = train.take_partings()
        assert (broken.kind, broken.coupler) == (PartingKind.BROKEN, 2)
        whole.advance(round(broken.time / train.time_step) - 1)
        assert -whole.sample().coupler_force[2] <= 200e3
        whole.advance(1)
        assert -whole.sample().coupler_force[2] == broken.tension > 200e3
        assert (hose.kind, hose.coupler) == (PartingKind.HOSE, 2)
        assert 0.3 < hose.gap < 0.31
        samples.append(train.sample())
    assert len({sample.coupler_force.tobytes() + sample.chainage.tobytes() for sample in samples}) == 1


def test_a_strength_that_is_not_reached_changes_no_bit() -> None:
    plain = [linear_gear(3e7, 2e7)] * 3
    trains = []
    for couplers in (plain, [replace(gear, strength=1e9) for gear in plain]):
        train = model(train_of([vehicle(resistance=WAGON_RESISTANCE)] * 4, couplers), 15.0)
        train.start_wave(0.0, 0, WaveKind.EMERGENCY)
        train.advance(5000)
        trains.append(train)
    assert trains[0].sample().coupler_force.tobytes() == trains[1].sample().coupler_force.tobytes()


def test_an_emergency_runs_from_both_ends_of_the_gap_and_each_part_stops_as_a_train_of_its_own() -> None:
    """The empirical brake: the rear part has twice the brakes, so it does not run into the front one."""
    gear = linear_gear(3e7, 2e7)
    front = [vehicle(resistance=WAGON_RESISTANCE)] * 5
    rear = [vehicle(resistance=WAGON_RESISTANCE, shoes=16)] * 4
    train = model(train_of([*front, *rear], gear), 15.0)
    train.uncouple(4)
    train.part_hose(4)
    together = stopping_ways(train)
    alone = []
    for vehicles, at in ((front, 4), (rear, 0)):
        part = model(train_of(vehicles, gear), 15.0)
        part.start_wave(0.0, at, WaveKind.EMERGENCY)
        alone.append(stopping_ways(part))
    assert together == pytest.approx(np.concatenate(alone), rel=1e-9)
    assert together[4] > together[5] + 10.0
    energy = energy_balance(train)
    assert abs(energy.relative_imbalance) < 1e-12
    assert energy.fault is None


def test_a_rear_part_that_brakes_less_runs_into_the_front_one_and_pushes_it() -> None:
    """The way of both, and what they are worth together: momentum and energy of a collision of braked trains."""
    gear = linear_gear(3e7, 0.9e7)
    front = [vehicle(resistance=WAGON_RESISTANCE, shoes=16)] * 5
    rear = [vehicle(resistance=WAGON_RESISTANCE)] * 4
    train = model(train_of([*front, *rear], gear), 15.0)
    train.uncouple(4)
    train.part_hose(4)
    stopping_ways(train)
    assert train.extremes().compression[4] > 100e3
    assert train.extremes().tension[4] == 0.0
    energy = energy_balance(train)
    assert abs(energy.relative_imbalance) < 1e-12
    assert energy.fault is None


def test_no_brake_wave_passes_a_parted_hose() -> None:
    train = model(train_of([vehicle()] * 10, linear_gear()), 15.0)
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.5)
    train.advance(150)  # at 200 m/s past the third vehicle
    train.part_hose(5)
    train.advance(5000)
    assert train.brake_targets.tolist() == [1.0] * 10, "the emergency from either end"
    assert train.waves_under_way == 0
    released = model(train_of([vehicle()] * 10, linear_gear()), 15.0)
    released.part_hose(5)
    released.advance(1000)
    released.start_wave(1.0, 0, WaveKind.EMERGENCY_RELEASE)
    released.advance(5000)
    assert released.brake_targets.tolist() == [0.0] * 6 + [1.0] * 4


def test_the_gap_is_neither_a_stroke_nor_a_closed_gear() -> None:
    gear = DraftGear("MT-2", MT2, MT2, 0.01, slack=0.02, maximum_stroke=0.083, bottoming_stiffness=5e8)
    train = at_speeds(train_of([vehicle()] * 3, gear), [10.5, 10.0, 10.0], [0.0, 0.0])
    train.advance(30)
    before = train.extremes()
    train.uncouple(0)
    train.advance(10_000)
    after = train.extremes()
    assert train.sample().stroke[0] < -3.0
    assert after.tension_stroke[0] == before.tension_stroke[0] > 0.0
    assert after.tension[0] == before.tension[0]
    assert np.isnan(after.bottomed_time).all()


@pytest.mark.parametrize("locomotives", [(0,), (0, 10)])
def test_parts_with_a_pneumatic_brake_stop_as_trains_of_their_own_with_an_open_pipe(
    locomotives: tuple[int, ...],
) -> None:
    """The front part is faster by 2 m/s, so that they never meet."""
    at, vehicles = 8, 20 + len(locomotives)
    speeds = np.where(np.arange(vehicles) <= at, 22.0, 20.0)
    train = air_train(20, locomotives=locomotives, initial_speed=speeds)
    train.uncouple(at)
    train.part_hose(at)
    area = float(train.train.air[0].pipe_area)
    ways = stopping_ways(train)
    assert train.extremes().compression[at] == 0.0, "they have not met"
    consist, brake = train.consist, train.pneumatic
    assert brake is not None
    for part_of, first, last, end in ((slice(0, at + 1), 0, at, at), (slice(at + 1, None), at + 1, None, 0)):
        members = consist.vehicles[part_of]
        powered = tuple(
            replace(loco, vehicle=loco.vehicle - first)
            for loco in consist.locomotives
            if first <= loco.vehicle < first + len(members)
        )
        couplers = consist.couplers[first:last]
        part = TrainModel(Consist(members, couplers, powered), brake, initial_speed=speeds[first], time_step=2e-3)
        part.set_hole(end, area)
        # the air's momentum is that of a cell with two faces at a parted hose, and none at the end of a train
        assert ways[part_of] == pytest.approx(stopping_ways(part), rel=1e-4)


def test_there_must_be_such_a_coupler() -> None:
    train = model(train_of([vehicle()] * 3, [linear_gear(), None]))
    for coupler, problem in ((1, "rigid drawbar"), (2, "expected 0 to 1"), (-1, "expected 0 to 1")):
        with pytest.raises(ValueError, match=problem):
            train.uncouple(coupler)
