"""The page in a terminal."""

from __future__ import annotations

import json
import struct
from io import StringIO
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rich")
from rich.console import Console

from haul_ros.page.terminal import TerminalPage

COUPLERS = 20


def message(what: str, **content: object) -> str:
    return json.dumps({"is": what, **content})


def frame(time: float, force: np.ndarray[Any, Any]) -> bytes:
    rest = np.zeros(COUPLERS + COUPLERS + 1)  # strokes, cylinders
    return struct.pack("<d", time) + np.concatenate(([72.04, 72.0, 71.9], force, rest)).astype("<f4").tobytes()


@pytest.fixture
def page() -> TerminalPage:
    page = TerminalPage()
    train = {
        "couplers": [f"coupler_{n:03d}" for n in range(1, COUPLERS + 1)],
        "vehicles": [f"vehicle_{n:03d}_C80" for n in range(1, COUPLERS + 2)],
        "locomotives": [{"name": "master", "vehicle": 0}, {"name": "slave_1", "vehicle": COUPLERS}],
    }
    page.take(message("hello", node="/train_a/haul", train=train))
    page.take(message("state", present=True, pace="running", scenario="mine", factor=1.0))
    return page


def shown(page: TerminalPage, width: int = 120, height: int = 31, *, styles: bool = False) -> list[str]:
    console = Console(width=width, height=height, record=True, force_terminal=True, file=StringIO())
    console.print(page.screen(width, height))
    return console.export_text(styles=styles).splitlines()


def test_until_something_comes_it_says_what_it_waits_for() -> None:
    page = TerminalPage()
    assert page.line() == "waiting for a train"
    page.take(message("hello", node="/haul", train=None))
    page.take(message("state", nodes=["/train_b/haul"]))
    assert [line.rstrip() for line in shown(page)] == ["waiting for /haul; there is /train_b/haul"]


def test_the_line_has_time_speed_and_forces_with_their_signs(page: TerminalPage) -> None:
    force = np.linspace(-250.0, 480.0, COUPLERS)
    page.take(frame(7.46, force))
    page.take(message("peaks", compression=[1.0, 877.3], tension=[738.5, 0.0]))
    assert page.line() == (
        "/train_a/haul  mine  running  7.46 s  72.0 km/h  compression 480 kN, tension 250 kN"
        "  so far 877 and 738 kN  1.00 x real time"
    )


def test_compression_stands_on_the_axis_tension_hangs_below_it_and_a_full_bar_is_as_long_as_the_axis(
    page: TerminalPage,
) -> None:
    force = np.zeros(COUPLERS)
    force[0], force[1], force[-1] = 500.0, 250.0, -500.0
    page.take(frame(1.0, force))
    _, *rows = shown(page)
    rows = [row.ljust(10 + COUPLERS) for row in rows[: next(n for n, row in enumerate(rows) if "▲" in row)]]
    assert len(rows) == 16
    assert rows[0].startswith("   500 kN ")
    assert rows[-1].startswith("  -500 kN ")
    assert "".join(row[10] for row in rows) == "█" * 8 + " " * 8
    assert "".join(row[11] for row in rows) == " " * 4 + "█" * 4 + " " * 8
    coloured = shown(page, styles=True)[1:17]
    assert ["\x1b[7;34m \x1b[0m" in row for row in coloured] == [False] * 8 + [True] * 8


def test_a_bar_that_hangs_ends_within_a_row(page: TerminalPage) -> None:
    page.take(frame(1.0, np.full(COUPLERS, -1000.0 * 3.25 / 8.0)))
    rows = shown(page, styles=True)[1:17]
    assert "500" in rows[0]
    assert [f"\x1b[7;34m{' ' * COUPLERS}\x1b[0m" in row for row in rows[8:]] == [True] * 6 + [False] * 2
    assert f"\x1b[7;34m{'▄' * COUPLERS}\x1b[0m" in rows[14]  # 6.5 of 8 rows


def test_locomotives_radio_and_events_are_told(page: TerminalPage) -> None:
    page.take(frame(1.0, np.zeros(COUPLERS)))
    page.take(message("applied", time=1.0, locomotive="master", value=0.5))
    page.take(message("effort", time=1.0, locomotive="slave_1", value=-120e3))
    page.take(message("state", links={"slave_1": {"delay": 0.5, "connected": True, "heard": False}}))
    page.take(message("event", time=0.5, kind="emergency", text="slave_1: emergency [bold]latched[/bold]"))
    text = "\n".join(shown(page))
    assert "master" in text
    assert "0.50" in text
    assert "-120  0.5 s  does not hear" in text
    assert "0.500 s  emergency    slave_1: emergency [bold]latched[/bold]" in text  # no markup of others


def test_a_node_that_was_started_anew_begins_with_nothing(page: TerminalPage) -> None:
    page.take(frame(9.0, np.full(COUPLERS, 100.0)))
    page.take(message("hello", node="/train_a/haul", train=None))
    page.take(frame(1.0, np.full(COUPLERS, 100.0)))
    assert page.line().startswith("waiting for /train_a/haul")


@pytest.mark.parametrize("width", [20, 40, 200])
def test_no_line_is_wider_than_the_terminal(page: TerminalPage, width: int) -> None:
    page.take(frame(1.0, np.linspace(-1e3, 1e3, COUPLERS)))
    assert max(len(line.rstrip()) for line in shown(page, width, 24)) <= width
