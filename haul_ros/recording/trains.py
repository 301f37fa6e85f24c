"""The train in a file of any kind, opened."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from haul_ros.errors import RecordingError
from haul_ros.model.event import Event
from haul_ros.recording.bag import TrainBag
from haul_ros.recording.foreign import is_own
from haul_ros.recording.reader import Recording
from haul_ros.recording.series import PressureSeries, RecordedExtremes, Samples, ScalarSeries
from haul_ros.recording.train_source import TrainSource


class RecordedTrain(TrainSource):
    """The train in a finished recording of haul_ros."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        facts = recording.info()
        self.path = recording.path
        self.node = recording.channels.prefix
        self.couplers, self.vehicles = recording.names()
        self.locomotives = facts.locomotives
        self.scenario_document = recording.scenario_document
        self.title = f"{facts.scenario}: {facts.description}"
        self.samples = recording.count(recording.channels.couplers)
        self.begin_ns, self.end_ns = facts.start_ns, facts.end_ns
        lost = (facts.dropped or 0) + facts.lost
        self.notes = (f"{lost} messages are missing in the file",) if lost else ()

    def blocks(self) -> Iterator[Samples]:
        """Couplers, vehicles and cylinder pressure, a chunk of the file at a time."""
        return self.recording.blocks()

    def scalars(self, name: str) -> ScalarSeries:
        """A topic of the description of the run; an older version may not have recorded it."""
        return self.recording.scalars(name)

    def events(self) -> tuple[Event, ...]:
        """What happened, in order of time."""
        return self.recording.events()

    def final_extremes(self) -> RecordedExtremes | None:
        """The newest; None of a run that ended before the first."""
        recorded = self.recording.count(self.recording.channels.max_compression)
        return self.recording.last_extremes() if recorded else None

    def air(self) -> Iterator[tuple[PressureSeries, PressureSeries]]:
        """Pressure of brake pipe and auxiliary reservoirs, a chunk of the file at a time."""
        return self.recording.air_blocks()


@contextmanager
def open_train(path: str | Path, node: str | None = None, run: int | None = None) -> Iterator[TrainSource]:
    """The train in a recording of any kind, by its node where there are several, and by its run after resets.

    A finished recording of haul_ros is checked as `Recording` does; anything else, a folder of a bag, MCAP or SQLite by
    another recorder, or an unfinished recording, is read from its start to its end.

    Raises
    ------
    RecordingError
        The file cannot be read or is damaged, or there is no such train in it.
    """
    path = Path(path)
    if path.is_dir() or not is_own(path):
        yield TrainBag(path, node, run)
        return
    with Recording(path) as recording:
        train = RecordedTrain(recording)
        if node not in (None, train.node):
            raise RecordingError(f"{path}: no train of node {node}, it has {train.node}")
        if run not in (None, 1):
            raise RecordingError(f"{path}: no run {run}, it has 1")
        yield train
