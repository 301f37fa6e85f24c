"""The public face: the names that stay, listed once for users, for the import and for type checkers."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import haul_ros


def _imported_for_type_checkers() -> set[str]:
    tree = ast.parse(Path(haul_ros.__file__).read_text("utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    return {alias.name for line in block.body if isinstance(line, ast.ImportFrom) for alias in line.names}


def test_every_name_is_there_for_users_and_for_type_checkers() -> None:
    names = set(haul_ros.__all__) - {"__version__"}
    assert set(haul_ros._HOME) == names == _imported_for_type_checkers()
    assert dir(haul_ros) == sorted(haul_ros.__all__)
    for name in names:
        found = getattr(haul_ros, name)
        assert found.__name__ == name
        assert inspect.getdoc(found), f"{name} has no docstring"


def test_an_unknown_name_is_told_as_python_does() -> None:
    with pytest.raises(AttributeError, match="module 'haul_ros' has no attribute 'load_scenarios'"):
        haul_ros.load_scenarios  # noqa: B018


def test_the_import_alone_loads_nothing_heavy() -> None:
    code = "import sys, haul_ros; print(*sorted({'numpy', 'numba', 'matplotlib', 'mcap', 'rclpy'} & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == ""


def test_reading_a_scenario_loads_no_compiler() -> None:
    code = "import sys, haul_ros.scenario; print('numba' in sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["False"]
