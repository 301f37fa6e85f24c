"""A session starts in the state that its scenario says, and logs it."""

from __future__ import annotations

import numpy as np
import pytest

from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.log import AppliedBrake
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session
from tests.simulation.log_entries import of_kind


def test_a_session_starts_with_its_couplers_where_the_scenario_has_them() -> None:
    overrides = {"coupler": "MT-2", "couplers.MT-2.slack_mm": 20, "consist.1.count": 3, "consist.3.count": 2}
    lengths = [33.0, *[12.0] * 3, 33.0, 33.0, *[12.0] * 2, 33.0]
    tails = []
    for state, stroke in (("free", 0.0), ("stretched", -0.01), ("bunched", 0.01)):
        scenario = load_scenario("daqin_1_2_1", {**overrides, "initial_state.couplers": state})
        session = Session(scenario)
        log = session.take_log()
        assert log.sample is not None
        assert log.sample.stroke.tolist() == [stroke] * (len(lengths) - 1)
        assert session.travelled == 0.0
        tails.append(float(log.sample.chainage[-1]))
    assert np.diff(tails).tolist() == pytest.approx([-0.01 * 8, 0.02 * 8], abs=1e-9)


@pytest.mark.parametrize(("cylinder", "applied"), [(150, True), (0, False)])
def test_the_brake_valves_start_at_the_demand_that_holds_the_pipe(cylinder: float, applied: bool) -> None:
    overrides = {"initial_state.brake_pipe_kPa": 420, "initial_state.cylinder_kPa": cylinder}
    session = Session(load_scenario("daqin_1_2_1_pneumatic", overrides))
    log = session.take_log()
    demands = {entry.locomotive: entry.value for entry in of_kind(AppliedBrake, log)}
    assert list(demands) == ["master", "slave_1", "slave_2", "slave_3"]
    brake = session.scenario.brakes
    assert isinstance(brake, PneumaticBrake)
    expected = (brake.pressure - brake.least_reduction - 420e3) / (brake.full_reduction - brake.least_reduction)
    assert list(demands.values()) == pytest.approx([expected if applied else 0.0] * 4)
    assert 0.0 < expected < 1.0
    assert log.sample is not None
    assert (log.sample.brake_force > 0.0).all() == applied
