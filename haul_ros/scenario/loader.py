"""From a name, a file or a text to a scenario."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from haul_ros.errors import ScenarioError
from haul_ros.model.scenario import Scenario
from haul_ros.resources import shipped_scenarios
from haul_ros.scenario.brakes import brakes
from haul_ros.scenario.catalogue import caveats, take_over
from haul_ros.scenario.document import Document
from haul_ros.scenario.faults import faults
from haul_ros.scenario.formation import consist
from haul_ros.scenario.initial_state import initial_state
from haul_ros.scenario.line import forget_line, take_over_line
from haul_ros.scenario.operation import check_time_step, commands, driver, time_grid, track
from haul_ros.scenario.overrides import alters_entry, apply
from haul_ros.scenario.radio import radio_links
from haul_ros.scenario.recording import recording_plan
from haul_ros.scenario.schema import SCENARIO, check, fill_defaults
from haul_ros.scenario.sensors import coupler_sensors
from haul_ros.scenario.yaml_file import check_values, dump_yaml, parse_yaml, read_yaml
from haul_ros.units import kmh_to_mps


def load_scenario(name_or_path: str | Path, overrides: Mapping[str, object] | None = None) -> Scenario:
    """Load a shipped scenario by name, or a file.

    ``overrides`` maps dotted paths of the scenario, as if the catalogue entries that it uses were
    written in it, to values in the units of their keys: ``{"radio.default.delay_s": 1.0,
    "couplers.paper_set_b.loading_stiffness_kN_per_mm": 20, "consist.1.count": 50}``. They are set
    in the given order, those inside catalogue entries last. ``track.file`` in them takes the place of the whole line,
    and a file is looked for from the current folder on; that of the scenario beside the scenario's own file.

    Raises
    ------
    ScenarioError
        Unknown name, unreadable file, or anything in it or the overrides that cannot be, in one
        line with file, line number, key path, value and what is expected.
    """
    shipped = shipped_scenarios()
    path = shipped.get(str(name_or_path), Path(name_or_path))
    expected = f"expected a scenario file (YAML) or one of {', '.join(shipped)}"
    try:
        document = read_yaml(path)
    except FileNotFoundError as error:
        raise ScenarioError(f"{path}: no such scenario, {expected}") from error
    except IsADirectoryError as error:
        raise ScenarioError(f"{path}: is a directory, {expected}") from error
    return _build(document, path.stem, overrides or {}, path.parent)


def load_scenario_text(text: str, name: str, overrides: Mapping[str, object] | None = None) -> Scenario:
    """Load a scenario from YAML text, such as ``Scenario.document`` of a recording; ``overrides`` as above.

    Raises
    ------
    ScenarioError
        As for `load_scenario`; the name stands for the file.
    """
    return _build(parse_yaml(text, name), name, overrides or {}, None)


def _build(document: Document, name: str, overrides: Mapping[str, object], folder: Path | None) -> Scenario:
    _complete(document, overrides, folder)
    data = document.data
    train = consist(document)
    time_step, sample_rate = time_grid(document)
    check_time_step(document, train)
    brake = brakes(document, data["brakes"], train)
    return Scenario(
        name=name,
        description=data["description"],
        consist=train,
        brakes=brake,
        track=track(document),
        radio=radio_links(document, train),
        radio_seed=int(data["radio"]["seed"]),
        initial_state=initial_state(document, brake),
        initial_speed=kmh_to_mps(data["initial_speed_kmh"]),
        commands=commands(document, train),
        time_step=time_step,
        sample_rate=sample_rate,
        max_duration=float(data["max_duration_s"]),
        document=dump_yaml(data),
        driver=driver(document, train),
        faults=faults(document, train, brake),
        caveats=caveats(data),
        recording=recording_plan(document),
        sensors=coupler_sensors(document, train),
    )


def _complete(document: Document, overrides: Mapping[str, object], folder: Path | None) -> None:
    """Write defaults, overrides, the line and the catalogue entries that are used into the document."""
    check(document, SCENARIO)
    take_over_line(document, folder)
    fill_defaults(document.data)
    for key, value in overrides.items():
        if not alters_entry(key):
            _override(document, key, value)
    check(document, SCENARIO)
    take_over(document)
    apply(document, {key: value for key, value in overrides.items() if alters_entry(key)})
    check(document, SCENARIO)
    # An override may have made the train use another entry.
    take_over(document)
    fill_defaults(document.data)
    # What was put together from several files has to be read again as one.
    check_values(document)


def _override(document: Document, key: str, value: object) -> None:
    if key == "track.file":
        forget_line(document)
    apply(document, {key: value})
    if key in ("track", "track.file"):
        take_over_line(document, Path())
