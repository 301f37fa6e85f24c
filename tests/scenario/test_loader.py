"""Scenario files as users write them: what they become, and what they are told."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.errors import HaulError, ScenarioError
from haul_ros.scenario.catalogue import SECTION_FILES, catalogue_section
from haul_ros.scenario.loader import load_scenario, load_scenario_text
from haul_ros.scenario.yaml_file import dump_yaml

MY_WAGON = """\
vehicles:
  MY_WAGON:
    mass_t: 84
    length_m: 12
    resistance: wagon_loaded
    shoes: 8
    brake_shoe: high_friction_composite
    shoe_force_kN: 20
    cylinder_pressure_kPa: 360
"""


def _refusal(text: str) -> str:
    with pytest.raises(ScenarioError) as caught:
        load_scenario_text(text, "my.yaml")
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_what_a_short_scenario_leaves_out_has_sensible_values(small_train: str) -> None:
    scenario = load_scenario_text(small_train, "short")
    assert scenario.name == "short"
    assert (scenario.time_step, scenario.sample_rate, scenario.max_duration) == (0.001, 50.0, 300.0)
    assert scenario.description == ""
    assert scenario.commands == ()
    assert (scenario.track.start_chainage, scenario.track.grades, scenario.track.curves) == (0.0, (), ())
    assert list(scenario.radio) == ["slave_1"]
    assert (scenario.radio["slave_1"].delay, scenario.radio["slave_1"].connected) == (0.0, True)
    assert scenario.radio_seed == 0


def test_a_file_gives_its_stem_as_name_and_its_values_in_si_units(
    small_train: str, scenario_file: Callable[[str], str]
) -> None:
    path = scenario_file("description: mine\n" + small_train.replace("80\n", "36\n"))
    scenario = load_scenario(path)
    assert (scenario.name, scenario.description) == ("my", "mine")
    assert scenario.initial_speed == pytest.approx(10.0)


def test_a_file_with_a_byte_order_mark_is_read(small_train: str, scenario_file: Callable[[str], str]) -> None:
    assert load_scenario(scenario_file("\ufeff" + small_train)).name == "my"


def test_an_own_vehicle_stands_beside_those_of_the_catalogue(small_train: str) -> None:
    scenario = load_scenario_text(small_train.replace("C80", "MY_WAGON") + MY_WAGON, "own")
    assert [v.name for v in scenario.consist.vehicles] == ["SS4", *["MY_WAGON"] * 4, "SS4"]
    assert scenario.consist.vehicles[1].mass == 84e3


def test_an_own_entry_replaces_the_whole_catalogue_entry_of_its_name(small_train: str) -> None:
    scenario = load_scenario_text(small_train + MY_WAGON.replace("MY_WAGON", "C80"), "own")
    assert scenario.consist.vehicles[1].mass == 84e3
    assert not any(line.startswith("vehicles.C80") for line in scenario.caveats)


def test_a_document_needs_no_catalogue(small_train: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = load_scenario_text(small_train, "small")
    monkeypatch.setattr("haul_ros.scenario.catalogue.catalogue_section", lambda section: pytest.fail("was read"))
    assert load_scenario_text(scenario.document, "small") == scenario


def test_taking_over_a_catalogue_entry_leaves_the_catalogue_as_it_was(small_train: str) -> None:
    before = {section: dump_yaml(catalogue_section(section).data) for section in SECTION_FILES}
    load_scenario("daqin_1_2_1", {"vehicles.C80.mass_t": 90})
    assert {section: dump_yaml(catalogue_section(section).data) for section in SECTION_FILES} == before


def test_a_yaml_alias_can_be_overridden_without_touching_its_twin(scenario_file: Callable[[str], str]) -> None:
    path = scenario_file(
        "consist:\n  - &loco {vehicle: SS4, role: master}\n  - &wagons {vehicle: C80, count: 2}\n  - *wagons\n"
        "coupler: ST\nbrakes: paper_set_b\ninitial_speed_kmh: 8e1\n"
    )
    assert len(load_scenario(path, {"consist.1.count": 5}).consist.vehicles) == 1 + 5 + 2


@settings(max_examples=25, deadline=None)
@given(
    speed=st.floats(0.0, 200.0),
    steps=st.integers(1, 500),
    wagons=st.integers(2, 40),
    gear=st.sampled_from(["paper_set_a", "paper_set_b", "MT-2", "MT-3", "ST"]),
    delay=st.floats(0.0, 10.0),
    description=st.text(max_size=20),
    grade=st.floats(-30.0, 30.0),
)
@pytest.mark.no_cover
def test_any_scenario_survives_being_written_and_read(
    speed: float, steps: int, wagons: int, gear: str, delay: float, description: str, grade: float
) -> None:
    overrides = {
        "initial_speed_kmh": speed,
        "time_step_ms": 1000.0 / (50 * steps),
        "consist.1.count": wagons,
        "coupler": gear,
        "radio.slave_2.delay_s": delay,
        "description": description,
        "track.grades": [{"from_m": 0, "grade_permille": grade}],
    }
    scenario = load_scenario("daqin_1_2_1", overrides)
    assert load_scenario_text(scenario.document, scenario.name) == scenario


def test_an_unknown_name_is_told_the_shipped_scenarios(scenario_file: Callable[[str], str]) -> None:
    with pytest.raises(ScenarioError, match=r"^daqin_1_2_2: no such scenario, expected .* daqin_1_2_1, .*c63$"):
        load_scenario("daqin_1_2_2")


def test_a_directory_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r": is a directory, expected a scenario file"):
        load_scenario(tmp_path)


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b"])
def test_a_path_that_cannot_be_is_refused(name: str) -> None:
    with pytest.raises(ScenarioError, match=r": cannot be read: "):
        load_scenario(name)


def test_a_file_as_a_folder_is_refused(scenario_file: Callable[[str], str], small_train: str) -> None:
    with pytest.raises(ScenarioError, match=r"^my.yaml/x: cannot be read: Not a directory$"):
        load_scenario(scenario_file(small_train) + "/x")


def test_every_error_is_a_haul_error() -> None:
    assert issubclass(ScenarioError, HaulError)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("mass_t: 84", "mass_t: -84", "my.yaml:10: vehicles.MY_WAGON.mass_t = -84, must be above 0"),
        ("mass_t: 84", "mass_t: .nan", "my.yaml:10: vehicles.MY_WAGON.mass_t = nan, must be a finite number"),
        ("mass_t: 84", "mass_t: -.inf", "my.yaml:10: vehicles.MY_WAGON.mass_t = -inf, must be a finite number"),
        ("mass_t: 84", "mass_t: 84 t", "my.yaml:10: vehicles.MY_WAGON.mass_t = '84 t', must be a finite number"),
        ("mass_t: 84", "mass_t: yes", "my.yaml:10: vehicles.MY_WAGON.mass_t = 'yes', must be a finite number"),
        ("mass_t: 84", "mass_t: true", "my.yaml:10: vehicles.MY_WAGON.mass_t = true, must be a finite number"),
        ("mass_t: 84", f"mass_t: 1{'0' * 400}", "= a number of more than 36 digits, must be a finite number"),
        ("mass_t: 84", "mass_kg: 84", "my.yaml:10: vehicles.MY_WAGON.mass_kg: unknown key, did you mean mass_t?"),
        ("    mass_t: 84\n", "", "my.yaml:9: vehicles.MY_WAGON: mass_t is missing"),
        ("shoes: 8", "shoes: 8.5", "my.yaml:13: vehicles.MY_WAGON.shoes = 8.5, must be a whole number"),
        ("    shoe_force_kN: 20\n", "", "my.yaml:9: vehicles.MY_WAGON: needs either shoe_force_kN or cylinder"),
        ("MY_WAGON", "MY WAGON", "my.yaml:9: vehicles.MY WAGON: must be a name of letters, digits, _ and -"),
        ("MY_WAGON", "12", "my.yaml:9: vehicles.12: a key must be text"),
        ("wagon_loaded", "wagon", "vehicles.MY_WAGON.resistance = 'wagon', unknown name, resistances: ss_locomotive,"),
        ("C80", "C81", "my.yaml:3: consist.1.vehicle = 'C81', unknown name, vehicles: C63, C80, C80_empty, "),
        ("coupler: paper_set_b", "coupler: MT2", "my.yaml:5: coupler = 'MT2', unknown name, couplers: MT-2, MT-3, "),
        ("brakes: paper_set_b", "brakes: [b]", "my.yaml:6: brakes = a list, must be text"),
        ("brakes: paper_set_b\n", "", "my.yaml: brakes is missing"),
        ("kmh: 80", "kmh: 201", "my.yaml:7: initial_speed_kmh = 201, must be at most 200"),
        ("kmh: 80", "kmh:", "my.yaml:7: initial_speed_kmh = nothing, must be a finite number"),
        ("count: 4", "count: 0", "my.yaml:3: consist.1.count = 0, must be at least 1"),
        ("role: slave", "role: banker", "my.yaml:4: consist.2.role = 'banker', must be master or slave"),
    ],
)
def test_a_mistake_is_told_with_line_key_value_and_what_is_expected(
    small_train: str, old: str, new: str, expected: str
) -> None:
    text = small_train + MY_WAGON
    assert old in text
    assert expected in _refusal(text.replace(old, new))


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("speed: 3", "my.yaml:8: speed: unknown key, known: description"),
        ("radio: {slave_0: {}}", "my.yaml:8: radio.slave_0: unknown key, known: seed, default, slave_1, slave_2 ..."),
        ("commands: {at_s: 0}", "my.yaml:8: commands = a mapping, must be a list"),
        ("commands: [{at_s: 0, locomotive: master}]", "commands.0: needs one of emergency, brake, traction_kN"),
        (
            "commands: [{at_s: 0, locomotive: master, brake: 1, emergency: true}]",
            "commands.0: needs one of emergency, brake, traction_kN",
        ),
        ("couplers: {X: {transition_speed_mps: 0.01, loading: [[0, 0]]}}", "couplers.X"),
        (
            "couplers: {X: {transition_speed_mps: 1, loading: [[0, 0]], unloading: [[0, 0], [1, 1]]}}",
            "couplers.X.loading = a list, must have at least 2 entries",
        ),
        (
            "couplers: {X: {transition_speed_mps: 1, loading_stiffness_kN_per_mm: 1, unloading_stiffness_kN_per_mm: 1, "
            "bottoming_stiffness_kN_per_mm: 9}}",
            "couplers.X: bottoming_stiffness_kN_per_mm needs maximum_stroke_mm beside it",
        ),
        (
            "vehicles: {C80: {standing: guessed}}",
            "standing = 'guessed', must be published or fitted or assumed or over",
        ),
        ("vehicles: {C80: {standing: {mass_t: fitted}}}", "vehicles.C80.standing: default is missing"),
        ("vehicles: {C80: {standing: {default: fitted, a b: fitted}}}", "vehicles.C80.standing.a b: must be a name"),
    ],
)
def test_a_line_too_many_is_told(small_train: str, line: str, expected: str) -> None:
    assert expected in _refusal(small_train + line + "\n")


def test_a_misspelt_key_is_told_before_what_it_leaves_missing(small_train: str) -> None:
    text = small_train.replace("initial_speed_kmh", "initial_speed_mps")
    assert _refusal(text) == "my.yaml:7: initial_speed_mps: unknown key, did you mean initial_speed_kmh?"
