"""Recording beside the loop: a bounded queue and a thread of its own, so that the disk never delays the train."""

from __future__ import annotations

import queue
import threading
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Literal, NamedTuple

from haul_ros.errors import RecordingError
from haul_ros.messages.channels import ChannelTable
from haul_ros.messages.encoder import Message
from haul_ros.model.scenario import Scenario
from haul_ros.recording.run_file import RunFile, description_of, recovery_hint
from haul_ros.recording.thinning import Thinning

FLUSH_INTERVAL = 1.0
"""Wall time [s] after which a killed process has lost nothing older."""


@dataclass(frozen=True, slots=True)
class RecorderStatus:
    """Messages in the file, messages that did not get there, bytes of the file, and what went wrong for good.

    After a failure, messages since the last flush count as dropped: the file may end before them.
    """

    written: int
    dropped: int
    bytes: int
    failure: str | None


class _Batch(NamedTuple):
    messages: tuple[tuple[Message, int], ...]
    """Each with its sequence number."""
    publish_time_ns: int


class McapRecorder:
    """Writes ``path`` as it comes: opens at once, ``close`` (or leaving the ``with`` block) completes the file.

    ``when_full`` says what `put` does when the disk is ``queue_limit`` puts behind: ``drop`` counts and goes on, for
    a run in real time; ``block`` waits, for a run that may take its time. A failure while writing (disk full) does
    not disturb the caller: everything after it is dropped, ``status`` reports it, ``close`` raises.

    Of the samples it takes those that the scenario wants recorded, see `Thinning`. Sequence numbers count the messages
    taken per channel, so a gap in the file shows where some were dropped.

    Raises
    ------
    RecordingError
        Unknown compression, ``path`` or ``path.active`` exists already, or the file cannot be created.
    """

    def __init__(
        self,
        path: str | Path,
        scenario: Scenario,
        channels: ChannelTable,
        *,
        compression: str = "zstd",
        when_full: Literal["drop", "block"] = "drop",
        queue_limit: int = 500,
    ) -> None:
        description = description_of(scenario, channels, compression)
        self._file = RunFile(Path(path), description, scenario.document, channels)
        self._thinning = Thinning(scenario, channels)
        self._block = when_full == "block"
        self._queue: queue.Queue[_Batch | None] = queue.Queue(queue_limit)
        self._sequences: Counter[str] = Counter()
        # Each counter has one thread that changes it: the caller's the first, the writing thread the others.
        self._dropped_full = 0
        self._dropped_failed = 0
        self._written = 0
        self._unflushed = 0
        self._bytes = self._file.size
        self._failure: str | None = None
        self._closed = False
        self._last_put_ns = 0
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    @property
    def path(self) -> Path:
        """The file as it is called when complete."""
        return self._file.path

    @property
    def status(self) -> RecorderStatus:
        """How the recording stands; from any thread."""
        return RecorderStatus(self._written, self._dropped_full + self._dropped_failed, self._bytes, self._failure)

    def put(self, messages: Sequence[Message], publish_time_ns: int) -> None:
        """Record of messages of one instant what is to be; wall time [ns]. To be called by one thread at a time.

        Raises
        ------
        ValueError
            The recorder is closed, or a message is of no channel of this recording.
        """
        if self._closed:
            raise ValueError(f"{self.path}: recording is closed")
        for message in messages:
            if message.channel.topic not in self._file:
                raise ValueError(f"{message.channel.topic}: not a channel of this recording")
        self._last_put_ns = publish_time_ns
        if taken := self._thinning.taken(messages):
            self._enqueue(taken, publish_time_ns)

    def _enqueue(self, messages: Sequence[Message], publish_time_ns: int) -> None:
        batch = _Batch(tuple((message, self._next_sequence(message)) for message in messages), publish_time_ns)
        try:
            self._queue.put(batch, block=self._block)
        except queue.Full:
            self._dropped_full += len(messages)

    def _next_sequence(self, message: Message) -> int:
        sequence = self._sequences[message.channel.topic]
        self._sequences[message.channel.topic] = sequence + 1
        return sequence

    def close(self) -> None:
        """Write what is queued, complete the file and give it its name. Closing again does nothing.

        Raises
        ------
        RecordingError
            The file could not be written or named; it is left under its ``.active`` name.
        """
        if self._closed:
            return
        self._closed = True
        if rest := self._thinning.rest():
            self._enqueue(rest, self._last_put_ns)
        self._queue.put(None)
        self._thread.join()
        if self._failure is not None:
            raise RecordingError(self._failure)

    def __enter__(self) -> McapRecorder:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        try:
            self.close()
        except RecordingError as err:
            if exc is None:
                raise
            exc.add_note(str(err))  # the first error is the one to report

    def _run(self) -> None:
        flush_at = time.monotonic() + FLUSH_INTERVAL
        while True:
            try:
                batch = self._queue.get(timeout=max(0.0, flush_at - time.monotonic()))
            except queue.Empty:
                pass
            else:
                if batch is None:
                    break
                self._write(batch)
            if time.monotonic() >= flush_at:
                self._flush()
                flush_at = time.monotonic() + FLUSH_INTERVAL
        self._finish()

    def _write(self, batch: _Batch) -> None:
        count = len(batch.messages)
        if self._failure is None:
            try:
                for message, sequence in batch.messages:
                    self._file.add(message, sequence, batch.publish_time_ns)
            except Exception as err:  # whatever it is, the run goes on without its recording
                self._fail(err)
            else:
                self._written += count
                self._unflushed += count
                self._bytes = self._file.size
                return
        self._dropped_failed += count

    def _flush(self) -> None:
        if self._failure is None:
            try:
                self._file.flush()
            except Exception as err:
                self._fail(err)
            else:
                self._unflushed = 0
                self._bytes = self._file.size

    def _finish(self) -> None:
        if self._failure is None:
            try:
                self._bytes = self._file.finish(self._dropped_full)
            except RecordingError as err:
                self._failure = str(err)
            except Exception as err:
                self._fail(err)

    def _fail(self, err: Exception) -> None:
        if isinstance(err, RecordingError):
            self._failure = str(err)
        else:
            self._failure = self._failed(err)
        self._written -= self._unflushed
        self._dropped_failed += self._unflushed
        self._unflushed = 0
        self._file.abandon()

    def _failed(self, err: Exception) -> str:
        reason = (err.strerror if isinstance(err, OSError) else None) or f"{type(err).__name__}: {err}"
        kept = f"what was written is in {self._file.active}, {recovery_hint(self._file.active)}"
        return f"{self.path}: recording failed: {reason}; {kept}"
