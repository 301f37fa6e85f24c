"""Faults in a scenario: what is read, and what is refused in one line."""

from __future__ import annotations

import math

import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.draft_gear import DraftGear
from haul_ros.model.fault import Fault, FaultKind, FaultPlan, PlannedFault
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario_text

TRAIN = """\
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 4, drawbar_group: 2}
coupler: paper_set_b
brakes: BRAKES
initial_speed_kmh: 36
faults:
"""


def load(faults: str, brakes: str = "pneumatic") -> Scenario:
    return load_scenario_text(TRAIN.replace("BRAKES", brakes) + f"  {faults}\n", "x.yaml")


def test_a_plan_is_read_in_si_units_and_survives_in_the_document() -> None:
    events = "[{at_s: 1.5, leak: 5, bore_mm: 4}, {at_m: 250, part_hose: 3}, {at_s: 2, cut_in_valve: 1}]"
    found = load(f"{{leakage_kPa_per_min: 30, hose_parts_at_mm: 450, events: {events}}}")
    planned = (
        PlannedFault(Fault(FaultKind.LEAK, 5, 4e-3), time_ns=1_500_000_000),
        PlannedFault(Fault(FaultKind.PART_HOSE, 3), chainage=250.0),
        PlannedFault(Fault(FaultKind.CUT_IN_VALVE, 1), time_ns=2_000_000_000),
    )
    assert found.faults == FaultPlan(leakage=500.0, hose_reach=0.45, planned=planned)
    assert load_scenario_text(found.document, "x.yaml").faults == found.faults


def test_without_faults_there_are_none() -> None:
    assert load_scenario_text(TRAIN.replace("BRAKES", "pneumatic").replace("faults:\n", ""), "x").faults == FaultPlan()


def test_a_coupler_has_a_strength_only_where_one_is_given() -> None:
    def gear(**values: object) -> DraftGear:
        text = TRAIN.replace("BRAKES", "paper_set_b").replace("faults:\n", "")
        first = load_scenario_text(text, "x", {f"couplers.paper_set_b.{k}": v for k, v in values.items()})
        assert first.consist.couplers[0] is not None
        return first.consist.couplers[0]

    assert gear().strength == math.inf
    assert gear(strength_kN=1500).strength == 1.5e6
    with pytest.raises(ScenarioError, match=r"strength_kN = 0, must be above 0"):
        gear(strength_kN=0)


@pytest.mark.parametrize(
    ("faults", "brakes", "problem"),
    [
        ("{events: [{at_s: 1, part_hose: 5}]}", "pneumatic", "faults.events.0.part_hose = 5, must be at most 4, the"),
        ("{events: [{at_s: 1, part_hose: 0}]}", "pneumatic", "faults.events.0.part_hose = 0, must be at least 1"),
        ("{events: [{at_s: 1, leak: 6, bore_mm: 1}]}", "pneumatic", "leak = 6, must be at most 5, the number of veh"),
        ("{events: [{at_s: 1, leak: 2}]}", "pneumatic", "faults.events.0: leak needs bore_mm beside it"),
        ("{events: [{at_s: 1, leak: 2, bore_mm: 51}]}", "pneumatic", "bore_mm = 51, must be at most 50"),
        ("{events: [{at_s: 1, uncouple: 2}]}", "pneumatic", "uncouple = 2, is a rigid drawbar"),
        ("{events: [{at_s: 1}]}", "pneumatic", "faults.events.0: needs one of part_hose, close_angle_cock"),
        ("{events: [{part_hose: 1}]}", "pneumatic", "faults.events.0: needs either at_s or at_m"),
        ("{events: [{at_s: 1, at_m: 1, part_hose: 1}]}", "pneumatic", "faults.events.0: needs either at_s or at_m"),
        ("{events: [{at_s: 1, part_hoze: 1}]}", "pneumatic", "part_hoze: unknown key, did you mean part_hose?"),
        ("{events: [{at_s: 1, part_hose: 1}]}", "paper_set_b", "needs a pneumatic brake, and brakes = paper_set_b is"),
        ("{leakage_kPa_per_min: 1}", "paper_set_b", "leakage_kPa_per_min = 1, needs a pneumatic brake"),
        ("{leakage_kPa_per_min: -1}", "pneumatic", "leakage_kPa_per_min = -1, must be at least 0"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(faults: str, brakes: str, problem: str) -> None:
    with pytest.raises(ScenarioError) as refusal:
        load(faults, brakes)
    assert str(refusal.value).startswith("x.yaml:8: faults.")
    assert problem in str(refusal.value)
