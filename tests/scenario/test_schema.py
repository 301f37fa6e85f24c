"""Every keyword that the schemas use has its phrase, and the phrases read well."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from jsonschema.exceptions import ValidationError

from haul_ros.resources import config_dir
from haul_ros.scenario.document import Document
from haul_ros.scenario.schema_errors import first_error

# keyword: (its value, an instance that fails, what is told)
PHRASES: dict[str, tuple[Any, Any, str]] = {
    "type": (["string", "object"], 3, "x: a = 3, must be text or a mapping (key: value)"),
    "minimum": (1, 0, "x: a = 0, must be at least 1"),
    "exclusiveMinimum": (0, 0, "x: a = 0, must be above 0"),
    "maximum": (1, 2, "x: a = 2, must be at most 1"),
    "exclusiveMaximum": (1, 1, "x: a = 1, must be below 1"),
    "enum": (["b", "c"], "d", "x: a = 'd', must be b or c"),
    "pattern": ("^b$", "c d", "x: a = 'c d', must be a name of letters, digits, _ and -"),
    "maxLength": (1, "bb", "x: a = 'bb', must have at most 1 characters"),
    "minItems": (1, [], "x: a = a list, must have at least 1 entry"),
    "maxItems": (2, [1, 2, 3], "x: a = a list, must have at most 2 entries"),
    "required": (["b"], {}, "x: a: b is missing"),
    "oneOf": ([{"required": ["b", "c"]}, {"required": ["d"]}], {}, "x: a: needs either b and c or d"),
    "dependentRequired": ({"b": ["c"]}, {"b": 1}, "x: a: b needs c beside it"),
    "additionalProperties": (False, {"b": 1}, "x: a.b: unknown key, known: none"),
}
# Keywords that lead to others, or say nothing about the value.
STRUCTURE = {
    "$schema", "$ref", "$defs", "title", "description", "default", "properties", "patternProperties", "propertyNames",
    "items", "if", "then", "else", "allOf",
}  # fmt: skip


def _keywords(schema: object) -> Iterator[str]:
    if isinstance(schema, dict):
        for key, value in schema.items():
            yield key
            if key in ("properties", "patternProperties", "$defs"):
                for child in value.values():
                    yield from _keywords(child)
            elif key in ("additionalProperties", "items", "propertyNames", "if", "then", "else"):
                yield from _keywords(value)
            elif key == "oneOf":
                for child in value:
                    yield from _keywords(child)


@pytest.mark.parametrize("name", ["catalogue.schema.json", "line.schema.json", "scenario.schema.json"])
def test_each_keyword_of_the_schemas_has_a_phrase(name: str) -> None:
    schema = json.loads((config_dir() / "schema" / name).read_text("utf-8"))
    assert set(_keywords(schema)) <= set(PHRASES) | STRUCTURE


@pytest.mark.parametrize("keyword", PHRASES)
def test_the_phrase_of_a_keyword_names_what_is_expected(keyword: str) -> None:
    value, instance, expected = PHRASES[keyword]
    error = ValidationError(
        "", validator=keyword, validator_value=value, instance=instance, schema={keyword: value}, path=["a"]
    )
    assert str(first_error(Document("x", {"a": instance}), [error])) == expected
