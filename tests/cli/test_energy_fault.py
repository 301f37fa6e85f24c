"""A run whose energy balance does not hold, or that was not solved, ends with status 1, however it was started."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from haul_ros.physics.train_model import TrainModel

if TYPE_CHECKING:
    from tests.cli.conftest import Haul

RUN = ("run", "short.yaml", "--quiet")
STUDY = ("study", "sweep", "--scenario", "short.yaml", "--over", "initial_speed_kmh=10,15", "--quiet")
REPLAY = ("replay", "run.mcap", "--set", "radio.default.delay_s=2", "-o", "again.mcap")


@pytest.mark.parametrize("command", [RUN, STUDY, REPLAY])
def test_energy_from_nowhere_is_said_and_ends_with_status_1(
    haul: Haul, monkeypatch: pytest.MonkeyPatch, command: Sequence[str]
) -> None:
    assert haul(*RUN, "-o", "run.mcap").err == ""
    # Gears that hold a kilojoule more than their curves say, as if a contact had made it.
    stored = TrainModel.stored_energies.__get__
    monkeypatch.setattr(TrainModel, "stored_energies", property(lambda model: stored(model) + 1e3))
    outcome = haul(*command)
    assert outcome.status == 1
    assert "haul: warning: the energy balance does not hold" in outcome.err


@pytest.mark.parametrize("command", [RUN, STUDY, REPLAY])
def test_a_step_that_was_not_solved_is_said_and_ends_with_status_1(
    haul: Haul, monkeypatch: pytest.MonkeyPatch, command: Sequence[str]
) -> None:
    assert haul(*RUN, "-o", "run.mcap").status == 0
    statistics = TrainModel.statistics
    monkeypatch.setattr(
        TrainModel, "statistics", lambda model: replace(statistics(model), unconverged_steps=2, worst_residual=5.0)
    )
    outcome = haul(*command)
    assert outcome.status == 1
    assert "did not converge" in outcome.err
    assert "do not trust" in outcome.err
