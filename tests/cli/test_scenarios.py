from __future__ import annotations

import json
from typing import TYPE_CHECKING

from haul_ros.resources import shipped_scenarios
from haul_ros.scenario import load_scenario

if TYPE_CHECKING:
    from tests.cli.conftest import Haul


def test_every_shipped_scenario_has_a_line(haul: Haul) -> None:
    outcome = haul("scenarios")
    assert outcome.status == 0
    assert [line.split()[0] for line in outcome.out.splitlines()] == list(shipped_scenarios())


def test_json_maps_names_to_descriptions(haul: Haul) -> None:
    found = json.loads(haul("scenarios", "--json").out)
    assert found["daqin_1_2_1"] == load_scenario("daqin_1_2_1").description
    assert set(found) == set(shipped_scenarios())
