"""Where a run is recorded to; imports all that writing needs, which a run without a file does not."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from haul_ros.errors import RecordingError
from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.log import PeriodLog
from haul_ros.model.scenario import Scenario
from haul_ros.recording.writer import McapRecorder


class Sink:
    """A recording that takes its time; ``failure`` says why it could not be finished.

    Raises
    ------
    RecordingError
        There can be no such recording.
    """

    def __init__(self, path: Path, scenario: Scenario, compression: str) -> None:
        self.failure: RecordingError | None = None
        self._encoder = TelemetryEncoder.of(scenario)
        channels = self._encoder.channels
        self._recorder = McapRecorder(path, scenario, channels, compression=compression, when_full="block")

    def put(self, log: PeriodLog) -> None:
        """Record a period."""
        self._recorder.put(self._encoder.messages(log), time.time_ns())

    @contextmanager
    def finishing(self) -> Iterator[None]:
        """Finish the recording at the end of the block; that it failed is left to be told when the run has been."""
        with self._recorder:
            yield
            try:
                self._recorder.close()
            except RecordingError as error:
                self.failure = error
