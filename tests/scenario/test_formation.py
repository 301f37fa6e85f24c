"""The consist: order, drawbars, couplers and locomotives."""

from __future__ import annotations

import pytest

from haul_ros.errors import ScenarioError
from haul_ros.model.consist import Consist
from haul_ros.scenario.loader import load_scenario_text

REST = "coupler: paper_set_b\nbrakes: paper_set_b\ninitial_speed_kmh: 80\n"


def _consist(*entries: str) -> Consist:
    lines = "".join(f"  - {{{entry}}}\n" for entry in entries)
    return load_scenario_text(f"consist:\n{lines}{REST}", "x").consist


def test_slaves_are_numbered_from_the_head_wherever_the_master_is() -> None:
    consist = _consist(
        "vehicle: SS4, role: slave, count: 2", "vehicle: C80", "vehicle: SS4, role: master", "vehicle: SS4, role: slave"
    )
    assert [(loco.name, loco.vehicle) for loco in consist.locomotives] == [
        ("slave_1", 0),
        ("slave_2", 1),
        ("master", 3),
        ("slave_3", 4),
    ]


def test_drawbars_lie_inside_the_groups_only() -> None:
    consist = _consist("vehicle: SS4, role: master", "vehicle: C80, count: 6, drawbar_group: 3", "vehicle: SS4")
    assert [gear is None for gear in consist.couplers] == [False, True, True, False, True, True, False]


def test_an_entry_may_have_its_own_coupler_behind_each_vehicle() -> None:
    consist = _consist(
        "vehicle: SS4, role: master", "vehicle: C80, count: 4, coupler: MT-2, drawbar_group: 2", "vehicle: SS4"
    )
    assert [gear and gear.name for gear in consist.couplers] == ["paper_set_b", None, "MT-2", None, "MT-2"]


@pytest.mark.parametrize(
    ("entries", "expected"),
    [
        (["vehicle: SS4, role: master"], "x:1: consist: a train of 1, must have 2 to 2000 vehicles"),
        (["vehicle: SS4, role: master", "vehicle: C80, count: 2000"], "a train of 2001, must have 2 to 2000 vehicles"),
        (["vehicle: SS4", "vehicle: C80"], "x:1: consist: 0 vehicles have role: master, must be exactly 1"),
        (["vehicle: SS4, role: master, count: 2"], "consist: 2 vehicles have role: master, must be exactly 1"),
        (
            ["vehicle: SS4, role: master", "vehicle: C80, count: 4, drawbar_group: 3"],
            "x:3: consist.1.drawbar_group = 3, must divide count, 4",
        ),
    ],
)
def test_trains_that_cannot_be_are_refused(entries: list[str], expected: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        _consist(*entries)
    assert expected in str(caught.value)
