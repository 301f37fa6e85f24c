from __future__ import annotations

import io
import sys
from dataclasses import replace

import pytest

from haul_ros.cli.progress import progress, reading_progress
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def scenario() -> Scenario:
    return load_scenario("daqin_1_1_0")


def test_the_bar_shows_time_speed_and_share_and_never_runs_backwards(
    scenario: Scenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    sample = Session(scenario).sample()
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress(scenario, quiet=False) as bar:
        for time_s, share in ((1, 1.0), (2, 0.5), (3, 0.75)):
            bar.show(replace(sample, time_ns=time_s * 10**9, speed=sample.speed * share))
        bar._bar.refresh()
    assert "preparing" in terminal.getvalue()
    last = [shown for shown in terminal.getvalue().split("\r") if shown.strip()][-1]
    assert "3.00 s   60.0 km/h" in last
    assert " 50 %" in last


def test_there_is_no_bar_if_quiet(scenario: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress(scenario, quiet=True) as bar:
        bar.show(Session(scenario).sample())
    assert terminal.getvalue() == ""


def test_there_is_no_bar_where_stderr_is_no_terminal(scenario: Scenario, capsys: pytest.CaptureFixture[str]) -> None:
    with progress(scenario, quiet=False) as bar:
        bar.show(Session(scenario).sample())
    assert capsys.readouterr().err == ""


def test_reading_shows_how_much_has_been_read_and_is_gone_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with reading_progress() as show:
        show(500, 2000)
        show(2500, 2000)  # a file may have more than its index said
    shown = terminal.getvalue()
    assert "reading" in shown
    assert "  0 %|" in shown
    assert not shown.split("\r")[-1].strip()


def test_reading_shows_nothing_where_stderr_is_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with reading_progress() as show:
        show(1, 1)
    assert capsys.readouterr() == ("", "")
