"""YAML 1.2 text to a document with line numbers, and back."""

from __future__ import annotations

import io
import re
import warnings
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, ReusedAnchorWarning, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.representer import SafeRepresenter

from haul_ros.errors import ScenarioError
from haul_ros.scenario.document import Document, KeyPath, dotted
from haul_ros.scenario.text_file import MOST_BYTES, read_text

MOST_VALUES = 50_000
"""Most values and keys of a document: some 150 MB of memory while it is read."""
MOST_LEVELS = 100
"""Most values inside one another."""
_MOST_BITS = 10_000
"""Of a whole number."""
_TOO_MANY = f"more than {MOST_VALUES} values and keys"


def read_yaml(path: Path) -> Document:
    """Read a file.

    Raises
    ------
    FileNotFoundError, IsADirectoryError, ScenarioError
        As for `read_text`, or it is not YAML, or a key occurs twice.
    """
    return parse_yaml(read_text(path, "YAML"), str(path))


class _BoundedComposer(Composer):
    """Ends a document of too many values before they fill the memory."""

    composed = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """One value, or key, with all inside it."""
        self.composed += 1
        if self.composed > MOST_VALUES:
            raise YAMLError(_TOO_MANY)
        return super().compose_node(parent, index)


def _check_size(top: Node) -> None:
    """Refuse what is too large or too deep with all aliases written out; YAMLError."""
    sizes: dict[int, int] = {}

    def size(node: Node, depth: int) -> int:
        if depth > MOST_LEVELS:
            raise YAMLError("nested too deeply, or inside itself")
        if id(node) not in sizes:
            match node:
                case MappingNode():
                    inside = [child for pair in node.value for child in pair]
                case SequenceNode():
                    inside = node.value
                case _:
                    inside = []
            sizes[id(node)] = 1 + sum(size(child, depth + 1) for child in inside)
            if sizes[id(node)] > MOST_VALUES:
                raise YAMLError(_TOO_MANY)
        return sizes[id(node)]

    size(top, 0)


def parse_yaml(text: str, label: str) -> Document:
    """Parse the text of one YAML document; ``label`` names it in messages.

    Raises
    ------
    ScenarioError
        It is not YAML, or a key occurs twice or is not text, or there are more than `MOST_VALUES` values in it or
        more than `MOST_LEVELS` inside one another, aliases written out.
    """
    if len(text) > MOST_BYTES:  # it may come from a recording or a command line
        raise ScenarioError(f"{label}: more than {MOST_BYTES // 2**20} MiB, expected YAML of less")
    yaml = YAML(typ="safe", pure=True)
    yaml.Composer = _BoundedComposer
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ReusedAnchorWarning)  # the newest counts, as YAML has it
            node = yaml.compose(text)
        if node is None:
            return Document(label, None)
        _check_size(node)
        # The constructor checks for duplicate keys and merges `<<` into the nodes, before lines are taken.
        value = yaml.constructor.construct_document(node)
        document = Document(label, value)
        document.data = _locate(document, node, value, ())
    except MarkedYAMLError as error:
        line = f":{error.problem_mark.line + 1}" if error.problem_mark else ""
        problem = " ".join(str(error.problem or error.context).split())
        raise ScenarioError(f"{label}{line}: not valid YAML: {problem}") from error
    except YAMLError as error:
        raise ScenarioError(f"{label}: not a YAML file: {' '.join(str(error).split())}") from error
    except (ValueError, KeyError) as error:
        # From the constructor, on a scalar that looks like a number or a date, or is tagged so, and is none.
        raise ScenarioError(f"{label}: not valid YAML: a value is not what its form says: {error}") from error
    except RecursionError as error:
        raise ScenarioError(f"{label}: not usable: nested too deeply, or inside itself") from error
    return document


def _locate(document: Document, node: Node, value: Any, path: KeyPath) -> Any:
    """Note the line of everything below a node; returns the value rebuilt without shared (aliased) parts."""
    if path:
        document.origins.setdefault(path, f"{document.label}:{node.start_mark.line + 1}")
    if isinstance(node, ScalarNode):
        # Python writes no such number in a message; decimal ones of its limit it does not even read
        if isinstance(value, int) and value.bit_length() > _MOST_BITS:
            raise document.error(path, f"a whole number of more than {_MOST_BITS} bits is not used here")
        return value
    if isinstance(node, MappingNode) and isinstance(value, dict):
        children = {}
        for key_node, child in node.value:
            line = f"{document.label}:{key_node.start_mark.line + 1}"
            if not isinstance(key_node, ScalarNode) or key_node.value not in value:
                key = key_node.value if isinstance(key_node, ScalarNode) else "?"
                raise ScenarioError(f"{line}: {dotted((*path, key))}: a key must be text")
            document.origins[(*path, key_node.value)] = line
            children[key_node.value] = child
        return {key: _locate(document, children[key], child, (*path, key)) for key, child in value.items()}
    if isinstance(node, SequenceNode) and isinstance(value, list):
        return [
            _locate(document, child_node, child, (*path, index))
            for index, (child_node, child) in enumerate(zip(node.value, value, strict=True))
        ]
    raise document.error(path, f"the tag {node.tag} is not used here")


def check_values(document: Document) -> None:
    """Refuse a document of which the text that `dump_yaml` writes would be too large to be read.

    Raises
    ------
    ScenarioError
        It holds more than `MOST_VALUES` values and keys.
    """
    if (count := _count(document.data)) > MOST_VALUES:
        raise document.error((), f"{count} values and keys with all that it uses, expected at most {MOST_VALUES}")


def _count(data: Any) -> int:
    if isinstance(data, dict):
        return 1 + sum(1 + _count(value) for value in data.values())
    return 1 + sum(map(_count, data)) if isinstance(data, list) else 1


_PLAIN = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_./ -]*")


class _Representer(SafeRepresenter):
    """Quotes all text but simple words: some plain text that ruamel.yaml writes, it cannot read (``:0``)."""

    def represent_text(self, text: str) -> Any:
        """The scalar node of a text."""
        style = None if _PLAIN.fullmatch(text) else '"'
        return self.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Representer.add_representer(str, _Representer.represent_text)


def dump_yaml(data: Any) -> str:
    """YAML text that gives the same data again, in the same order."""
    yaml = YAML(typ="safe", pure=True)
    yaml.Representer = _Representer
    yaml.default_flow_style = None  # the innermost collections on one line each
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 1_000_000
    stream = io.StringIO()
    yaml.dump(data, stream)
    return stream.getvalue()
