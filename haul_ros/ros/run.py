"""One run of the train, from its start to a reset or the end of the node: simulated, published, recorded."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from haul_ros.errors import CommandError
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import Request
from haul_ros.recording.writer import McapRecorder
from haul_ros.ros.diagnostics import RunReport, statuses
from haul_ros.ros.timing import LoopTiming
from haul_ros.ros.unrecorded import Unrecorded
from haul_ros.simulation.session import Session

Publish = Callable[[Sequence[Message]], None]


class TrainRun:
    """A session with its outputs; not thread-safe, the loop owns it.

    Everything that is published but what is ``unrecorded`` is given to the recorder too, in the same bytes; what the
    node only receives, and the scenario's own commands, are recorded only. ``recorder`` None: nothing is recorded.
    What is unrecorded, the clock first, goes out ahead of each sample. ``tell`` is called with the end of the
    recording in words.
    """

    def __init__(
        self,
        session: Session,
        encoder: TelemetryEncoder,
        publish: Publish,
        recorder: McapRecorder | None,
        *,
        unrecorded: Unrecorded | None = None,
        tell: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._session = session
        self._encoder = encoder
        self._publish = publish
        self._recorder = recorder
        self._unrecorded = unrecorded
        self._tell = tell
        self._accepted = 0
        self._rejected = 0

    @property
    def time_ns(self) -> int:
        """Simulation time [ns]."""
        return self._session.time_ns

    @property
    def steps_per_sample(self) -> int:
        """Integration steps of one period."""
        return self._session.steps_per_sample

    def start(self) -> None:
        """Publish the state before the first step, that of the radio links included."""
        self._put_log()

    def advance(self, stop: Callable[[], bool] = lambda: False) -> int:
        """Simulate one sample period and publish its end; returns the wall time [ns] that the integration took.

        A ``stop`` ends the period early.
        """
        began_ns = time.monotonic_ns()
        self._session.advance(stop=stop)
        ended_ns = time.monotonic_ns()
        self._put_log()
        return ended_ns - began_ns

    def request(self, request: Request) -> None:
        """Let a command, a change of a radio link or a fault take effect at the present simulation time.

        Raises
        ------
        CommandError
            It cannot be carried out; nothing has changed but the count of what was rejected.
        """
        try:
            self._session.request(request)
        except CommandError:
            self._rejected += 1
            raise
        self._accepted += not isinstance(request, RadioLinkChange)
        self._put_log()

    def report(self, timing: LoopTiming, *, paused: bool, replaced: int, refused: int) -> None:
        """Publish the real-time factor and the diagnostics, with the counts of requests that have not come here."""
        session = self._session
        report = RunReport(
            node=self._encoder.channels.prefix,
            scenario=session.scenario.name,
            time=session.time,
            paused=paused,
            timing=timing,
            session=session.status(),
            accepted=self._accepted,
            rejected=self._rejected + refused,
            replaced=replaced,
            recorder=self._recorder.status if self._recorder else None,
        )
        self._put(
            [
                self._encoder.real_time_factor(self.time_ns, timing.real_time_factor),
                self._encoder.diagnostics(self.time_ns, statuses(report)),
            ]
        )

    def close(self) -> None:
        """Publish what is left, the last extremes among it, and finish the recording.

        Raises
        ------
        RecordingError
            The recording could not be written whole.
        """
        try:
            self._put_log(last=True)
        finally:
            if self._recorder:
                self._recorder.close()
                self._tell(self._end_of(self._recorder))

    def _end_of(self, recorder: McapRecorder) -> str:
        status = recorder.status
        whole = f"incomplete, {status.dropped} messages dropped" if status.dropped else "complete"
        return f"{recorder.path}: recording {whole}: {status.written} messages of {self._session.time:.3f} s"

    def _put_log(self, *, last: bool = False) -> None:
        log = self._session.take_log(last=last)
        if log.sample is not None and self._unrecorded:
            self._publish(self._unrecorded.messages(log.sample))
        if messages := self._encoder.messages(log):
            self._put(messages)

    def _put(self, messages: Sequence[Message]) -> None:
        self._publish([message for message in messages if not message.channel.received])
        if self._recorder:
            self._recorder.put(messages, time.time_ns())
