"""The kernel's data: every quantity has a name and a unit, nobody writes parameters, names are views of the rows."""

from __future__ import annotations

import ast
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from haul_ros.physics.kernel import air_data, data
from haul_ros.physics.kernel import blocks as memory
from haul_ros.physics.kernel.advance import advance
from haul_ros.physics.kernel.blocks import LAYOUT, Train
from tests.physics.physics_cases import linear_gear, model, train_of, vehicle


def _fields_with_docstrings() -> dict[str, str]:
    """Text below each field of the named tuples, by ``Class.field``; an empty one where there is none."""
    found = {}
    sources = [Path(str(module.__file__)).read_text("utf-8") for module in (data, air_data)]
    for node in [node for source in sources for node in ast.parse(source).body]:
        if isinstance(node, ast.ClassDef):
            for line, below in zip(node.body, [*node.body[1:], None], strict=True):
                if isinstance(line, ast.AnnAssign):
                    assert isinstance(line.target, ast.Name)
                    text = (
                        below.value.value
                        if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant)
                        else ""
                    )
                    found[f"{node.name}.{line.target.id}"] = str(text)
    return found


def test_every_quantity_tells_its_unit() -> None:
    fields = _fields_with_docstrings()
    assert len(fields) > 90
    without = [name for name, text in fields.items() if not re.search(r"\[[^\]]+\]", text)]
    assert without == []


def test_every_kind_of_data_has_its_rows_once() -> None:
    kinds = [kind for block in LAYOUT.values() for kind in block]
    named = [
        kind
        for module in (data, air_data)
        for kind in vars(module).values()
        if isinstance(kind, type) and hasattr(kind, "_fields")
    ]
    assert {kind.__name__ for kind in kinds} == {kind.__name__ for kind in named}
    assert len(kinds) == len(Train._fields) - 6  # settings, counters, waves, air, its account, mass_index: no rows


@pytest.mark.interpreted
def test_python_and_the_kernel_name_the_same_rows() -> None:
    train = model(train_of([vehicle()] * 4, linear_gear()), 10.0)
    blocks = train._blocks
    of_block = [block for block, kinds in LAYOUT.items() for _ in kinds]
    groups: tuple[Any, ...] = train.train[6:]
    for name, block, group in zip(Train._fields[6:], of_block, groups, strict=True):
        rows_of = getattr(memory, f"{name}_of")
        rows = getattr(rows_of, "py_func", rows_of)(getattr(blocks, block))
        assert type(rows) is type(group)
        for field, ours, theirs in zip(group._fields, group, rows, strict=True):
            assert ours.__array_interface__ == theirs.__array_interface__, f"{name}.{field}"


@pytest.mark.interpreted
@pytest.mark.parametrize("name", ["vehicle_parameters", "mass_parameters", "gear_parameters", "hinges", "members"])
def test_parameters_cannot_be_written_after_assembly(name: str) -> None:
    for row in getattr(model(train_of([vehicle()] * 3, linear_gear()), 10.0).train, name):
        with pytest.raises(ValueError, match="read-only"):
            row[0] = 1.0


def test_the_rows_of_a_train_do_not_overlap() -> None:
    train = model(train_of([vehicle()] * 4, linear_gear()), 10.0).train
    arrays = [row for group in train[6:] for row in group if row.size]
    spans = sorted((row.__array_interface__["data"][0], row.nbytes) for row in arrays)
    assert all(start + size <= after for (start, size), (after, _) in pairwise(spans))


@pytest.mark.interpreted
def test_no_step_is_no_change() -> None:
    train = model(train_of([vehicle()] * 4, linear_gear(3e7, 9e6)), [10.0, 11.0, 10.0, 9.0])
    train.advance(50)
    before = [block.copy() for block in train._blocks]
    advance(train._blocks, 0)
    for old, new in zip(before, train._blocks, strict=True):
        np.testing.assert_array_equal(old, new)
