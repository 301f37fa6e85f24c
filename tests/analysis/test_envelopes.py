from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from haul_ros.analysis.envelopes import bottomed_couplers, largest_force
from haul_ros.model.scenario import Scenario

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun


def test_the_envelope_is_the_larger_of_compression_and_tension(run: RecordedRun) -> None:
    extremes = run.session.extremes()
    envelope = largest_force(extremes)
    assert (envelope >= extremes.compression).all()
    assert (envelope >= extremes.tension).all()
    assert ((envelope == extremes.compression) | (envelope == extremes.tension)).all()


def test_a_gear_is_closed_when_stroke_reaches_its_maximum_and_half_the_slack_in_either_direction(
    scenario: Scenario, run: RecordedRun
) -> None:
    gear = scenario.consist.couplers[0]
    assert gear is not None
    limited = replace(gear, maximum_stroke=0.08, slack=0.01)
    consist = replace(scenario.consist, couplers=(limited,) * 20 + (None,))
    strokes = np.zeros(21)
    extremes = replace(run.session.extremes(), compression_stroke=strokes.copy(), tension_stroke=strokes.copy())
    assert bottomed_couplers(consist, extremes) == ()
    extremes.compression_stroke[3] = 0.0851
    extremes.compression_stroke[4] = 0.0849
    extremes.tension_stroke[7] = 0.0851
    assert bottomed_couplers(consist, extremes) == (3, 7)
