from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from haul_ros.analysis.summary import RunSummary, summarize_session
from haul_ros.cli.summary_text import summary_json, summary_lines, warnings
from haul_ros.scenario import load_scenario
from haul_ros.simulation.radio import LinkStatus
from haul_ros.simulation.session import Session

if TYPE_CHECKING:
    from tests.cli.conftest import Haul


@pytest.fixture
def summary(haul: Haul) -> RunSummary:
    """Of a train that has not moved a step yet."""
    return summarize_session(Session(load_scenario("short.yaml")), wall_time=0.0)


def test_where_no_coupler_bore_any_force_there_is_none(summary: RunSummary) -> None:
    lines = summary_lines(summary)
    for name in ("peak compression", "peak tension", "largest stroke"):
        assert f"  {name:18} none" in lines
    found = summary_json(summary)
    assert (found["peak_tension_kN"], found["peak_tension_coupler"], found["largest_stroke_mm"]) == (0.0, None, 0.0)
    assert found["real_time_factor"] is None
    json.dumps(found, allow_nan=False)


def test_the_direction_of_the_largest_stroke_is_printed(summary: RunSummary) -> None:
    session = Session(load_scenario("short.yaml"), play_commands=True)
    while not session.finished:
        session.advance()
    ran = summarize_session(session, wall_time=1.0)
    assert ran.compression_stroke is not None
    large = replace(ran.compression_stroke, value=1.0)
    for changed, word in (
        (replace(ran, compression_stroke=large), "compression"),
        (replace(ran, tension_stroke=large), "tension"),
    ):
        (line,) = (line for line in summary_lines(changed) if "largest stroke" in line)
        assert f"1000.00 mm in {word}" in line


def test_steps_that_did_not_converge_are_warned_of(summary: RunSummary) -> None:
    assert warnings(summary) == []
    assert summary.solver is not None
    doubtful = replace(summary, solver=replace(summary.solver, unconverged_steps=3, worst_residual=12.5))
    (warning,) = warnings(doubtful)
    assert "3 smallest parts of time steps did not converge (residual up to 12.5 N)" in warning
    assert summary_json(doubtful)["warnings"] == [warning]


def test_every_standing_has_a_line_with_the_entries_it_holds_for(summary: RunSummary) -> None:
    lines = summary_lines(
        replace(summary, caveats=("vehicles.C80: mass_t overridden; shoes fitted", "couplers.x: all values fitted"))
    )
    assert "  fitted values in   vehicles.C80, couplers.x" in lines
    assert "  overridden values in vehicles.C80" in lines
    assert not any("assumed" in line for line in lines)


def test_what_went_wrong_on_a_radio_link_has_a_line_and_what_did_not_has_none(summary: RunSummary) -> None:
    assert not any("radio" in line for line in summary_lines(summary))
    links = {
        "slave_1": LinkStatus(True, 0.5, sent=7, lost=0),
        "slave_2": LinkStatus(True, 0.5, sent=7, lost=3, retried=4, duplicates=2),
    }
    found = replace(summary, radio=links)
    lines = [line for line in summary_lines(found) if "radio" in line]
    assert lines == [f"  {'radio':18} slave_2: 7 telegrams, 3 lost, 4 sent again, 2 duplicates ignored"]
    assert summary_json(found)["radio"]["slave_2"] == {
        "sent": 7,
        "lost": 3,
        "sent_again": 4,
        "given_up": 0,
        "duplicates_ignored": 2,
        "out_of_order": 0,
    }
    assert summary_json(replace(summary, radio=None))["radio"] is None
