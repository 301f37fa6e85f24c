"""Parameter file, page of parameters and that of the node say what the table says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from haul_ros.ros.parameter_documents import parameter_file, parameter_page
from haul_ros.ros.parameters import parameter_rows

ROOT = Path(__file__).parents[2]
ROWS = parameter_rows(["slave_1"])


@pytest.mark.parametrize(
    ("path", "text"), [("config/train_node.yaml", parameter_file()), ("docs/parameters.md", parameter_page())]
)
def test_the_file_is_the_one_that_the_table_makes(path: str, text: str) -> None:
    assert (ROOT / path).read_text("utf-8") == text, "run: python -m haul_ros.ros.parameter_documents"


def test_the_parameter_file_has_every_default_as_ros_reads_it() -> None:
    values = YAML(typ="safe").load(parameter_file())["/**"]["ros__parameters"]
    assert values == {name: row.default for name, row in ROWS.items() if row.default is not None}
    assert {name: type(value) for name, value in values.items()} == {name: ROWS[name].kind for name in values}


def test_the_page_has_every_parameter() -> None:
    named = re.findall(r"^\| `(\S+)` \|", parameter_page(), re.M)
    assert named == [name.replace(".slave_1.", ".<slave>.") for name in ROWS]


def test_the_page_of_the_node_names_every_parameter_and_which_are_read_only() -> None:
    table = (ROOT / "docs/node.md").read_text("utf-8").split("\n| parameter | | meaning |\n")[1].split("\n\n")[0]
    read_only: dict[str, bool] = {}
    for names, mark in re.findall(r"^\| (`.*?) \| (read-only|) ?\|", table, re.M):
        # `radio.<slave>.delay`, `.connected`
        every = re.findall(r"`(\S+?)`", names)
        group = every[0].rpartition(".")[0]
        for name in every:
            full = group + name if name.startswith(".") else name
            read_only[full.replace("<slave>", "slave_1")] = mark == "read-only"
    assert read_only == {name: row.read_only for name, row in ROWS.items()}
