"""The node's parameters as data: name, type, unit, range, whether they may change, and what they override."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from haul_ros.errors import HaulError
from haul_ros.model.radio import (
    FAILURES,
    JITTER_LAWS,
    LONGEST_DELAY,
    MOST_RETRIES,
    SHORTEST_RETRY_INTERVAL,
    RadioLinkChange,
)
from haul_ros.model.recording_plan import UNITS
from haul_ros.model.scenario import Scenario
from haul_ros.ros.spelling import is_slip, nearest
from haul_ros.scenario.recording import COARSEST, FINEST, ROUNDING_KEYS
from haul_ros.units import kmh_to_mps, mps_to_kmh

if TYPE_CHECKING:
    from rcl_interfaces.msg import ParameterDescriptor

Value = bool | float | int | str

DEFAULT_SCENARIO = "daqin_1_2_1"
NO_RECORDING = "none"
MOST_TEXT = 4096
"""Longest text: that of a path."""

_TYPE_NAMES = MappingProxyType({bool: "true or false", float: "a number", int: "a whole number", str: "text"})


class ParameterError(HaulError):
    """A parameter that does not exist, or whose value cannot be used."""


@dataclass(frozen=True, slots=True)
class ParameterRow:
    """One parameter of the node.

    ``default`` None: the scenario's own value. ``scenario_key`` is the scenario entry that the
    parameter overrides ("": none) and ``to_scenario`` turns its value into that entry's unit.
    A number is 0 or at least ``least_above_zero`` where that is given. ``slave`` and ``link_field`` say of which
    radio link it is which field ("": of none).
    """

    name: str
    kind: type[bool] | type[float] | type[int] | type[str]
    description: str
    default: Value | None = None
    unit: str = ""
    minimum: float = -math.inf
    maximum: float = math.inf
    least_above_zero: float = 0.0
    choices: tuple[str, ...] = ()
    read_only: bool = True
    scenario_key: str = ""
    to_scenario: Callable[[Value], object] = lambda value: value
    slave: str = ""
    link_field: str = ""

    def check(self, value: object) -> Value:
        """The value as this parameter's type; a whole number will do where a decimal one is meant.

        Raises
        ------
        ParameterError
            Wrong type, NaN, infinite, out of range, too long, or none of the choices.
        """
        if self.kind is float and isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**63:
            value = float(value)
        if not isinstance(value, self.kind) or (self.kind is int and isinstance(value, bool)):
            raise ParameterError(f"parameter {self.name} = {value!r:.80}, must be {_TYPE_NAMES[self.kind]}")
        if isinstance(value, (float, int)) and not isinstance(value, bool) and not self._in_range(value):
            raise ParameterError(f"parameter {self.name} = {value}, must be {self._expected_number()}")
        if isinstance(value, str) and len(value) > MOST_TEXT:
            raise ParameterError(
                f"parameter {self.name} = {value!r:.80}, must be text of at most {MOST_TEXT} characters"
            )
        if isinstance(value, str) and self.choices and value not in self.choices:
            raise ParameterError(f"parameter {self.name} = {value!r}, must be one of {', '.join(self.choices)}")
        return value

    def _in_range(self, value: float) -> bool:
        return self.minimum <= value <= self.maximum and not 0.0 < value < self.least_above_zero

    def _expected_number(self) -> str:
        zero = f"0 or {self.least_above_zero:g}" if self.least_above_zero else f"{self.minimum:g}"
        return f"{zero} to {self.maximum:g} {self.unit}".rstrip()

    def link_change(self, value: Value) -> RadioLinkChange | None:
        """The change of a radio link to a new value of this parameter; None if it is of no link."""
        values: dict[str, Any] = {self.link_field: value}
        return RadioLinkChange(self.slave, **values) if self.slave else None

    def summary(self) -> str:
        """Description, unit, what is accepted and the default, in a line."""
        default = "" if self.default is None else f"; default: {json.dumps(self.default)}"
        return f"{self.described()}: {self.accepted()}{default}"

    def accepted(self) -> str:
        """What values are accepted, in words."""
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        if self.kind is str:
            return f"text of at most {MOST_TEXT} characters"
        if self.kind is bool:
            return _TYPE_NAMES[bool]
        return f"{_TYPE_NAMES[self.kind]}, {self._expected_number()}"

    def described(self) -> str:
        """What it is, with its unit."""
        return f"{self.description} [{self.unit}]" if self.unit else self.description

    def descriptor(self) -> ParameterDescriptor:
        """What ``ros2 param describe`` shows; the range is also enforced by ROS."""
        from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor  # needs ROS

        limits = [FloatingPointRange(from_value=self.minimum, to_value=self.maximum)] if self.kind is float else []
        whole = [IntegerRange(from_value=int(self.minimum), to_value=int(self.maximum))] if self.kind is int else []
        return ParameterDescriptor(
            name=self.name,
            description=self.described(),
            additional_constraints=self.accepted(),
            read_only=self.read_only,
            floating_point_range=limits,
            integer_range=whole,
        )


def _times(factor: float, value: Value) -> float:
    return float(value) * factor


_TRAIN_ROWS = (
    ParameterRow("scenario", str, "name of a shipped scenario, or path of a scenario file", DEFAULT_SCENARIO),
    ParameterRow(
        "dt",
        float,
        "time step of the integration; default: the scenario's",
        unit="s",
        minimum=1e-6,
        maximum=0.1,
        scenario_key="time_step_ms",
        to_scenario=lambda value: float(value) * 1e3,
    ),
    ParameterRow(
        "publish_rate",
        float,
        "rate of ~/couplers, ~/vehicles and ~/brake_cylinder_pressure in simulation time, and of taking commands; "
        "default: the scenario's",
        unit="Hz",
        minimum=0.1,
        maximum=10_000.0,
        scenario_key="sample_rate_hz",
    ),
    ParameterRow(
        "initial_speed",
        float,
        "speed of the train at the start; default: the scenario's",
        unit="m/s",
        minimum=0.0,
        maximum=kmh_to_mps(200.0),
        scenario_key="initial_speed_kmh",
        to_scenario=lambda value: mps_to_kmh(float(value)),
    ),
    ParameterRow("scenario_commands", bool, "play the scenario's own timed commands as well", False),
    ParameterRow(
        "real_time_factor",
        float,
        "simulated over wall time: 1 real time, 0 as fast as possible",
        1.0,
        minimum=0.0,
        maximum=1000.0,
        least_above_zero=0.001,
        read_only=False,
    ),
    ParameterRow(
        "record_path",
        str,
        f"file to record to; empty: <scenario>_<UTC time>.mcap in the current folder; {NO_RECORDING}: no recording",
        "",
    ),
    ParameterRow(
        "record_rate",
        float,
        "rate of recorded samples in simulation time, each of them a published one; default: the scenario's",
        unit="Hz",
        minimum=0.001,
        maximum=10_000.0,
        scenario_key="recording.rate_hz",
    ),
    ParameterRow("record_compression", str, "compression of the recording", "zstd", choices=("zstd", "lz4", "none")),
    ParameterRow(
        "reset_interval",
        float,
        "shortest wall time between two resets; an earlier one is refused",
        0.5,
        unit="s",
        minimum=0.0,
        maximum=86400.0,
        read_only=False,
    ),
    ParameterRow(
        "max_recordings",
        int,
        "most files that this node records to, one for each reset and the first; further resets are refused",
        1000,
        minimum=1,
        maximum=1_000_000,
        read_only=False,
    ),
    ParameterRow("publish_clock", bool, "publish the simulation time on /clock", False),
    ParameterRow(
        "clock_rate",
        float,
        "rate of /clock in simulation time, that of the samples at most; 0: with every sample",
        0.0,
        unit="Hz",
        minimum=0.0,
        maximum=10_000.0,
        least_above_zero=0.001,
    ),
    ParameterRow(
        "force_image_rate",
        float,
        "rate in simulation time of ~/force_image, the last 300 periods of all couplers as a picture; 0: none",
        0.0,
        unit="Hz",
        minimum=0.0,
        maximum=50.0,
        least_above_zero=0.001,
    ),
    ParameterRow(
        "train_markers_rate",
        float,
        "rate in simulation time of ~/train_markers, the train as boxes coloured by force; 0: none",
        0.0,
        unit="Hz",
        minimum=0.0,
        maximum=50.0,
        least_above_zero=0.001,
    ),
    ParameterRow(
        "picture_force",
        float,
        "coupler force of the darkest colours of ~/force_image and ~/train_markers",
        1e6,
        unit="N",
        minimum=1e3,
        maximum=1e8,
        read_only=False,
    ),
)

_ROUNDING_ROWS = tuple(
    ParameterRow(
        f"rounding.{quantity}",
        float,
        f"{quantity.replace('_', ' ')} is published and recorded to the power of two not above this; 0: all bits",
        unit=UNITS[quantity],
        minimum=0.0,
        maximum=COARSEST / factor,
        least_above_zero=FINEST / 2.0 / factor,
        scenario_key=f"recording.rounding.{key}",
        to_scenario=partial(_times, factor),
    )
    for quantity, (key, factor) in ROUNDING_KEYS.items()
)

_LINK_ROWS = (
    ParameterRow(
        "delay",
        float,
        "time from a command at the master to its effect at this slave, from the next command on",
        unit="s",
        minimum=0.0,
        maximum=LONGEST_DELAY,
        read_only=False,
        scenario_key="delay_s",
    ),
    ParameterRow(
        "jitter",
        float,
        "of the random addition to the delay, from the next command on: the largest, or as jitter_law says",
        unit="s",
        minimum=0.0,
        maximum=LONGEST_DELAY,
        read_only=False,
        scenario_key="jitter_s",
    ),
    ParameterRow(
        "loss_probability",
        float,
        "probability that a telegram to this slave is lost, from the next command on",
        minimum=0.0,
        maximum=1.0,
        read_only=False,
        scenario_key="loss_probability",
    ),
    ParameterRow(
        "connected",
        bool,
        "whether anything arrives over this link, from the next command on",
        read_only=False,
        scenario_key="connected",
    ),
    ParameterRow(
        "jitter_law",
        str,
        "distribution of the random addition to the delay, jitter being its largest value (uniform), mean "
        "(exponential, gamma), standard deviation (normal) or unit (empirical, by the scenario's quantiles); "
        "from the next command on",
        choices=JITTER_LAWS,
        read_only=False,
        scenario_key="jitter_law",
    ),
    ParameterRow(
        "retries",
        int,
        "how often a telegram is sent again that is not acknowledged; 0: there are no acknowledgements",
        minimum=0,
        maximum=MOST_RETRIES,
        read_only=False,
        scenario_key="retries",
    ),
    ParameterRow(
        "retry_interval",
        float,
        "time from one attempt to the next, from the next attempt on",
        unit="s",
        minimum=SHORTEST_RETRY_INTERVAL,
        maximum=LONGEST_DELAY,
        read_only=False,
        scenario_key="retry_interval_s",
    ),
    ParameterRow(
        "duplicate_probability",
        float,
        "probability that a telegram that arrives does so twice, from the next command on",
        minimum=0.0,
        maximum=1.0,
        read_only=False,
        scenario_key="duplicate_probability",
    ),
    ParameterRow(
        "in_order",
        bool,
        "whether telegrams keep their order; where one may overtake another, the older one is ignored",
        read_only=False,
        scenario_key="in_order",
    ),
    ParameterRow(
        "fails",
        str,
        "direction of the link that is dead; from_slave: commands arrive, acknowledgements do not",
        choices=FAILURES,
        read_only=False,
        scenario_key="fails",
    ),
    ParameterRow(
        "burst_length",
        float,
        "mean length of bursts of losses; 0: none",
        unit="s",
        minimum=0.0,
        maximum=LONGEST_DELAY,
        read_only=False,
        scenario_key="burst_length_s",
    ),
    ParameterRow(
        "burst_spacing",
        float,
        "mean time between two bursts",
        unit="s",
        minimum=SHORTEST_RETRY_INTERVAL,
        maximum=LONGEST_DELAY,
        read_only=False,
        scenario_key="burst_spacing_s",
    ),
    ParameterRow(
        "burst_loss_probability",
        float,
        "probability that a telegram is lost in a burst",
        minimum=0.0,
        maximum=1.0,
        read_only=False,
        scenario_key="burst_loss_probability",
    ),
)


def parameter_rows(slaves: Iterable[str]) -> dict[str, ParameterRow]:
    """All parameters of a node whose train has these slave locomotives, by name."""
    of_links = (
        replace(
            row,
            name=f"radio.{slave}.{row.name}",
            scenario_key=f"radio.{slave}.{row.scenario_key}",
            slave=slave,
            link_field=row.name,
        )
        for slave in slaves
        for row in _LINK_ROWS
    )
    return {row.name: row for row in (*_TRAIN_ROWS, *_ROUNDING_ROWS, *of_links)}


def _rows_for(names: Iterable[str]) -> dict[str, ParameterRow]:
    """All parameters of a node whose train has the slaves that these names of parameters speak of."""
    parts = (name.split(".") for name in names)
    of_links = (part[1] for part in parts if len(part) == 3 and part[0] == "radio")
    return parameter_rows(sorted({slave for slave in of_links if slave.startswith("slave_")}))  # no radio.default


def check_given(given: Mapping[str, object]) -> tuple[dict[str, Value], dict[str, str]]:
    """Check what the user gave, before there is a scenario.

    Returns the values, and what is to be said of each name that is another node's: parameter files are shared.

    Raises
    ------
    ParameterError
        A known name misspelt, an unknown one of a radio link, or a value that its row refuses.
    """
    rows = _rows_for(given)
    known = [*rows, *parameter_rows(["slave_1"])]
    foreign: dict[str, str] = {}
    for name in given:
        if name in rows:
            continue
        near = nearest(name, known)
        hint = f"; did you mean {near}?" if near else ""
        if name.startswith("radio.") or is_slip(name, known):
            raise ParameterError(f"parameter {name} is unknown{hint}")
        foreign[name] = f"parameter {name} is unknown and without effect here{hint}"
    return {name: rows[name].check(value) for name, value in given.items() if name not in foreign}, foreign


def scenario_overrides(given: Mapping[str, Value]) -> dict[str, object]:
    """Scenario entries that checked parameters replace, by their dotted keys.

    Without ``scenario_commands`` the timed commands are replaced by none, so that the resolved
    scenario is what the node really runs.
    """
    rows = _rows_for(given)
    overrides = {rows[n].scenario_key: rows[n].to_scenario(v) for n, v in given.items() if rows[n].scenario_key}
    if not given.get("scenario_commands", False):
        overrides["commands"] = []
    return overrides


def values_in_effect(scenario: Scenario, given: Mapping[str, Value]) -> dict[str, Value]:
    """Every parameter's value for a loaded scenario: what was given, else the scenario's own or the default.

    Raises
    ------
    ParameterError
        The scenario's own value is outside the parameter's range.
    """
    own: dict[str, Value] = {
        "dt": scenario.time_step,
        "publish_rate": scenario.sample_rate,
        "initial_speed": scenario.initial_speed,
        "record_rate": scenario.record_rate,
    }
    own |= {f"rounding.{name}": getattr(scenario.recording.rounding, name) for name in UNITS}
    rows = parameter_rows(scenario.radio)
    own |= {row.name: getattr(scenario.radio[row.slave], row.link_field) for row in rows.values() if row.slave}
    defaults = {name: row.default for name, row in rows.items() if row.default is not None}
    return {name: rows[name].check(value) for name, value in {**defaults, **own, **given}.items()}
