"""What the schema finds, in one clear line."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Any

from jsonschema.exceptions import ValidationError

from haul_ros.errors import ScenarioError
from haul_ros.scenario.document import Document, KeyPath

_KINDS = {
    "number": "a finite number",
    "integer": "a whole number",
    "string": "text",
    "boolean": "true or false",
    "object": "a mapping (key: value)",
    "array": "a list",
}


def suggestion(word: str, known: Iterable[str]) -> str:
    """``did you mean ...?``, or all known words."""
    known = list(known)
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f"did you mean {near[0]}?" if near else f"known: {', '.join(known) or 'none'}"


def pattern_names(schema: Mapping[str, Any]) -> list[str]:
    """Keys that the mapping may have by pattern, in words: ``slave_1, slave_2 ...``."""
    return [value["title"] for value in schema.get("patternProperties", {}).values()]


def _words(values: Iterable[object]) -> str:
    return " or ".join(str(value) for value in values)


def _unknown_keys(error: ValidationError) -> list[str]:
    schema = error.schema
    patterns = schema.get("patternProperties", {})
    known = schema.get("properties", {})
    return [k for k in error.instance if k not in known and not any(re.search(p, k) for p in patterns)]


def _path(error: ValidationError) -> KeyPath:
    path = tuple(error.absolute_path)
    return (*path, _unknown_keys(error)[0]) if error.validator == "additionalProperties" else path


def _alternatives(error: ValidationError) -> str:
    branches = [" and ".join(branch["required"]) for branch in error.validator_value]
    return f"needs one of {', '.join(branches)}" if len(branches) > 2 else f"needs either {' or '.join(branches)}"


def _missing(error: ValidationError) -> str:
    missing: str = next(key for key in error.validator_value if key not in error.instance)
    return missing


def _dependents(error: ValidationError) -> str:
    key, needed = next(
        (key, other)
        for key, others in error.validator_value.items()
        for other in others
        if key in error.instance and other not in error.instance
    )
    return f"{key} needs {needed} beside it"


def _count(number: int) -> str:
    return f"{number} entry" if number == 1 else f"{number} entries"


def _type(expected: str | list[str]) -> str:
    return _words(_KINDS[kind] for kind in ([expected] if isinstance(expected, str) else expected))


def _expectation(error: ValidationError) -> str:
    bound: Any = error.validator_value
    match error.validator:
        case "type":
            return f"must be {_type(bound)}"
        case "minimum":
            return f"must be at least {bound}"
        case "exclusiveMinimum":
            return f"must be above {bound}"
        case "maximum":
            return f"must be at most {bound}"
        case "exclusiveMaximum":
            return f"must be below {bound}"
        case "enum":
            return f"must be {_words(bound)}"
        case "pattern":
            return "must be a name of letters, digits, _ and -"
        case "maxLength":
            return f"must have at most {bound} characters"
        case "minItems":
            return f"must have at least {_count(bound)}"
        case "maxItems":
            return f"must have at most {_count(bound)}"
    raise AssertionError(f"the schema uses {error.validator}, which has no phrase")


def _as_scenario_error(document: Document, error: ValidationError) -> ScenarioError:
    path = _path(error)
    match error.validator:
        case "additionalProperties":
            known = [key for key in error.schema.get("properties", {}) if key not in error.instance]
            names = known + pattern_names(error.schema)
            return document.error(path, f"unknown key, {suggestion(str(path[-1]), names)}")
        case "required":
            return document.error(path, f"{_missing(error)} is missing")
        case "oneOf":
            return document.error(path, _alternatives(error))
        case "dependentRequired":
            return document.error(path, _dependents(error))
    if "propertyNames" in error.absolute_schema_path:
        return document.error((*path, error.instance), _expectation(error))
    if not path:
        return document.error(path, _expectation(error))
    return document.refusal(path, _expectation(error))


def first_error(document: Document, errors: list[ValidationError]) -> ScenarioError:
    """The finding to report first: an unknown key (often the cause of others), else the uppermost.

    Messages read ``file:line: key.path = value, must be ...``.
    """

    def rank(error: ValidationError) -> tuple[bool, int, int]:
        line = document.origin(_path(error)).rpartition(":")[2]
        return (error.validator != "additionalProperties", int(line) if line.isdigit() else 0, -len(_path(error)))

    return _as_scenario_error(document, min(errors, key=rank))
