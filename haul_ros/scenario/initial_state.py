"""The state of the train at t = 0 from a checked document."""

from __future__ import annotations

from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.initial_state import CouplerState, InitialAir, InitialState
from haul_ros.scenario.document import Document

_PIPE, _AUXILIARY, _CYLINDER = PRESSURES = ("brake_pipe_kPa", "auxiliary_reservoir_kPa", "cylinder_kPa")


def initial_state(document: Document, brakes: BrakeSystem | PneumaticBrake) -> InitialState:
    """Couplers and pressures at the start.

    Raises
    ------
    ScenarioError
        Pressures of a brake that has none, above that of the charged pipe, or of a cylinder above that of the
        reservoir that fills it.
    """
    entry = document.data["initial_state"]
    couplers = CouplerState(entry["couplers"])
    given = [key for key in PRESSURES if key in entry]
    if not given:
        return InitialState(couplers)
    if not isinstance(brakes, PneumaticBrake):
        system = document.data["brakes"]
        raise document.refusal(("initial_state", given[0]), f"is for pneumatic brakes alone, and {system} is none")
    charged = brakes.pressure / 1e3
    pipe = entry.get(_PIPE, charged)
    auxiliary = entry.get(_AUXILIARY, pipe)
    cylinder = entry.get(_CYLINDER, 0.0)
    for key in (_PIPE, _AUXILIARY):
        if entry.get(key, 0.0) > charged:
            raise document.refusal(("initial_state", key), f"must be at most {charged:g}, that of the charged pipe")
    if cylinder > auxiliary:
        expected = f"must be at most {auxiliary:g}, that of the auxiliary reservoir which fills it"
        raise document.refusal(("initial_state", _CYLINDER), expected)
    return InitialState(couplers, InitialAir(pipe * 1e3, auxiliary * 1e3, cylinder * 1e3))
