"""One run of the train, from its start to a reset or the end of the node: simulated, published, recorded."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from haul_ros.errors import CommandError
from haul_ros.messages.cdr import CLOCK, encode_clock
from haul_ros.messages.channels import EVENT, Channel
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.command import Command
from haul_ros.model.sample import Sample
from haul_ros.recording.writer import McapRecorder
from haul_ros.ros.diagnostics import RunReport, statuses
from haul_ros.ros.timing import LoopTiming
from haul_ros.simulation.events import EventWatch
from haul_ros.simulation.session import Session
from haul_ros.units import NS_PER_S

CLOCK_CHANNEL = Channel("/clock", CLOCK, EVENT._replace(depth=1))

Publish = Callable[[Sequence[Message]], None]

EXTREMES_PERIOD_NS = NS_PER_S
"""Simulation time between two publications of the running extremes."""


class TrainRun:
    """A session with its outputs; not thread-safe, the loop owns it.

    Everything that is published but the clock is recorded too, in the same bytes; commands, the
    scenario's own among them, are recorded only. ``recorder`` None: nothing is recorded. With
    ``publish_clock`` the simulation time goes out ahead of each sample.
    """

    def __init__(
        self,
        session: Session,
        encoder: TelemetryEncoder,
        publish: Publish,
        recorder: McapRecorder | None,
        *,
        publish_clock: bool = False,
    ) -> None:
        self._session = session
        self._watch = EventWatch(session)
        self._encoder = encoder
        self._publish = publish
        self._recorder = recorder
        self._publish_clock = publish_clock
        self._extremes_due_ns = 0
        self._extremes_told_ns = -1
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

    def tell_start(self) -> None:
        """Publish the state before the first step, that of the radio links included."""
        self._tell_requests()
        self._tell_sample(self._session.sample())

    def advance(self) -> int:
        """Simulate one sample period and publish its end; returns the wall time [ns] that the integration took."""
        began_ns = time.monotonic_ns()
        sample = self._session.advance()
        ended_ns = time.monotonic_ns()
        self._tell_sample(sample)
        return ended_ns - began_ns

    def command(self, command: Command) -> None:
        """Let a command take effect at the present simulation time.

        Raises
        ------
        CommandError
            It cannot be carried out; nothing has changed but the count of rejected commands.
        """
        try:
            self._session.command(command)
        except CommandError:
            self._rejected += 1
            raise
        self._accepted += 1
        self._tell_requests()

    def set_radio(self, slave: str, delay: float | None = None, connected: bool | None = None) -> None:
        """Change what is given of the link to a slave, for the commands from now on; delay in [s]."""
        link = self._session.radio_link(slave)
        if delay is not None:
            link = replace(link, delay=delay)
        if connected is not None:
            link = replace(link, connected=connected)
        self._session.set_radio_link(slave, link)
        self._tell_requests()

    def report(self, timing: LoopTiming, *, paused: bool) -> None:
        """Publish the real-time factor and the diagnostics."""
        session = self._session
        report = RunReport(
            time=session.time,
            paused=paused,
            timing=timing,
            session=session.status(),
            accepted=self._accepted,
            rejected=self._rejected,
            recorder=self._recorder.status if self._recorder else None,
        )
        self._tell(
            [
                self._encoder.real_time_factor(self.time_ns, timing.real_time_factor),
                self._encoder.diagnostics(self.time_ns, statuses(report)),
            ]
        )

    def close(self) -> None:
        """Publish the last extremes and finish the recording.

        Raises
        ------
        RecordingError
            The recording could not be written whole.
        """
        try:
            if self._extremes_told_ns != self.time_ns:
                self._tell_extremes()
        finally:
            if self._recorder:
                self._recorder.close()

    def _tell_sample(self, sample: Sample) -> None:
        if self._publish_clock:
            self._publish([Message(CLOCK_CHANNEL, sample.time_ns, encode_clock(sample.time_ns))])
        self._tell_requests()
        if events := self._watch.look(sample):
            self._tell([self._encoder.event(event) for event in events])
        self._tell(self._encoder.sample(sample))
        if sample.time_ns >= self._extremes_due_ns:
            self._tell_extremes()
            self._extremes_due_ns = (sample.time_ns // EXTREMES_PERIOD_NS + 1) * EXTREMES_PERIOD_NS

    def _tell_extremes(self) -> None:
        self._tell(self._encoder.extremes(self.time_ns, self._session.extremes()))
        self._extremes_told_ns = self.time_ns

    def _tell_requests(self) -> None:
        """Record what was commanded, the scenario's own commands included; publish what it led to, and the links."""
        if taken := self._session.take_commands():
            self._record([self._encoder.command(t.time_ns, t.command) for t in taken])
        if applied := self._session.take_applied_brakes():
            self._tell([self._encoder.applied_brake(a.time_ns, a.locomotive, a.value) for a in applied])
        for taken_link in self._session.take_links():
            link = taken_link.link
            self._tell(self._encoder.radio(taken_link.time_ns, taken_link.slave, link.connected, link.delay))

    def _tell(self, messages: Sequence[Message]) -> None:
        self._publish(messages)
        self._record(messages)

    def _record(self, messages: Sequence[Message]) -> None:
        if self._recorder:
            self._recorder.put(messages, time.time_ns())
