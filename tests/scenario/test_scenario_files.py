"""The shipped catalogue, scenarios and schemas, as they are."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import jsonschema
import pytest

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.request import TimedRequest
from haul_ros.resources import config_dir, shipped_scenarios
from haul_ros.scenario.catalogue import SECTION_FILES, catalogue_section
from haul_ros.scenario.loader import load_scenario, load_scenario_text
from haul_ros.units import mps_to_kmh

# (vehicles, couplers that are drawbars, locomotives), counted from the formation in words
FORMATIONS = {
    "aar_unit_train": (102, 0, 2),
    "burst_hose": (206, 0, 2),
    "cyclic_descent": (206, 0, 2),
    "daqin_1_1_0": (206, 0, 2),
    "daqin_1_1_0_realistic": (206, 0, 2),
    "daqin_1_2_1": (208, 0, 4),
    "daqin_1_2_1_pneumatic": (208, 0, 4),
    "daqin_1_2_1_realistic": (208, 0, 4),
    "daqin_1_2_1_rigid_pairs": (208, 102, 4),
    "daqin_1_2_1_set_a": (208, 0, 4),
    "daqin_descent": (206, 0, 2),
    "daqin_4x5000": (208, 0, 4),
    "daqin_4x5000_realistic": (208, 0, 4),
    "radio_outage": (206, 0, 2),
    "second_application": (103, 0, 1),
    "uic_freight": (28, 0, 1),
    "validation_ss3_c63": (123, 0, 1),
}

# initial speed [km/h] and command of those that do not begin with an emergency from 80 km/h
STARTS = {
    "aar_unit_train": (72.0, TimedRequest(10**9, Command("master", CommandKind.EMERGENCY, 1.0))),
    "burst_hose": (80.0, None),
    "cyclic_descent": (60.0, None),
    "daqin_descent": (60.0, None),
    "radio_outage": (72.0, TimedRequest(10**10, Command("master", CommandKind.BRAKE, 0.001))),
    "second_application": (72.0, TimedRequest(0, Command("master", CommandKind.BRAKE, 0.001))),
    "uic_freight": (80.0, TimedRequest(10**9, Command("master", CommandKind.BRAKE, 1.0))),
    "validation_ss3_c63": (63.7, TimedRequest(0, Command("master", CommandKind.EMERGENCY, 1.0))),
}


def _entry(section: str, name: str) -> dict[str, Any]:
    entry: dict[str, Any] = catalogue_section(section).data[section][name]
    return entry


def _standings(section: str, name: str) -> set[str]:
    """The keys of an entry, dotted, that have a standing of their own."""
    standing = _entry(section, name)["standing"]
    return set() if isinstance(standing, str) else set(standing) - {"default"}


def _has(entry: dict[str, Any], dotted: str) -> bool:
    first, _, rest = dotted.partition(".")
    return first in entry and (not rest or _has(entry[first], rest))


def _energy(points: list[list[float]]) -> float:
    """Area under a curve of [mm, kN] points, in J."""
    return sum((x1 - x0) * (f0 + f1) / 2 for (x0, f0), (x1, f1) in pairwise(points))


def test_the_shipped_scenarios_are_those_of_the_contract() -> None:
    assert list(shipped_scenarios()) == sorted(FORMATIONS)


@pytest.mark.parametrize("name", FORMATIONS)
def test_a_shipped_scenario_has_its_formation(name: str) -> None:
    scenario = load_scenario(name)
    vehicles, drawbars, locomotives = FORMATIONS[name]
    assert scenario.name == name
    assert len(scenario.consist.vehicles) == vehicles
    assert sum(gear is None for gear in scenario.consist.couplers) == drawbars
    assert len(scenario.consist.locomotives) == locomotives
    speed, command = STARTS.get(name, (80.0, TimedRequest(0, Command("master", CommandKind.EMERGENCY, 1.0))))
    assert mps_to_kmh(scenario.initial_speed) == pytest.approx(speed)
    assert scenario.commands[:1] == (() if command is None else (command,))


@pytest.mark.parametrize("name", FORMATIONS)
def test_the_document_of_a_shipped_scenario_gives_an_equal_scenario(name: str) -> None:
    scenario = load_scenario(name)
    assert load_scenario_text(scenario.document, name) == scenario


def test_the_train_1_2_1_weighs_and_measures_what_its_vehicles_do() -> None:
    consist = load_scenario("daqin_1_2_1").consist
    assert consist.mass == pytest.approx(204 * 100e3 + 4 * 184e3)
    assert consist.length == pytest.approx(204 * 12.0 + 4 * 32.83)
    assert [(loco.name, loco.vehicle) for loco in consist.locomotives] == [
        ("master", 0),
        ("slave_1", 103),
        ("slave_2", 104),
        ("slave_3", 207),
    ]


def test_rigid_pairs_are_wagons_joined_two_and_two() -> None:
    couplers = load_scenario("daqin_1_2_1_rigid_pairs").consist.couplers
    assert [gear is None for gear in couplers[:5]] == [False, True, False, True, False]
    assert [gear is None for gear in couplers[100:108]] == [False, True, False, False, False, True, False, True]


def test_every_fitted_or_assumed_entry_that_a_scenario_uses_is_a_caveat() -> None:
    caveats = load_scenario("validation_ss3_c63").caveats
    assert [line.partition(":")[0] for line in caveats] == [
        "brake_systems.validation",
        "couplers.paper_set_b",
        "vehicles.C63",
        "vehicles.SS3",
    ]
    assert "couplers.paper_set_b: all values fitted" in caveats
    assert "vehicles.C63: brake_shoe, shoe_force_kN fitted; other values assumed" in caveats


def test_every_catalogue_entry_names_its_source_and_the_standing_of_its_own_keys() -> None:
    entries = [(section, name) for section in SECTION_FILES for name in catalogue_section(section).data[section]]
    assert len(entries) > 20
    assert [entry for entry in entries if not _entry(*entry)["source"]] == []
    assert [entry for entry in entries if not all(_has(_entry(*entry), key) for key in _standings(*entry))] == []


@pytest.mark.parametrize(
    ("gear", "capacity_kj", "force_kn", "stroke_mm"),
    [("MT-2", 50, 2270, 83), ("MT-3", 45, 2000, 83), ("ST", 30, 2000, 73)],
)
def test_a_catalogued_draft_gear_holds_its_rating(
    gear: str, capacity_kj: float, force_kn: float, stroke_mm: float
) -> None:
    entry = _entry("couplers", gear)
    energy = _energy(entry["loading"]) / 1e3
    assert capacity_kj <= energy < 1.1 * capacity_kj
    assert entry["loading"][-1] == [stroke_mm, force_kn]
    assert entry["maximum_stroke_mm"] == stroke_mm
    assert 1 - _energy(entry["unloading"]) / 1e3 / energy >= 0.8 - 1e-12


@pytest.mark.parametrize(
    ("shoe", "force_kn", "share_of_speed", "converted"),
    [
        ("high_friction_composite", 20, lambda v: (v + 150) / (2 * v + 150), 0.322),
        ("low_friction_composite", 25, lambda v: (4 * v + 150) / (10 * v + 150), 0.202),
        ("medium_phosphorus_iron", 25, lambda v: (3.6 * v + 100) / (14 * v + 100), 0.356),
        ("high_phosphorus_iron", 25, lambda v: (17 * v + 100) / (60 * v + 100), 0.372),
    ],
)
def test_each_brake_shoe_reduces_to_the_published_converted_coefficient(
    shoe: str, force_kn: float, share_of_speed: Callable[[float], float], converted: float
) -> None:
    entry = _entry("brake_shoes", shoe)
    by_force = entry["scale"] * (force_kn + entry["k_offset_kN"]) / (entry["k_gain"] * force_kn + entry["k_offset_kN"])
    assert by_force == pytest.approx(converted, abs=1e-3)
    for v in (0.0, 40.0, 80.0):
        by_speed = (entry["n_slope"] * v + entry["n_offset_kmh"]) / (entry["d_slope"] * v + entry["d_offset_kmh"])
        assert by_speed == pytest.approx(share_of_speed(v))


@pytest.mark.parametrize("name", ["catalogue.schema.json", "line.schema.json", "scenario.schema.json"])
def test_the_schemas_are_valid_themselves(name: str) -> None:
    jsonschema.Draft202012Validator.check_schema(json.loads((config_dir() / "schema" / name).read_text("utf-8")))


def test_every_shipped_yaml_file_names_its_schema_for_editors() -> None:
    for folder, schema in (("catalogue", "catalogue.schema.json"), ("scenarios", "scenario.schema.json")):
        for path in (config_dir() / folder).glob("*.yaml"):
            first, second, *_ = path.read_text("utf-8").splitlines()
            assert first == f"# yaml-language-server: $schema=../schema/{schema}"
            assert second.startswith("# ")
            assert (path.parent / first.partition("=")[2]).is_file()
