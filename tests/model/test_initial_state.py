"""Strokes of couplers that stand at the ends of their slack."""

from __future__ import annotations

from dataclasses import replace

import pytest

from haul_ros.model.consist import Consist, Locomotive
from haul_ros.model.initial_state import CouplerState, InitialState
from haul_ros.scenario import load_scenario


@pytest.mark.parametrize(
    ("state", "side"), [(CouplerState.FREE, 0.0), (CouplerState.STRETCHED, -1.0), (CouplerState.BUNCHED, 1.0)]
)
def test_every_gear_stands_at_half_its_own_slack_and_drawbars_have_none(state: CouplerState, side: float) -> None:
    shipped = load_scenario("daqin_1_1_0").consist
    gear = shipped.couplers[0]
    assert gear is not None
    couplers = (replace(gear, slack=0.02), None, gear, replace(gear, slack=0.008))
    consist = Consist(shipped.vehicles[:5], couplers, (Locomotive("master", 0),))
    assert InitialState(state).strokes(consist) == (side * 0.01, 0.0, 0.0, side * 0.004)
