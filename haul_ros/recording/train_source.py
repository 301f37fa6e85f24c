"""One train in a recording of any kind: what an analysis needs of it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path

from haul_ros.model.event import Event
from haul_ros.recording.series import PressureSeries, RecordedExtremes, Samples, ScalarSeries


class TrainSource(ABC):
    """A train in a recording; times are simulation times.

    ``node`` is the full name of the node that published it; ``couplers`` and ``vehicles`` are names in the order of the
    samples, empty where there are none; ``locomotives`` are those that take commands, head first.
    ``scenario_document`` is that of a recording of haul_ros, None: there is none. ``title`` is what the
    file says of itself, ``notes`` what it has lost, a line each, ``samples`` how many of couplers there are, from about
    ``begin_ns`` to ``end_ns``.
    """

    path: Path
    node: str
    couplers: tuple[str, ...]
    vehicles: tuple[str, ...]
    locomotives: tuple[str, ...]
    scenario_document: str | None
    title: str
    samples: int
    begin_ns: int
    end_ns: int
    notes: tuple[str, ...]

    @abstractmethod
    def blocks(self) -> Iterator[Samples]:
        """Couplers, vehicles and cylinder pressure piece by piece; each may be empty."""

    @abstractmethod
    def scalars(self, name: str) -> ScalarSeries:
        """A number over time by its name under the node, such as ``master/applied_brake``; empty: it is not there."""

    @abstractmethod
    def events(self) -> tuple[Event, ...]:
        """What happened, in order of time."""

    @abstractmethod
    def final_extremes(self) -> RecordedExtremes | None:
        """The largest values of every time step, as recorded last; None: they are not there."""

    @abstractmethod
    def air(self) -> Iterator[tuple[PressureSeries, PressureSeries]]:
        """Pressure of brake pipe and auxiliary reservoirs piece by piece; nothing without a pneumatic brake."""
