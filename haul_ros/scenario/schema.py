"""The shipped JSON schemas: checking, defaults, and which keys exist."""

from __future__ import annotations

import copy
import json
import math
import re
from functools import cache
from typing import Any

import jsonschema

from haul_ros.resources import config_dir
from haul_ros.scenario.document import Document, KeyPath
from haul_ros.scenario.schema_errors import first_error, pattern_names

Schema = dict[str, Any]

CATALOGUE = "catalogue.schema.json"
LINE = "line.schema.json"
LINE_ROW = f"{LINE}#/$defs/row"
"""A part of that schema."""
SCENARIO = "scenario.schema.json"


def _is_finite_number(_checker: object, value: object) -> bool:
    if isinstance(value, float):
        return math.isfinite(value)
    return _is_whole_number(_checker, value)


def _is_whole_number(_checker: object, value: object) -> bool:
    # 2.0 is none: what is counted is written as it is meant. Beyond 64 bits nothing is counted.
    return isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**63


_Validator = jsonschema.validators.extend(
    jsonschema.Draft202012Validator,
    type_checker=jsonschema.Draft202012Validator.TYPE_CHECKER.redefine_many(
        {"number": _is_finite_number, "integer": _is_whole_number}
    ),
)


@cache
def _schema(name: str) -> Schema:
    """A schema, or a part of one, with the definitions that others share inside, so that it stands alone."""
    file, _, part = name.partition("#")
    schema = _read(file)
    for shared in (CATALOGUE, LINE):
        schema["$defs"] = schema["$defs"] | _read(shared)["$defs"]
    return {"$ref": f"#{part}", "$defs": schema["$defs"]} if part else schema


def _read(file: str) -> Schema:
    text = (config_dir() / "schema" / file).read_text("utf-8")
    for shared in (CATALOGUE, LINE):
        text = text.replace(f"{shared}#", "#")
    schema: Schema = json.loads(text)
    return schema


@cache
def _validator(name: str) -> Any:
    return _Validator(_schema(name))


def check(document: Document, name: str) -> None:
    """Refuse a document that the schema of that name does not allow.

    Raises
    ------
    ScenarioError
        The first finding, with file, line, key path and what is expected.
    """
    errors = list(_validator(name).iter_errors(document.data))
    if errors:
        raise first_error(document, errors)


def _resolve(schema: Schema) -> list[Schema]:
    """A schema and those it refers to, the nearest first."""
    found = [schema]
    while "$ref" in found[-1]:
        found.append(_schema(SCENARIO)["$defs"][found[-1]["$ref"].rpartition("/")[2]])
    return found


def _properties(schema: Schema) -> dict[str, Schema]:
    properties: dict[str, Schema] = {}
    for part in reversed(_resolve(schema)):
        for key, value in part.get("properties", {}).items():
            properties[key] = value if value is not True else properties[key]
    return properties


def fill_defaults(data: dict[str, Any], schema: Schema | None = None) -> None:
    """Write the schema's defaults into a checked scenario, in the schema's order of keys."""
    schema = _schema(SCENARIO) if schema is None else schema
    properties = _properties(schema)
    given = dict(data)
    data.clear()
    for key, value in properties.items():
        if key in given:
            data[key] = given.pop(key)
        elif "default" in value:
            data[key] = copy.deepcopy(value["default"])
        if isinstance(data.get(key), dict):
            fill_defaults(data[key], value)
    data.update(given)


def _subschema(schema: Schema, part: str | int) -> Schema:
    """The schema of one key or list entry, or an empty one where anything goes or nothing is known."""
    parts = _resolve(schema)
    if isinstance(part, int):
        return dict(next((found["items"] for found in parts if "items" in found), {}))
    named = _properties(schema)
    if part in named:
        return named[part]
    patterns = [item for found in parts for item in found.get("patternProperties", {}).items()]
    return dict(next((value for pattern, value in patterns if re.search(pattern, part)), _entries(parts)))


def _entries(parts: list[Schema]) -> Schema:
    others = [found["additionalProperties"] for found in parts if "additionalProperties" in found]
    return next((value for value in others if isinstance(value, dict)), {})


def known_keys(path: KeyPath) -> list[str]:
    """Keys that the scenario schema names for the mapping at a path."""
    schema = _schema(SCENARIO)
    for part in path:
        schema = _subschema(schema, part)
    return list(_properties(schema)) + pattern_names(schema)


def is_known(path: KeyPath) -> bool:
    """Whether the scenario schema has such a path."""
    schema = _schema(SCENARIO)
    for part in path:
        schema = _subschema(schema, part)
    return bool(schema)
