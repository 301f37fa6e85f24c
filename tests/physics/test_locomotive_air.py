"""The locomotives' own brake cylinders: filled from the main reservoir, held off by the electric brake."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.air_brake import ATMOSPHERE
from haul_ros.model.command import Command, CommandKind
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.session import Session

TRAIN = """\
consist:
  - {vehicle: HXD1, role: master}
  - {vehicle: C80, count: 6}
  - {vehicle: HXD1, role: slave}
coupler: paper_set_b
brakes: pneumatic
initial_speed_kmh: 60
max_duration_s: 2000
radio: {default: {connected: false}}
"""
MAIN_VOLUME = 1.2
GAS = 287.0 * 293.0
LOCOMOTIVES, WAGONS = [0, 7], slice(1, 7)


def session(**overrides: Any) -> Session:
    return Session(load_scenario_text(TRAIN, "train", {k.replace("__", "."): v for k, v in overrides.items()}))


def ask(run: Session, kind: CommandKind, value: float, seconds: float) -> None:
    run.request(Command("master", kind, value))
    run.advance(round(seconds / run.scenario.time_step))


def cylinder(run: Session) -> float:
    """Of the master, gauge [Pa]."""
    return float(run._model.train.air_state.cylinder[0] - ATMOSPHERE)


def test_what_is_in_the_cylinder_has_left_the_main_reservoir_and_no_other_place() -> None:
    """The compressor starts at 750 kPa only, and in an application the feed is closed: m = V (p0 - p)/(R T).

    While the cylinder still fills: once it is full its valve lets out what is too much.
    """
    run = session()
    state, valves = run._model.train.air_state, run._model.train.driver_valves
    full, empty = valves.main_reservoir[0], state.cylinder_air[0]
    ask(run, CommandKind.BRAKE, 1.0, 3.0)
    assert 50e3 < cylinder(run) < 300e3
    taken = (full - valves.main_reservoir[0]) * MAIN_VOLUME / GAS
    assert taken == pytest.approx(state.cylinder_air[0] - empty, rel=1e-9)
    assert state.auxiliary[0] == valves.main_reservoir[0]
    run.advance(37_000)
    assert cylinder(run) == pytest.approx(2.6 * 140e3, rel=0.02)
    assert run._model.air_error < 1e-12


def test_a_larger_cylinder_on_the_locomotive_changes_no_bit_of_pipe_and_wagons() -> None:
    runs = [session(control_valves__locomotive_distributor__cylinder_displaced_L=litres) for litres in (15, 150)]
    for run in runs:
        ask(run, CommandKind.BRAKE, 0.5, 20.0)
        run.request(Command("master", CommandKind.EMERGENCY, 1.0))
        run.advance(10_000)
    states = [run._model.train.air_state for run in runs]
    assert states[0].cylinder_air[0] < states[1].cylinder_air[0]
    for name in ("pipe", "flow", "cylinder", "auxiliary"):
        first, second = (getattr(state, name)[WAGONS] for state in states)
        assert first.tobytes() == second.tobytes(), name


def test_emergency_fills_the_cylinder_of_a_locomotive_that_has_lost_its_pipe() -> None:
    """450 kPa in 18 L: from the pipe's auxiliary reservoir no more than its own pressure could come."""
    run = session()
    run._model.part_hose(0)
    run.advance(20_000)
    assert run._model.train.air_state.pipe[0] < ATMOSPHERE + 10e3
    assert cylinder(run) == pytest.approx(450e3, rel=0.02)
    assert run._model.train.driver_valves.main_reservoir[0] > ATMOSPHERE + 880e3
    assert run._model.air_error < 1e-12


def test_an_empty_main_reservoir_gives_no_more_than_it_has_and_takes_nothing_back() -> None:
    run = session(**{"brake_systems.pneumatic.driver_valve.compressor_flow_m3_per_min": 0.01})
    train = run._model.train
    train.driver_valves.main_reservoir[0] = train.air_state.auxiliary[0] = ATMOSPHERE + 200e3
    ask(run, CommandKind.EMERGENCY, 1.0, 60.0)
    # p (V + 18 L) = p0 V + the atmosphere that the 3 L held, and a little of the compressor, 17 Pa/s
    equal = ((ATMOSPHERE + 200e3) * MAIN_VOLUME + ATMOSPHERE * 3e-3) / (MAIN_VOLUME + 18e-3)
    assert train.air_state.cylinder[0] == pytest.approx(equal, abs=2e3)
    before = train.air_state.cylinder[0]
    train.driver_valves.main_reservoir[0] = train.air_state.auxiliary[0] = ATMOSPHERE + 50e3
    run.advance(5_000)
    assert train.air_state.cylinder[0] == before


def test_air_adds_up_to_1e_12_through_applications_releases_and_emergencies_with_the_compressor() -> None:
    run = session(
        **{
            "brake_systems.pneumatic.driver_valve.main_reservoir_volume_L": 200,
            "radio.default.connected": True,
        }
    )
    account = run._model.train.air_account[0]
    for _ in range(4):
        ask(run, CommandKind.BRAKE, 1.0, 30.0)
        ask(run, CommandKind.BRAKE, 0.0, 60.0)
    ask(run, CommandKind.EMERGENCY, 1.0, 30.0)
    assert account.compressed > 0.5
    assert account.vented > 0.5
    assert run._model.air_error < 1e-12


def test_the_electric_brake_empties_the_locomotive_s_cylinder_and_gives_it_back() -> None:
    run = session()
    ask(run, CommandKind.BRAKE, 0.1, 10.0)
    full = cylinder(run)
    assert full == pytest.approx(2.6 * 59e3, rel=0.03)
    assert run.sample().brake_force[0] > 35e3
    ask(run, CommandKind.ELECTRIC_BRAKE, 100e3, 15.0)
    assert cylinder(run) < 1e3
    assert run.sample().brake_force[0] < 1e3
    assert (run.sample().brake_force[WAGONS] > 10e3).all()
    ask(run, CommandKind.ELECTRIC_BRAKE, 0.0, 10.0)
    assert run._model.efforts[0] == 0.0
    assert not run.at_standstill
    assert cylinder(run) == pytest.approx(full, rel=0.03)
    assert run._model.air_error < 1e-12
    assert abs(run.energy().relative_imbalance) < 1e-9


@pytest.mark.parametrize("in_emergency", ["drop", "keep"])
def test_in_an_emergency_the_air_brake_comes_whatever_the_electric_brake_does(in_emergency: str) -> None:
    run = session(**{"vehicles.HXD1.electric_brake.in_emergency": in_emergency})
    ask(run, CommandKind.ELECTRIC_BRAKE, 300e3, 20.0)
    ask(run, CommandKind.BRAKE, 0.3, 5.0)
    assert cylinder(run) < 1e3
    ask(run, CommandKind.EMERGENCY, 1.0, 8.0)
    assert cylinder(run) > 400e3
    assert bool(run._model.efforts[0] < 0.0) is (in_emergency == "keep")


def test_a_locomotive_without_a_brake_valve_fills_its_cylinder_as_a_wagon_does() -> None:
    dead = TRAIN.replace("{vehicle: C80, count: 6}", "{vehicle: HXD1}\n  - {vehicle: C80, count: 5}")
    run = Session(load_scenario_text(dead, "train"))
    state = run._model.train.air_state
    assert state.auxiliary[[0, 1]] == pytest.approx([ATMOSPHERE + 900e3, ATMOSPHERE + 500e3])
    ask(run, CommandKind.BRAKE, 1.0, 40.0)
    assert state.cylinder[1] > ATMOSPHERE + 330e3
    assert state.auxiliary[1] < ATMOSPHERE + 470e3
    assert run._model.air_error < 1e-12


def test_locomotives_at_both_ends_do_alike() -> None:
    run = session(**{"radio.default.connected": True})
    ask(run, CommandKind.BRAKE, 0.7, 30.0)
    state = run._model.train.air_state
    for pressures in (state.cylinder[LOCOMOTIVES], state.auxiliary[LOCOMOTIVES]):
        assert np.ptp(pressures) < 1e-12 * pressures[0]  # sums along the train are rounded from one end


def test_a_direct_release_valve_on_the_main_reservoir_is_refused() -> None:
    with pytest.raises(ScenarioError, match="from_main_reservoir = true, must be false: a direct release valve"):
        session(control_valves__valve_120__from_main_reservoir=True)
