"""Pneumatic brakes in scenario files: units, choice of valves, refusals."""

from __future__ import annotations

from typing import Any

import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.air_brake import PneumaticBrake, Release
from haul_ros.scenario import load_scenario

NAME = "daqin_1_2_1_pneumatic"


def brake(**overrides: Any) -> PneumaticBrake:
    brakes = load_scenario(NAME, {key.replace("__", "."): value for key, value in overrides.items()}).brakes
    assert isinstance(brakes, PneumaticBrake)
    return brakes


def test_values_come_in_si_units() -> None:
    found = brake()
    assert (found.pressure, found.least_reduction, found.full_reduction) == (500e3, 50e3, 140e3)
    assert (found.pipe.bore, found.pipe.branch_volume, found.pipe.temperature) == (0.035, 1.5e-3, 293.0)
    assert found.step == 2e-3
    valve = found.valves["C80"]
    assert (valve.auxiliary_volume, valve.vent_bore) == pytest.approx((60e-3, 19e-3))
    assert (valve.apply_difference, valve.emergency_lag) == (6e3, 0.8)
    assert found.driver_valve.compressor_flow == pytest.approx(5.0 / 60.0)
    assert (found.driver_valve.equalising_down, found.driver_valve.main_reservoir_volume) == pytest.approx((25e3, 1.2))
    assert found.driver_valve.maintaining is False


def test_locomotives_and_wagons_have_valves_of_their_own_and_a_vehicle_may_name_another() -> None:
    found = brake()
    assert found.valves["SS4"].release is Release.GRADUATED
    assert found.valves["C80"].release is Release.DIRECT
    assert found.valves["C80"].emergency_difference < found.valves["SS4"].emergency_difference
    assert brake(vehicles__C80__control_valve="uic_p").valves["C80"].cylinder_most == 380e3


def test_a_load_device_limits_the_cylinder() -> None:
    assert brake(vehicles__C80__cylinder_limit_kPa=165).cylinder_limits == {"SS4": float("inf"), "C80": 165e3}


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (
            {"time_step_ms": 5, "sample_rate_hz": 1},
            r"air_step_ms = 2, must be a whole multiple or fraction of time_step_ms, 5",
        ),
        (
            {"brake_systems.pneumatic.air_step_ms": 50},
            "must be at most 11 ms, a quarter of what sound",
        ),
        ({"brake_systems.pneumatic.full_reduction_kPa": 40}, "full_reduction_kPa = 40, must lie between"),
        ({"brake_systems.pneumatic.wagon_valve": "v_120"}, "wagon_valve = 'v_120', unknown name, control_valves: aar"),
        ({"brake_systems.pneumatic.pipe.bore_mm": 0}, "pipe.bore_mm = 0, must be at least 5"),
        ({"brake_systems.pneumatic.pipe_pressure_bar": 5}, r"pipe_pressure_bar: unknown key"),
        ({"control_valves.valve_120.release": "slow"}, "release = 'slow', must be direct or graduated"),
        ({"control_valves.valve_120.release": "graduated"}, "cylinder_ratio is missing"),
        ({"brake_systems.pneumatic.pipe.friction_factor": 0}, "friction_factor = 0, must be at least 0.005"),
        ({"brake_systems.pneumatic.driver_valve.compressor_on_kPa": 400}, "must be above pipe_pressure_kPa"),
        ({"control_valves.valve_120.lap_difference_kPa": 5}, "must be below reapply_difference_kPa"),
        ({"control_valves.locomotive_distributor.release_difference_kPa": 8}, "must be below apply_difference_kPa"),
        ({"vehicles.C80.control_valve": "none"}, "control_valve = 'none', unknown name"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(overrides: dict[str, object], expected: str) -> None:
    with pytest.raises(ScenarioError, match=expected) as refused:
        load_scenario(NAME, overrides)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("time_step", "ok"), [(0.5, True), (1, True), (2, True), (4, True), (10, True)])
def test_time_steps_that_fit_the_air_step_are_taken(time_step: float, ok: bool) -> None:
    assert load_scenario(NAME, {"time_step_ms": time_step, "sample_rate_hz": 1}).time_step == time_step / 1e3


def test_an_entry_of_both_kinds_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"needs either wave_speeds or pipe_pressure_kPa"):
        load_scenario("daqin_1_2_1", {"brake_systems.paper_set_b.pipe_pressure_kPa": 500})


def test_what_is_fitted_and_assumed_is_said() -> None:
    caveats = load_scenario(NAME).caveats
    assert any(line.startswith("control_valves.valve_120:") and "fitted" in line for line in caveats)
    assert any(line.startswith("brake_systems.pneumatic:") and "assumed" in line for line in caveats)
