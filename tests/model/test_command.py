"""Values of commands that mean something, and refusals of those that do not."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind


@settings(deadline=None)
@given(kind=st.sampled_from([CommandKind.BRAKE, CommandKind.EMERGENCY]), value=st.floats())
def test_brakes_take_0_to_1_and_nothing_else(kind: CommandKind, value: float) -> None:
    command = Command("slave_2", kind, value)
    if math.isfinite(value) and 0.0 <= value <= 1.0:
        command.check()
    else:
        with pytest.raises(CommandError, match=rf"^slave_2: {kind.value} = .*must be") as refusal:
            command.check()
        assert "\n" not in str(refusal.value)


@settings(deadline=None)
@given(value=st.floats())
def test_traction_takes_any_finite_force_that_does_not_pull_backwards(value: float) -> None:
    command = Command("master", CommandKind.TRACTION, value)
    if math.isfinite(value) and value >= 0.0:
        command.check()
    else:
        with pytest.raises(CommandError, match=r"^master: traction = "):
            command.check()
