"""The parameters of a node declared from the table, and the scenario that they lead to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from haul_ros.messages.channels import ChannelTable
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.scenario import Scenario
from haul_ros.ros.parameters import (
    DEFAULT_SCENARIO,
    ParameterError,
    ParameterRow,
    Value,
    check_given,
    parameter_rows,
    scenario_overrides,
    values_in_effect,
)
from haul_ros.ros.qos_overrides import QOS_OVERRIDES, check_qos, qos_rows, with_qos
from haul_ros.scenario import load_scenario

_OF_RCLPY = ("use_sim_time", "start_type_description_service", QOS_OVERRIDES)
"""Names, or beginnings of names, of the parameters that rclpy declares for itself."""


class NodeSettings:
    """What the user asked for. Values that the scenario has too are its own unless they were given.

    The node has to be made with ``automatically_declare_parameters_from_overrides``: so an unknown
    name is noticed, which is warned of, and a whole number accepted where a decimal one is meant.

    Raises
    ------
    HaulError
        Misspelt parameter, unusable value, or a scenario that cannot be loaded.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._given, foreign = check_given(_given(node))
        for name, warning in foreign.items():
            cast(Any, node).get_logger().warning(warning)
            node.undeclare_parameter(name)
        self.scenario = self._load(self._given)
        self._rows = parameter_rows(self.scenario.radio)
        self._declare(self._rows, values_in_effect(self.scenario, self._given))
        node.add_on_set_parameters_callback(self._check)

    def with_qos_overrides(self, table: ChannelTable) -> ChannelTable:
        """Declare what of the quality of service may be overridden; the table with what was.

        Raises
        ------
        ParameterError
            Something else was to be, or to another value.
        """
        declared: Mapping[str, Any] = self._node.get_parameters_by_prefix("")
        given = {name: item.value for name, item in declared.items() if name.startswith(QOS_OVERRIDES)}
        values = check_qos(given, table)
        self._declare(qos_rows(table), values)
        return with_qos(values, table)

    def _declare(self, rows: Mapping[str, ParameterRow], values: Mapping[str, Value]) -> None:
        for name, value in values.items():
            if self._node.has_parameter(name):
                self._node.undeclare_parameter(name)
            self._node.declare_parameter(name, value, rows[name].descriptor(), ignore_override=True)

    def number(self, name: str) -> float:
        """Present value of a parameter that is a number."""
        return float(self._node.get_parameter(name).value)

    def text(self, name: str) -> str:
        """Present value of a parameter that is text."""
        return str(self._node.get_parameter(name).value)

    def flag(self, name: str) -> bool:
        """Present value of a parameter that is true or false."""
        return bool(self._node.get_parameter(name).value)

    def link_change(self, parameter: Parameter) -> RadioLinkChange | None:
        """What the new value of a parameter changes of a radio link; None if it is no parameter of a link."""
        row = self._rows.get(parameter.name)
        return row.link_change(parameter.value) if row else None

    def scenario_again(self) -> Scenario:
        """The scenario for a new run of the same train, with the present values of the parameters.

        Raises
        ------
        HaulError
            The scenario file cannot be read any more, or has become another train.
        """
        present = {name: self._node.get_parameter(name).value for name, row in self._rows.items() if not row.read_only}
        scenario = self._load({**self._given, **present})
        if scenario.consist != self.scenario.consist:
            raise ParameterError(f"scenario {self.scenario.name} has become another train; restart the node for it")
        return scenario

    def _load(self, values: Mapping[str, Value]) -> Scenario:
        return load_scenario(str(values.get("scenario", DEFAULT_SCENARIO)), scenario_overrides(values))

    def _check(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        try:
            for parameter in parameters:
                if parameter.name in self._rows:
                    self._rows[parameter.name].check(parameter.value)
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)


def _given(node: Node) -> dict[str, object]:
    declared: Mapping[str, Any] = node.get_parameters_by_prefix("")
    return {name: parameter.value for name, parameter in declared.items() if not name.startswith(_OF_RCLPY)}
