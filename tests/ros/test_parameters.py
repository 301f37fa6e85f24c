"""The table of parameters: what is accepted, what it overrides, how it is described."""

from __future__ import annotations

import math
from typing import Any

import pytest

pytest.importorskip("rclpy")

from haul_ros.model.radio import CHANGEABLE
from haul_ros.ros.parameters import (
    ParameterError,
    check_given,
    parameter_rows,
    scenario_overrides,
    values_in_effect,
)
from haul_ros.scenario import load_scenario


def test_every_parameter_is_described_with_unit_range_and_read_only_where_it_is_so() -> None:
    descriptors = {name: row.descriptor() for name, row in parameter_rows(["slave_1"]).items()}
    assert all(d.name == name and d.description for name, d in descriptors.items())
    assert descriptors["dt"].description.endswith("[s]")
    assert descriptors["dt"].read_only
    assert not descriptors["real_time_factor"].read_only
    for field in CHANGEABLE:
        assert not descriptors[f"radio.slave_1.{field}"].read_only
    limits = descriptors["radio.slave_1.loss_probability"].floating_point_range[0]
    assert (limits.from_value, limits.to_value) == (0.0, 1.0)
    retries = descriptors["radio.slave_1.retries"].integer_range[0]
    assert (retries.from_value, retries.to_value) == (0, 16)
    assert "gamma" in descriptors["radio.slave_1.jitter_law"].additional_constraints
    assert descriptors["radio.slave_1.burst_length"].description.endswith("[s]")
    assert "zstd" in descriptors["record_compression"].additional_constraints


def test_a_whole_number_is_taken_where_a_decimal_one_is_meant() -> None:
    checked, _ = check_given({"real_time_factor": 0})
    value = checked["real_time_factor"]
    assert value == 0.0
    assert isinstance(value, float)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("dt", -0.001, r"parameter dt = -0.001, must be 1e-06 to 0.1 s"),
        ("dt", math.nan, r"parameter dt = nan, must be"),
        ("dt", True, r"parameter dt = True, must be a number"),
        ("publish_rate", math.inf, r"parameter publish_rate = inf, must be 0.1 to 10000 Hz"),
        ("initial_speed", 56.0, r"parameter initial_speed = 56.0, must be 0 to 55.5556 m/s"),
        ("real_time_factor", 1e-6, r"parameter real_time_factor = 1e-06, must be 0 or 0.001 to 1000"),
        ("real_time_factor", "fast", r"parameter real_time_factor = 'fast', must be a number"),
        ("scenario", 4, r"parameter scenario = 4, must be text"),
        ("publish_clock", 1, r"parameter publish_clock = 1, must be true or false"),
        ("record_compression", "gzip", r"parameter record_compression = 'gzip', must be one of zstd, lz4, none"),
        ("radio.slave_1.loss_probability", 1.5, r"parameter radio.slave_1.loss_probability = 1.5, must be 0 to 1"),
        ("radio.slave_1.retries", 17, r"parameter radio.slave_1.retries = 17, must be 0 to 16"),
        ("radio.slave_1.retries", 1.5, r"parameter radio.slave_1.retries = 1.5, must be a whole number"),
        ("radio.slave_1.retry_interval", 0.0, r"radio.slave_1.retry_interval = 0.0, must be 0.01 to 3600 s"),
        ("radio.slave_1.duplicate_probability", -0.1, r"duplicate_probability = -0.1, must be 0 to 1"),
        ("radio.slave_1.jitter_law", "cauchy", r"jitter_law = 'cauchy', must be one of uniform, exponential, normal"),
        ("radio.slave_1.fails", "both", r"radio.slave_1.fails = 'both', must be one of none, to_slave, from_slave"),
        ("scenaro", "x", r"parameter scenaro is unknown; did you mean scenario\?"),
        ("radio.slave_1.dely", 1.0, r"parameter radio.slave_1.dely is unknown; did you mean radio.slave_1.delay\?"),
        ("radio.default.delay", 1.0, r"radio.default.delay is unknown; did you mean radio.slave_1.delay\?"),
        ("radio.master.delay", 1.0, r"radio.master.delay is unknown; did you mean radio.slave_1.delay\?"),
        ("radio.frequency", 1.0, r"parameter radio.frequency is unknown"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(name: str, value: object, message: str) -> None:
    with pytest.raises(ParameterError, match=message) as refused:
        check_given({name: value})
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["update_rate", "publish_tf", "publish_frequency", "rt", "robot.radio.delay"])
def test_a_parameter_of_another_node_has_no_effect_and_is_told_of(name: str) -> None:
    checked, foreign = check_given({"dt": 0.002, name: [1, 2]})
    assert checked == {"dt": 0.002}
    assert list(foreign) == [name]
    assert foreign[name].startswith(f"parameter {name} is unknown and without effect here")


def test_what_is_told_of_it_has_the_parameter_that_is_most_like_it() -> None:
    _, foreign = check_given({"publish_tf": True})
    assert foreign["publish_tf"].endswith("; did you mean publish_rate?")


def test_parameters_override_the_scenario_in_its_own_units() -> None:
    given, _ = check_given(
        {"dt": 0.0005, "publish_rate": 100, "initial_speed": 10.0, "radio.slave_2.delay": 1.5, "record_path": "none"}
    )
    assert scenario_overrides(given) == {
        "time_step_ms": 0.5,
        "sample_rate_hz": 100.0,
        "initial_speed_kmh": 36.0,
        "radio.slave_2.delay_s": 1.5,
        "commands": [],
    }


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("delay", 0.5),
        ("jitter", 0.25),
        ("loss_probability", 0.125),
        ("connected", False),
        ("jitter_law", "gamma"),
        ("retries", 3),
        ("in_order", False),
        ("fails", "to_slave"),
    ],
)
def test_a_parameter_of_a_radio_link_is_a_change_of_that_field_alone(field: str, value: Any) -> None:
    row = parameter_rows(["slave_1", "slave_2"])[f"radio.slave_2.{field}"]
    change = row.link_change(value)
    assert change is not None
    assert (change.slave, change.values()) == ("slave_2", {field: value})


def test_other_parameters_change_no_link() -> None:
    rows = parameter_rows(["slave_1"]).values()
    assert {row.name for row in rows if row.link_change(0.0) is None} == {
        name for name in parameter_rows([]) if not name.startswith("radio.")
    }


def test_the_timed_commands_of_the_scenario_stay_only_when_asked_for() -> None:
    assert scenario_overrides({"scenario_commands": True}) == {}
    assert scenario_overrides({"scenario_commands": False}) == {"commands": []}


def test_what_was_not_given_has_the_value_of_the_scenario() -> None:
    scenario = load_scenario("daqin_1_2_1", {"radio.slave_3.delay_s": 2.0, "time_step_ms": 0.5})
    values = values_in_effect(scenario, {"publish_rate": 50.0, "record_path": "run.mcap"})
    assert values["dt"] == 0.0005
    assert values["initial_speed"] == pytest.approx(80 / 3.6)
    assert values["radio.slave_3.delay"] == 2.0
    assert values["radio.slave_1.connected"] is True
    assert (values["radio.slave_1.retries"], values["radio.slave_1.jitter_law"]) == (0, "uniform")
    assert values["record_path"] == "run.mcap"
    assert values["real_time_factor"] == 1.0
    assert set(values) == set(parameter_rows(["slave_1", "slave_2", "slave_3"]))
