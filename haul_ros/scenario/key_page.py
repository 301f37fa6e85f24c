"""``python -m haul_ros.scenario.key_page``: docs/scenario-keys.md of the checkout, from the schemas."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from haul_ros.markdown import cell
from haul_ros.resources import config_dir

_ORIGIN = "made from config/schema by: python -m haul_ros.scenario.key_page"
_ENTRY = "NAME"
"""Stands for a name that the user chooses."""


def key_page() -> str:
    """A page with every key of a scenario file: what it is, its type and range, its default."""
    schemas = {path.name: json.loads(path.read_text("utf-8")) for path in (config_dir() / "schema").glob("*.json")}
    scenario = schemas["scenario.schema.json"]
    lines = [
        "# Keys of a scenario file",
        "",
        f"<!-- {_ORIGIN} -->",
        "",
        "`[]` is each entry of a list, `NAME` a name of one's own; units are in the names. `--set` takes the same",
        "keys: `haul run daqin_1_2_1 --set radio.default.delay_s=1`.",
        "",
    ]
    for name, schema in scenario["properties"].items():
        rows = list(_rows(name, schema, scenario, schemas, required=name in scenario["required"]))
        lines += [f"## {name}", "", "| key | value | meaning |", "|---|---|---|", *rows, ""]
    return "\n".join(lines)


def _rows(
    key: str, schema: Mapping[str, Any], root: Mapping[str, Any], schemas: Mapping[str, Any], *, required: bool = False
) -> Iterator[str]:
    schema, root = _resolved(schema, root, schemas)
    value = ", ".join(filter(None, ["required" if required else "", _value(schema)]))
    yield f"| `{key}` | {value} | {cell(schema.get('description', ''))} |"
    for name, inner in schema.get("properties", {}).items():
        yield from _rows(f"{key}.{name}", inner, root, schemas, required=name in schema.get("required", ()))
    for inner in schema.get("patternProperties", {}).values():
        yield from _rows(f"{key}.{_ENTRY}", inner, root, schemas)
    if isinstance(inner := schema.get("additionalProperties"), dict):
        yield from _rows(f"{key}.{_ENTRY}", inner, root, schemas)
    if isinstance(inner := schema.get("items"), dict):
        yield from _rows(f"{key}[]", inner, root, schemas)


def _resolved(
    schema: Mapping[str, Any], root: Mapping[str, Any], schemas: Mapping[str, Any]
) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    """A schema with what it refers to, its own words first, and the document in which that stands."""
    while "$ref" in schema:
        file, _, pointer = schema["$ref"].partition("#")
        root = schemas[file] if file else root
        found: Any = root
        for part in filter(None, pointer.split("/")):
            found = found[part]
        own = {name: value for name, value in schema.items() if name != "$ref"}
        # A key that is only allowed here (true) is described where the reference leads
        keys = {name: inner for name, inner in own.get("properties", {}).items() if isinstance(inner, dict)}
        schema = {**found, **own, "properties": {**found.get("properties", {}), **keys}}
    return schema, root


def _value(schema: Mapping[str, Any]) -> str:
    parts = [_choices(schema) or _kind(schema), _range(schema), *_alternatives(schema)]
    if "default" in schema and schema["default"] not in ({}, [], ""):
        parts.append(f"default `{json.dumps(schema['default'])}`")
    return ", ".join(filter(None, parts))


def _alternatives(schema: Mapping[str, Any]) -> Iterator[str]:
    for one_of in filter(None, [schema.get("oneOf"), *(part.get("oneOf") for part in schema.get("allOf", ()))]):
        yield "one of " + ", ".join(" with ".join(f"`{key}`" for key in option["required"]) for option in one_of)


def _choices(schema: Mapping[str, Any]) -> str:
    given = schema.get("enum", [schema["const"]] if "const" in schema else [])
    return " or ".join(f"`{json.dumps(value).strip(chr(34))}`" for value in given)


def _kind(schema: Mapping[str, Any]) -> str:
    kinds = schema.get("type", "")
    words = {"object": "keys", "array": "list", "string": "text", "boolean": "true or false", "integer": "whole number"}
    return " or ".join(words.get(kind, kind) for kind in ([kinds] if isinstance(kinds, str) else kinds))


def _range(schema: Mapping[str, Any]) -> str:
    limits = (("minimum", "from"), ("exclusiveMinimum", "above"), ("maximum", "to"), ("exclusiveMaximum", "below"))
    return " ".join(f"{word} {schema[name]:g}" for name, word in limits if name in schema)


def main() -> int:
    """Write it."""
    (Path(__file__).parents[2] / "docs/scenario-keys.md").write_text(key_page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
