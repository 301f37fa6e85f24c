"""Whatever is asked of a train under way, nothing of its model is compiled then: a live node would stand still."""

from __future__ import annotations

import pytest
from numba.core import event

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.fault import Fault, FaultKind
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import Request
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.session import Session

TRAIN = """\
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 4}
  - {vehicle: SS4, role: slave}
coupler: paper_set_b
brakes: paper_set_b
initial_speed_kmh: 5
radio: {default: {delay_s: 0, outages: [{from_s: 0.5, to_s: 1}]}}
"""
AIR = (
    Fault(FaultKind.LEAK, 2, 3e-3),
    Fault(FaultKind.CUT_OUT_VALVE, 3),
    Fault(FaultKind.CUT_IN_VALVE, 3),
    Fault(FaultKind.CLOSE_ANGLE_COCK, 1),
    Fault(FaultKind.OPEN_ANGLE_COCK, 1),
    Fault(FaultKind.PART_HOSE, 4),
)
REQUESTS = (
    Command("master", CommandKind.TRACTION, 100e3),
    Command("master", CommandKind.ELECTRIC_BRAKE, 100e3),
    Command("master", CommandKind.BRAKE, 0.4),
    RadioLinkChange("slave_1", connected=False),
    RadioLinkChange("slave_1", connected=True),
    Command("master", CommandKind.BRAKE, 0.0),
    Command("slave_1", CommandKind.EMERGENCY, 1.0),
)


@pytest.mark.parametrize(("brakes", "more"), [("paper_set_b", ()), ("pneumatic", AIR)])
def test_nothing_is_compiled_once_a_train_has_been_made(brakes: str, more: tuple[Request, ...]) -> None:
    session = Session(load_scenario_text(TRAIN, "train", {"brakes": brakes}))
    with event.install_recorder("numba:compile") as compiled:
        for request in (*REQUESTS, *more, Fault(FaultKind.UNCOUPLE, 2)):
            session.request(request)
            session.advance(300)
            session.take_log()
    assert compiled.buffer == []
