"""Sweeps from study files and from the words of the command line."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from haul_ros.errors import ScenarioError
from haul_ros.resources import config_dir, shipped_scenarios
from haul_ros.scenario import parse_override
from haul_ros.scenario.document import Document, KeyPath
from haul_ros.scenario.schema import check
from haul_ros.scenario.yaml_file import parse_yaml, read_yaml
from haul_ros.studies.errors import StudyError
from haul_ros.studies.kinds.table import KINDS
from haul_ros.studies.sweep import (
    MOST_CASES,
    Axis,
    Draw,
    PaperValues,
    Sweep,
    Trend,
    bounded_axes,
    has_values,
    list_axis,
    range_values,
    variants_axis,
)

SCHEMA = "study.schema.json"

_RANGE = re.compile(r"\s*([^:\[\]{}]+):([^:\[\]{}]+):([^:\[\]{}]+)\s*")
_DRAW = re.compile(r"\s*(uniform|normal)\s*\(([^,()]+),([^,()]+)\)\s*")


def shipped_studies() -> dict[str, Path]:
    """Names of the shipped studies, sorted, and their files."""
    return {path.stem: path for path in sorted((config_dir() / "studies").glob("*.yaml"))}


def load_study(name_or_path: str) -> Sweep:
    """A shipped study by name, or one from a file.

    Raises
    ------
    HaulError
        Unknown name, unreadable file, or anything in it that cannot be, in one line.
    """
    shipped = shipped_studies()
    path = shipped.get(name_or_path, Path(name_or_path))
    try:
        document = read_yaml(path)
    except (FileNotFoundError, IsADirectoryError) as error:
        known = ", ".join(shipped)
        raise StudyError(f"{name_or_path}: no such study, expected a study file (YAML) or one of {known}") from error
    check(document, SCHEMA)
    data: dict[str, Any] = document.data
    if data.get("draw") == {}:
        raise document.error(("draw",), "is empty, expected KEY: {uniform: [LOW, HIGH]} or {normal: [MEAN, SD]}")
    try:
        study = Sweep(
            name=path.stem,
            description=data.get("description", ""),
            scenarios=_scenarios(data, path.parent),
            overrides=data.get("set", {}),
            axes=bounded_axes(data.get("over", {}), partial(_axis, document)),
            draws=tuple(_draw(key, entry) for key, entry in data.get("draw", {}).items()),
            samples=data.get("samples", 0),
            seed=data.get("seed", 0),
            paper=tuple(map(_paper, data.get("paper", []))),
            fitted=tuple(data.get("fitted", [])),
            kind=data.get("kind", "sweep"),
            quantity=data.get("quantity", "force"),
            trends=tuple(map(_trend, data.get("trends", []))),
        )
        KINDS[study.kind].check(study)
    except StudyError as error:
        raise StudyError(f"{path}: {error}") from error
    named: dict[KeyPath, Mapping[str, object]]
    named = {("paper", number, "where"): values.where for number, values in enumerate(study.paper)}
    named |= {("fitted", number): where for number, where in enumerate(study.fitted)}
    for place, where in named.items():
        if not any(has_values(case, where) for case in study.cases()):
            raise document.error(place, "no case of this study has these values")
    return study


def _scenarios(data: Mapping[str, Any], folder: Path) -> tuple[str, ...]:
    """Files stand relative to the study's own folder."""
    names = [*([data["scenario"]] if "scenario" in data else []), *data.get("scenarios", [])]
    return tuple(name if name in shipped_scenarios() else str(folder / name) for name in names)


def _axis(document: Document, key: str, most: int) -> Axis:
    path = ("over", key)
    entry = document.at(path)
    if isinstance(entry, list):
        return list_axis(key, entry, most)
    if entry and all(isinstance(variant, dict) for variant in entry.values()):
        return variants_axis(key, entry)
    if not {"from", "to"} <= entry.keys() or any(isinstance(value, dict) for value in entry.values()):
        raise document.error(path, "expected a list, a range {from, to, step} or {from, to, count}, or named variants")
    return list_axis(key, range_values(key, entry["from"], entry["to"], entry.get("step"), entry.get("count")), most)


def _draw(key: str, entry: Mapping[str, Sequence[float]]) -> Draw:
    ((distribution, (first, second)),) = entry.items()
    return Draw(key, distribution, (float(first), float(second)))


def _paper(entry: Mapping[str, Any]) -> PaperValues:
    return PaperValues(
        where=entry.get("where", {}),
        force=entry["force_kN"] * 1e3 if "force_kN" in entry else None,
        stroke=entry["stroke_mm"] / 1e3 if "stroke_mm" in entry else None,
        position=entry.get("position"),
    )


def _trend(entry: Mapping[str, Any]) -> Trend:
    return Trend(entry["along"], entry["quantity"], entry["sense"] == "rises", entry["source"])


def free_sweep(
    scenario: str,
    overrides: Iterable[str],
    over: Iterable[str],
    draw: Iterable[str],
    samples: int | None,
    seed: int,
) -> Sweep:
    """A sweep from the command line.

    ``over`` has ``KEY=40,60,80`` or ``KEY=40:100:20`` (from, to, step); ``draw`` has
    ``KEY=uniform(LOW,HIGH)`` or ``KEY=normal(MEAN,SD)``; ``overrides`` has ``KEY=VALUE``.

    Raises
    ------
    HaulError
        Something is not of this form, in one line.
    """
    axes = bounded_axes(over, parse_over)
    draws = tuple(map(parse_draw, draw))
    if not (axes or draws):
        raise StudyError("nothing is varied, expected --over KEY=VALUES or --draw KEY=DISTRIBUTION")
    if bool(draws) != (samples is not None):
        raise StudyError("--draw and --samples are given together")
    if samples is not None and samples < 1:
        raise StudyError(f"--samples {samples}: must be 1 or more")
    if seed < 0:
        raise StudyError(f"--seed {seed}: must be 0 or more")
    name = Path(scenario).stem
    return Sweep(
        name="sweep",
        description=f"sweep of {name}",
        scenarios=(scenario,),
        overrides=dict(map(parse_override, overrides)),
        axes=axes,
        draws=draws,
        samples=samples or 0,
        seed=seed,
    )


def parse_over(text: str, most: int = MOST_CASES) -> Axis:
    """An axis from ``KEY=40,60,80`` or ``KEY=40:100:20``.

    Raises
    ------
    HaulError
        It is neither, or has more than ``most`` values.
    """
    key, equals, spec = text.partition("=")
    key = key.strip()
    if not (equals and key and spec.strip()):
        raise StudyError(f"--over {text}: expected KEY=V1,V2,... or KEY=FROM:TO:STEP, as initial_speed_kmh=40:100:20")
    if found := _RANGE.fullmatch(spec):
        first, last, step = (_number(f"--over {text}", part) for part in found.groups())
        return list_axis(key, range_values(key, first, last, step, None), most)
    listed = spec if spec.lstrip().startswith("[") else f"[{spec}]"
    try:
        values = parse_yaml(listed, f"--over {key}").data
    except ScenarioError as error:
        raise StudyError(f"--over {text}: not a list of values: V1,V2,... or FROM:TO:STEP") from error
    return list_axis(key, values, most)


def parse_draw(text: str) -> Draw:
    """A draw from ``KEY=uniform(LOW,HIGH)`` or ``KEY=normal(MEAN,SD)``.

    Raises
    ------
    StudyError
        It is neither.
    """
    key, _, spec = text.partition("=")
    found = _DRAW.fullmatch(spec)
    if not (key.strip() and found):
        raise StudyError(f"--draw {text}: expected KEY=uniform(LOW,HIGH) or KEY=normal(MEAN,SD)")
    distribution, *parameters = found.groups()
    first, second = (_number(f"--draw {text}", part) for part in parameters)
    return Draw(key.strip(), distribution, (first, second))


def _number(where: str, text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise StudyError(f"{where}: {text.strip()} is not a number") from error
