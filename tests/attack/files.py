"""Attacks by what users write: scenarios, studies, arguments, parameters."""

from __future__ import annotations

import copy
import random
from functools import cache
from pathlib import Path
from typing import Any

from haul_ros.cli.commands import COMMANDS
from haul_ros.errors import HaulError
from haul_ros.resources import shipped_scenarios
from haul_ros.scenario import load_scenario, load_scenario_text
from haul_ros.scenario.yaml_file import dump_yaml, parse_yaml
from haul_ros.studies.definition import shipped_studies
from tests.attack import nasty
from tests.attack.harness import Found, Outcome, haul

SHORT = ("--set", "max_duration_s=0.05")
"""A run of a few milliseconds, whatever else is in the scenario."""


@cache
def _complete_documents() -> list[Any]:
    """The shipped scenarios with all catalogue entries that they use, so that these are attacked too."""
    return [parse_yaml(load_scenario(name).document, name).data for name in shipped_scenarios()]


@cache
def _studies() -> list[Any]:
    return [parse_yaml(path.read_text("utf-8"), name).data for name, path in shipped_studies().items()]


def scenario(rng: random.Random, folder: Path) -> Outcome:
    """A scenario with changes, as data or as text, run for a few milliseconds; what loads, loads again from itself."""
    data = copy.deepcopy(rng.choice(_complete_documents()))
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        nasty.change(rng, data)
    path = folder / "case.yaml"
    path.write_bytes(_text(rng, data))
    outcome, _ = haul("run", str(path), *SHORT, "--quiet")
    if outcome is Outcome.RAN and rng.random() < 0.2:
        first = load_scenario(path)
        again = load_scenario_text(first.document, first.name)
        if again != first:
            raise Found("a scenario is another one when it is loaded from its own document")
    return outcome


def _text(rng: random.Random, data: Any) -> bytes:
    try:
        written = dump_yaml(data).encode("utf-8", "replace")
    except ValueError:  # an integer of too many digits
        written = b"a: " + b"9" * 4200
    return nasty.change_bytes(rng, written) if rng.random() < 0.15 else written


def study(rng: random.Random, folder: Path) -> Outcome:
    """A study with changes, of a short train for a few milliseconds."""
    data = copy.deepcopy(rng.choice(_studies()))
    for _ in range(rng.choice((1, 1, 2, 4))):
        nasty.change(rng, data)
    if isinstance(data, dict):
        settings = data.get("set")
        data["set"] = (settings if isinstance(settings, dict) else {}) | {"max_duration_s": 0.01, "commands": []}
        if data.get("kind") != "vibration" and rng.random() < 0.9:
            # few cases, whatever the study has
            data["over"] = {key: _few(entry) for key, entry in _mapping(data.get("over")).items()}
        if isinstance(data.get("samples"), int) and data["samples"] > 3:
            data["samples"] = rng.choice((3, 10**12, 2.0))
    path = folder / "case.yaml"
    path.write_bytes(_text(rng, data))
    if _cases(path) > 100:
        return Outcome.REFUSED
    # without commands the claims of the paper do not hold, which is no error
    return haul("study", str(path), "-o", str(folder / "out"), "--quiet", "--jobs", "1")[0]


def _cases(path: Path) -> int:
    from haul_ros.studies.definition import load_study

    try:
        return len(load_study(str(path)))
    except HaulError:
        return 0


def _mapping(value: object) -> dict[Any, Any]:
    return value if isinstance(value, dict) else {}


def _few(entry: Any) -> Any:
    if isinstance(entry, list):
        return entry[:2]
    return dict(list(entry.items())[:2]) if isinstance(entry, dict) and "from" not in entry else entry


def arguments(rng: random.Random, folder: Path) -> Outcome:
    """A command with words that nobody means."""
    (folder / "short.yaml").write_text(dump_yaml(_complete_documents()[0]), "utf-8")
    command = rng.choice([command for command in COMMANDS if command.name not in ("node", "brake")])
    words = [command.name]
    options = ["-o", "--set", "--json", "--quiet", "--over", "--draw", "--samples", "--seed", "--jobs", "--compression",
               "--scenario", "--help", "--version", "--unknown"]  # fmt: skip
    for _ in range(rng.randint(0, 5)):
        draw = rng.random()
        if draw < 0.4:
            words.append(rng.choice(options))
        elif draw < 0.6:
            words.append(rng.choice(["short.yaml", "daqin_1_1_0", "sweep", "validation", "vibration", "missing.mcap"]))
        elif draw < 0.8:
            words.append(f"{_key(rng)}={nasty.text(rng)}")
        else:
            words.append(rng.choice([nasty.text(rng), str(nasty.number(rng))]) if rng.random() < 0.9 else "=")
    words = [word.replace("\0", "") for word in words]
    if command.name == "run":
        words += SHORT
    if command.name in ("view", "watch"):  # which otherwise go on until they are told to end
        words.append("--unknown")
    if command.name == "study":
        words += ["--set", "max_duration_s=0.01", "--set", "commands=[]"] if "sweep" in words else ["--unknown"]
    return haul(*words)[0]


def _key(rng: random.Random) -> str:
    path = rng.choice(nasty.places(_complete_documents()[0]))
    return ".".join(map(str, path))


def parameters(rng: random.Random, folder: Path) -> Outcome:
    """Parameters of the node, as ROS hands them over."""
    from haul_ros.ros.parameters import check_given, parameter_rows, scenario_overrides, values_in_effect

    names = [*parameter_rows(["slave_1", "slave_2", "slave_9", "default", "master"]), nasty.text(rng)]
    values: list[Any] = [nasty.number, nasty.text, lambda r: r.choice((True, False, None, [1, 2], ["a"], b"x", []))]
    given = {rng.choice(names): rng.choice(values)(rng) for _ in range(rng.randint(1, 4))}
    try:
        checked, _ = check_given(given)
        if str(checked.get("scenario", "")).startswith("/dev"):
            return Outcome.REFUSED
        loaded = load_scenario(str(checked.get("scenario", "daqin_1_2_1")), scenario_overrides(checked))
        values_in_effect(loaded, checked)
    except HaulError:
        return Outcome.REFUSED
    return Outcome.RAN
