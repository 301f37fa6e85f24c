"""The launch file's arguments are parameters of the node; where there is launch, it declares and describes them."""

from __future__ import annotations

import ast
import runpy
from pathlib import Path

import pytest

from haul_ros.ros.parameters import parameter_rows

LAUNCH_FILE = Path(__file__).parents[2] / "launch/train.launch.py"
OF_LAUNCH = {"namespace", "node_name", "params_file", "log_level", "bag"}
OF_ROS = {"use_sim_time": "bool"}
"""A parameter of every node."""


def parameters_of_the_launch_file() -> dict[str, str]:
    """Name of the type of each argument that becomes a parameter."""
    for statement in ast.parse(LAUNCH_FILE.read_text("utf-8")).body:
        if isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]) == "NODE_PARAMETERS":
            assert isinstance(statement.value, ast.Dict)
            names = [ast.literal_eval(key) for key in statement.value.keys if key]
            return dict(zip(names, [ast.unparse(value.elts[0]) for value in statement.value.values], strict=True))  # type: ignore[attr-defined]
    raise AssertionError("no NODE_PARAMETERS")


def test_arguments_that_become_parameters_are_those_of_the_node_by_name_and_type() -> None:
    rows = {name: row.kind.__name__ for name, row in parameter_rows([]).items()}
    found = parameters_of_the_launch_file()
    assert found.items() <= (rows | OF_ROS).items()
    assert {"scenario", "record_path", "record_compression", "publish_clock", "use_sim_time"} <= found.keys()


def test_every_argument_is_declared_and_described() -> None:
    pytest.importorskip("launch_ros.actions")  # in no Python package
    sources = pytest.importorskip("launch.launch_description_sources")
    description = sources.get_launch_description_from_python_launch_file(str(LAUNCH_FILE))
    arguments = {argument.name: argument.description for argument in description.get_launch_arguments()}
    assert arguments.keys() == OF_LAUNCH | parameters_of_the_launch_file().keys()
    assert all(arguments.values())


def test_several_trains_are_one_launch_of_the_first_file_each() -> None:
    pytest.importorskip("launch_ros.actions")
    sources = pytest.importorskip("launch.launch_description_sources")
    several = LAUNCH_FILE.with_name("trains.launch.py")
    description = sources.get_launch_description_from_python_launch_file(str(several))
    assert [argument.name for argument in description.get_launch_arguments()] == ["trains", "record", "log_level"]
    module = runpy.run_path(str(several))
    assert module["namespaces"]("a=daqin_1_2_1, yard/b=my.yaml") == {"a": "daqin_1_2_1", "yard/b": "my.yaml"}
    for wrong in ("", "a", "a=", "=x", "a=x,a=y", "a=x,"):
        with pytest.raises(RuntimeError, match="expected NAMESPACE=SCENARIO"):
            module["namespaces"](wrong)
