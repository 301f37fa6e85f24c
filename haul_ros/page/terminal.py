"""The live page in a terminal: what `page.server` would send to browsers, as text."""

from __future__ import annotations

import json
import struct
from collections import deque
from itertools import groupby
from typing import Any

import numpy as np
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from haul_ros.model.sample import FloatArray

_TIME = struct.Struct("<d")
_SPEEDS = 3
_BLOCKS = " ▁▂▃▄▅▆▇█"
_COMPRESSION, _TENSION, _DIM = "red", "blue", "dim"
_MARGIN = 10
"""Columns left of the profile."""
_LEAST_LIMIT = 100.0
"""Of the axis of forces [kN]."""
_EVENTS = 6
_REST = 15
"""Lines of a screen that are not the profile's."""


class TerminalPage:
    """Keeps what the messages for browsers tell of a train, and draws it; forces in kN, compression positive."""

    _train: dict[str, Any] | None
    _time: float | None
    _peaks: dict[str, list[float]] | None

    def __init__(self) -> None:
        self._forget()
        self._state: dict[str, Any] = {}
        self._node = ""

    def take(self, message: str | bytes) -> None:
        """A message of `TrainWatcher`."""
        if isinstance(message, bytes):
            self._take_frame(message)
            return
        told = json.loads(message)
        match told.pop("is"):
            case "hello":
                self._forget()
                self._node, self._train = told["node"] or "", told["train"]
            case "state":
                self._state |= told
            case "applied" | "effort" as what:
                self._locomotives.setdefault(told["locomotive"], {})[what] = told["value"]
            case "event":
                self._events.append(told)
            case "peaks":
                self._peaks = told

    def screen(self, width: int, height: int) -> RenderableType:
        """All of it, for a terminal of so many columns and lines."""
        if self._time is None:
            return Text(self._waiting(), style=_DIM)
        rows = max(4, height - _REST - len(self._locomotives))
        parts: list[RenderableType] = [Text(self.line(), style="bold"), self._profile(width, rows), self._table()]
        if self._events:
            parts.append(Panel(self._latest(), title="events", title_align="left", border_style=_DIM))
        return Group(*parts)

    def line(self) -> str:
        """The train in one line: time, speed, largest forces now and so far, brakes."""
        if self._time is None:
            return self._waiting()
        most, least = self._force.max(initial=0.0), self._force.min(initial=0.0)
        parts = [
            self._node,
            str(self._state.get("scenario", "")),
            str(self._state.get("pace", "")) if self._state.get("present", True) else "gone",
            f"{self._time:.2f} s",
            f"{self._speed[0]:.1f} km/h",
            f"compression {most:.0f} kN, tension {-least:.0f} kN",
        ]
        if self._peaks:
            peaks = [f"{max(self._peaks[name], default=0.0):.0f}" for name in ("compression", "tension")]
            parts.append(f"so far {' and '.join(peaks)} kN")
        if "factor" in self._state:
            parts.append(f"{self._state['factor']:.2f} x real time")
        return "  ".join(filter(None, parts))

    def _forget(self) -> None:
        self._train = self._time = self._peaks = None
        self._speed, self._force = np.zeros(_SPEEDS), np.zeros(0)
        self._locomotives: dict[str, dict[str, float]] = {}
        self._events: deque[dict[str, Any]] = deque(maxlen=_EVENTS)

    def _waiting(self) -> str:
        found = self._state.get("nodes", ())
        there = f"; there is {', '.join(found)}" if found and self._node not in found else ""
        return f"waiting for {self._node or 'a train'}{there}"

    def _take_frame(self, message: bytes) -> None:
        if not self._train:
            return
        (self._time,) = _TIME.unpack_from(message)
        values = np.frombuffer(message, "<f4", offset=_TIME.size).astype(float)
        self._speed = values[:_SPEEDS]
        self._force = values[_SPEEDS : _SPEEDS + len(self._train["couplers"])]

    def _profile(self, width: int, rows: int) -> Text:
        """Forces along the train: bars up for compression, down for tension, the largest of those in a column."""
        columns = max(10, min(width - _MARGIN - 1, len(self._force)))
        force = _columns(self._force, columns)
        limit = max(_LEAST_LIMIT, _round(float(np.abs(self._force).max(initial=0.0))))
        half = rows // 2
        text = Text()
        for row in range(half, -half, -1):
            up = row > 0
            label = f"{limit:.0f}" if row == half else f"-{limit:.0f}" if row == 1 - half else "0" if row == 1 else ""
            text.append(f"{label:>{_MARGIN - 4}} {'kN' if label else '  '} ", style=_DIM)
            filled = (force if up else -force) / limit * half - (row - 1 if up else -row)
            eighths = np.clip(np.rint(filled * 8.0), 0, 8).astype(int)
            if up:
                text.append("".join(_BLOCKS[n] for n in eighths), style=_COMPRESSION)
            else:  # a bar that hangs is the gap below it, reversed
                for hangs, some in groupby(eighths, bool):
                    gaps = "".join(_BLOCKS[8 - n] if hangs else " " for n in some)
                    text.append(gaps, style=f"{_TENSION} reverse" if hangs else "")
            text.append("\n")
        text.append(self._places(columns), style=_DIM)
        return text

    def _places(self, columns: int) -> str:
        """Under the profile: where the locomotives are."""
        line = [" "] * columns
        assert self._train is not None
        vehicles = max(1, len(self._train["vehicles"]) - 1)
        for locomotive in self._train["locomotives"]:
            if locomotive["vehicle"] is not None:
                line[min(columns - 1, round(locomotive["vehicle"] / vehicles * (columns - 1)))] = "▲"
        return " " * _MARGIN + "".join(line)

    def _table(self) -> Table:
        table = Table(box=None, pad_edge=False, header_style=_DIM)
        for heading in ("locomotive", "brake", "effort [kN]", "radio"):
            table.add_column(Text(heading), justify="left" if heading in ("locomotive", "radio") else "right")
        links = self._state.get("links", {})
        for name, told in self._locomotives.items():
            applied = told.get("applied", 0.0)
            table.add_row(
                name,
                Text(f"{applied:.2f}", style="bold" if applied else ""),
                f"{told.get('effort', 0.0) / 1e3:.0f}",
                _radio(links.get(name)),
            )
        return table

    def _latest(self) -> Text:
        return Text("\n".join(f"{event['time']:9.3f} s  {event['kind']:<12} {event['text']}" for event in self._events))


def _radio(link: dict[str, Any] | None) -> str:
    if link is None:
        return ""
    state = "link down" if link.get("connected") is False else "does not hear" if link.get("heard") is False else ""
    return "  ".join(filter(None, [f"{link['delay']:g} s" if "delay" in link else "", state]))


def _columns(force: FloatArray, count: int) -> FloatArray:
    """Of the forces that fall into each of so many columns the one of largest magnitude."""
    parts = np.array_split(force, count)
    return np.array([part[np.abs(part).argmax()] if len(part) else 0.0 for part in parts])


def _round(value: float) -> float:
    """1, 2 or 5 times a power of ten, at or above a value above 0."""
    if value <= 0.0:
        return 0.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= value * (1.0 - 1e-12)))
