"""Watches one train on the graph and says what a page has to know of it."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Iterator
from time import monotonic
from typing import Any

import numpy as np
from rclpy.node import Node

from haul_ros.errors import one_line
from haul_ros.messages.channels import ChannelTable, channel_table
from haul_ros.messages.quantities import ExtremeArrays, time_codec
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.sample import CouplerExtremes
from haul_ros.page.train import Message, command_entry, locomotive_vehicles, peaks, train
from haul_ros.ros.view.frames import FrameMaker
from haul_ros.ros.view.graph import FoundTrain, chosen_train, found_trains
from haul_ros.ros.view.reading import Inlet
from haul_ros.units import NS_PER_S

_LOOK = 1.0
"""Wall time [s] between two looks at the graph."""
_MOST_FRAMES = 3000
_MOST_BYTES = 32 * 1024 * 1024
"""Of frames that are kept for browsers that come later."""
_MOST_ENTRIES = 2000
"""Events, commands and changes that are kept for them."""
_LONGEST_TEXT = 400
_LINK = ("delay", "connected")


class TrainWatcher:
    """Reads the topics of the train ``name``, None: of the one that it finds first; `poll` ten times a second.

    ``tell`` gets the messages for all browsers, `greeting` gives those for one that comes later. It does not come in
    the way of the node: it subscribes, and no more.
    """

    def __init__(self, node: Node, name: str | None, tell: Callable[[Message], None], *, drive: bool = False) -> None:
        self._node, self._name, self._tell, self._drive = node, name, tell, drive
        self._looked = -_LOOK
        self._names: tuple[str, ...] = ()
        self.train: FoundTrain | None = None
        self._inlets: dict[str, Inlet] = {}
        self._state: dict[str, Any] = {}
        self._forget()

    def choose(self, name: str) -> None:
        """Watch another train from now on."""
        self._name = name
        self._looked = -_LOOK

    def greeting(self) -> Iterator[Message]:
        """All that a browser needs to show what has been so far."""
        yield self._hello()
        yield from list(self._entries)
        yield from list(self._frames)
        if self._peaks is not None:
            yield self._peaks
        yield _text("state", self._state)

    def poll(self) -> None:
        """Take what has come, and tell of it."""
        if monotonic() >= self._looked + _LOOK:
            self._looked = monotonic()
            self._look()
        if self.train is None:
            return
        try:
            self._take_samples()
        except ValueError:  # of another train than the messages before: the node has been started anew
            self._begin()
            return
        if self._told:
            self._take_entries()
            self._take_extremes()
        self._take_state()

    def close(self) -> None:
        """Subscribe no more."""
        for inlet in self._inlets.values():
            inlet.close()
        self._inlets = {}

    def _look(self) -> None:
        found = found_trains(self._node)
        names = tuple(found)
        chosen = chosen_train(found, self._name)
        if chosen is not None and chosen != self.train:
            self._watch(chosen)
        changes: dict[str, Any] = {"present": chosen is not None}
        if names != self._names:
            self._names = names
            changes["nodes"] = list(names)
        self._update_state(changes)

    def _watch(self, train: FoundTrain) -> None:
        self.close()
        self.train = train
        self._channels = channel_table(train.locomotives, train.name, pneumatic=train.pneumatic)
        self._inlets = dict(_inlets(self._node, self._channels))
        self._begin()

    def _begin(self) -> None:
        """From here on nothing is known of the train but its name."""
        self._forget()
        self._tell(self._hello())

    def _forget(self) -> None:
        self._frame_maker = FrameMaker(pneumatic=bool(self.train and self.train.pneumatic))
        self._frames: deque[bytes] = deque(maxlen=_MOST_FRAMES)
        self._entries: deque[str] = deque(maxlen=_MOST_ENTRIES)
        self._peaks: str | None = None
        self._extremes: dict[str, bytes] = {}
        self._time = -1.0
        self._told = False

    def _hello(self) -> str:
        maker, found = self._frame_maker, self.train
        content: dict[str, Any] = {
            "drive": self._drive,
            "node": found.name if found else self._name,
            "nodes": list(self._names),
            "train": None,
        }
        if found and maker.couplers and maker.vehicles:
            vehicles = maker.vehicles.names
            locomotives = locomotive_vehicles(vehicles, found.locomotives)
            content["train"] = train(
                maker.couplers.names, vehicles, locomotives, maker.places, pneumatic=found.pneumatic
            )
        return _text("hello", content)

    def _take_samples(self) -> None:
        taken = {key: list(self._inlets[key].take()) if key in self._inlets else [] for key in _SAMPLES}
        made = self._frame_maker.frame(taken["couplers"], taken["vehicles"], taken["cylinder"], taken["pipe"])
        if made is None:
            return
        time, frame = made
        if time < self._time:  # a reset
            maker = self._frame_maker
            self._forget()
            self._frame_maker = maker
        if not self._told:
            self._told = True
            limit = max(2, min(_MOST_FRAMES, _MOST_BYTES // len(frame)))
            self._frames = deque(maxlen=limit)
            self._tell(self._hello())
        if time > self._time:
            self._time = time
            self._frames.append(frame)
            self._tell(frame)

    def _take_entries(self) -> None:
        for key, inlet in self._inlets.items():
            what, _, rest = key.partition(" ")
            if what == "events":
                for entry in inlet.take():
                    time = entry.stamp.sec + entry.stamp.nanosec / NS_PER_S
                    kind, text = entry.name.rpartition(".")[2], one_line(entry.msg, _LONGEST_TEXT)
                    self._enter("event", {"time": time, "kind": one_line(kind, 40), "text": text})
            elif what in ("applied", "effort"):
                for message in inlet.take():
                    value = float(np.nan_to_num(message.data))
                    self._enter(what, {"time": self._time, "locomotive": rest, "value": value})
            elif what == "command":
                locomotive, _, kind = rest.partition(" ")
                for message in inlet.take():
                    value = float(np.nan_to_num(float(message.data)))
                    command = Command(locomotive, CommandKind(kind), value)
                    self._enter("command", command_entry(self._time, command))

    def _enter(self, kind: str, content: dict[str, Any]) -> None:
        message = _text(kind, content)
        self._entries.append(message)
        self._tell(message)

    def _take_extremes(self) -> None:
        fresh = False
        for key in _EXTREMES:
            for message in self._inlets[key].take():
                self._extremes[key] = message
                fresh = True
        couplers = self._frame_maker.couplers
        if not fresh or couplers is None or len(self._extremes) < len(_EXTREMES):
            return
        times = time_codec(couplers.count)
        compression, tension = (
            ExtremeArrays(stroke, times.decode(self._extremes[f"{key} time"]), force)
            for key in ("compression", "tension")
            for stroke, _, force in [couplers.decode(self._extremes[key])]
        )
        extremes = CouplerExtremes(
            compression=compression.force,
            compression_time=compression.time,
            tension=-tension.force,
            tension_time=tension.time,
            compression_stroke=compression.stroke,
            tension_stroke=-tension.stroke,
            bottomed_time=np.full(couplers.count, np.nan),
        )
        self._peaks = _text("peaks", peaks(extremes))
        self._tell(self._peaks)

    def _take_state(self) -> None:
        changes: dict[str, Any] = {}
        links = {slave: dict(link) for slave, link in self._state.get("links", {}).items()}
        for key, inlet in self._inlets.items():
            what, _, rest = key.partition(" ")
            if what == "link":
                slave, _, field = rest.partition(" ")
                for message in inlet.take():
                    links.setdefault(slave, {})[field] = message.data
            elif what == "factor":
                for message in inlet.take():
                    changes["factor"] = round(float(np.nan_to_num(message.data)), 3)
            elif what == "diagnostics":
                for message in inlet.take():
                    changes |= self._pacing(message)
        self._update_state(changes | {"links": links})

    def _pacing(self, message: Any) -> dict[str, Any]:
        """What the node says of its pace: running, paused, starting, too slow; and which scenario it runs."""
        wanted = f"{self._channels.prefix.lstrip('/')}: pacing"
        for status in message.status:
            if status.name == wanted:
                told = {"pace": status.message, "scenario": status.hardware_id}
                return {key: one_line(text, _LONGEST_TEXT) for key, text in told.items()}
        return {}

    def _update_state(self, changes: dict[str, Any]) -> None:
        """Tell what has changed."""
        fresh = {key: value for key, value in changes.items() if self._state.get(key) != value}
        if fresh:
            self._state |= fresh
            self._tell(_text("state", fresh))


_SAMPLES = ("couplers", "vehicles", "cylinder", "pipe")
_EXTREMES = ("compression", "tension", "compression time", "tension time")


def _inlets(node: Node, channels: ChannelTable) -> Iterator[tuple[str, Inlet]]:
    """All that is read of a train, by what it is."""
    samples = (channels.couplers, channels.vehicles, channels.brake_cylinder_pressure, channels.brake_pipe_pressure)
    for key, channel in zip(_SAMPLES, samples, strict=True):
        if channel is not None:
            yield key, Inlet(node, channel, raw=True)
    for key, extreme in zip(_EXTREMES, channels.extremes, strict=True):
        yield key, Inlet(node, extreme, raw=True)
    yield "events", Inlet(node, channels.events)
    yield "factor", Inlet(node, channels.real_time_factor)
    yield "diagnostics", Inlet(node, channels.diagnostics)
    for locomotive, channel in channels.applied_brake.items():
        yield f"applied {locomotive}", Inlet(node, channel)
    for locomotive, channel in channels.tractive_effort.items():
        yield f"effort {locomotive}", Inlet(node, channel)
    for kind, by_locomotive in channels.commands.items():
        for locomotive, channel in by_locomotive.items():
            yield f"command {locomotive} {kind.value}", Inlet(node, channel)
    for slave in channels.radio["delay"]:
        for field in _LINK:
            yield f"link {slave} {field}", Inlet(node, channels.radio[field][slave])
        yield f"link {slave} heard", Inlet(node, channels.radio_seen["heard"][slave])


def _text(kind: str, content: dict[str, Any]) -> str:
    return json.dumps({"is": kind, **content}, separators=(",", ":"))
