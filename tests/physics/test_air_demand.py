"""What a reduction asks of the cylinders, against published rules and against a valve that is simulated."""

from __future__ import annotations

import numpy as np
import pytest

from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.physics.air_demand import cylinder_pressures_for
from haul_ros.scenario import load_scenario
from tests.physics.air_cases import air_train, cylinder, pipe, wagons_of

SCENARIO = load_scenario("daqin_1_2_1_pneumatic")


def asked(reduction: float, scenario: str = "daqin_1_2_1_pneumatic", **overrides: object) -> float:
    """Of the second vehicle, a wagon [Pa]."""
    run = load_scenario(scenario, {key.replace("__", "."): value for key, value in overrides.items()})
    assert isinstance(run.brakes, PneumaticBrake)
    return float(cylinder_pressures_for(run.brakes, run.consist, run.brakes.pressure - reduction)[1])


@pytest.mark.parametrize("reduction", [50e3, 80e3, 110e3])
def test_a_120_valve_gives_what_the_rule_says(reduction: float) -> None:
    """p = 3.25 r - 100 kPa; here the clearance of the cylinder has air in it before, worth 16 kPa."""
    clearance = 101.325e3 * 3.0 / 18.46
    assert asked(reduction) == pytest.approx(3.25 * reduction - 101.325e3 + clearance, rel=1e-3)


@pytest.mark.parametrize(("brakes", "pressure"), [("pneumatic", 359e3), ("pneumatic_600", 435e3)])
def test_full_service_equalises_where_the_rule_says(brakes: str, pressure: float) -> None:
    found = [asked(reduction, brakes=brakes) for reduction in (200e3, 300e3, 400e3)]
    assert found == pytest.approx([pressure] * 3, rel=0.01)
    assert max(found) - min(found) < 1.0  # however deep: there is no more air


def test_a_uic_distributor_gives_3_8_bar_at_1_5_bar() -> None:
    assert asked(150e3, "uic_freight") == pytest.approx(380e3, rel=1e-3)
    assert asked(75e3, "uic_freight") == pytest.approx(190e3, rel=1e-3)
    assert asked(200e3, "uic_freight") == pytest.approx(380e3, rel=1e-3)
    assert asked(0.0, "uic_freight") == 0.0


def test_a_load_device_caps_it() -> None:
    assert asked(100e3, vehicles__C80__cylinder_limit_kPa=150) == pytest.approx(150e3)


@pytest.mark.parametrize("reduction", [60e3, 100e3, 200e3])
def test_a_simulated_valve_without_quick_service_settles_there(reduction: float) -> None:
    train = air_train(3, wagon_valve={"quick_service_difference": 1e9, "quick_service_bore": 0.0})
    brakes = train.pneumatic
    assert brakes is not None
    demand = (reduction - brakes.least_reduction) / (brakes.full_reduction - brakes.least_reduction)
    train.set_brake_valve(0, min(demand, 1.0))
    train.advance(60_000)
    for i in np.flatnonzero(wagons_of(train)):
        expected = cylinder_pressures_for(brakes, train.consist, float(pipe(train)[i]))[i]
        # The service port closes 0.5 kPa early, and the groove has let some air back before: a kPa of the reservoir
        assert cylinder(train)[i] == pytest.approx(expected, abs=3.3e3)
