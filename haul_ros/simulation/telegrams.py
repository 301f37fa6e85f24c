"""Telegrams on their way to the slaves: acknowledged, sent again, recognised when they come twice or too late."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field

from haul_ros.model.command import Command, CommandKind
from haul_ros.simulation.radio import Attempt, Radio

ROUNDING = 1e-6
"""Part of a time step by which an arrival may miss a step and still count as on it."""


@dataclass(eq=False, slots=True)
class _Telegram:
    """A command with its number on the link to its slave; ``answered``: when the master knows that it got there [s]."""

    number: int
    command: Command
    arrived: bool = False
    answered: float = math.inf

    def __str__(self) -> str:
        return f"{self.command.kind.value} {self.command.value:g}"


@dataclass(order=True, slots=True)
class _Due:
    """What becomes of an attempt: one of its copies arrives, or (``copy`` None) the master's patience ends."""

    step: int
    time: float
    order: int
    telegram: _Telegram = field(compare=False)
    attempt: int = field(compare=False)
    copy: int | None = field(compare=False)


class Telegrams:
    """All that is under way.

    Parameters
    ----------
    radio
        Decides when an attempt arrives, if it does.
    time_step
        Of the simulation [s].
    air_between_steps
        Brake commands act between two time steps, as efforts always do, and not within the one that holds their time.
    carry_out
        Called with the time [s] and the command when a slave is to act.
    heard
        Called with a slave and the time [s] of whatever it gets.
    seen
        Called with the time [s], a slave, and whether its newest telegram was acknowledged, when the master knows.
    log
        Called with the time [s] and what happened, in words.
    """

    def __init__(
        self,
        radio: Radio,
        time_step: float,
        *,
        air_between_steps: bool,
        carry_out: Callable[[float, Command], None],
        heard: Callable[[str, float], None],
        seen: Callable[[float, str, bool], None],
        log: Callable[[float, str], None],
    ) -> None:
        self._radio = radio
        self._time_step = time_step
        self._air_between_steps = air_between_steps
        self._carry_out = carry_out
        self._heard = heard
        self._seen = seen
        self._log = log
        self._order = itertools.count()
        self._due: list[_Due] = []
        self._newest: dict[tuple[str, str], int] = {}

    def __len__(self) -> int:
        return len(self._due)

    @property
    def pending(self) -> bool:
        """Whether any is to arrive, or may be sent again: one that is acknowledged will not."""
        return any(due.copy is not None or due.telegram.answered > due.time for due in self._due)

    @property
    def next_step(self) -> int | None:
        """The time step at which something becomes of one of them; None: nothing is under way."""
        return self._due[0].step if self._due else None

    def send(self, command: Command, step: int, time: float) -> None:
        """Send a command to the slave that it names, at a time step and its time [s]."""
        slave = command.locomotive
        telegram = _Telegram(self._radio.counts[slave].sent, command)
        self._sent(telegram, 0, step, time, self._radio.first_attempt(slave, time))

    def has_emergency_coming(self, slave: str) -> bool:
        """The last telegram on its way to a slave that says anything of an emergency starts one."""
        coming = [
            due
            for due in self._due
            if due.copy is not None
            and due.telegram.command.locomotive == slave
            and due.telegram.command.kind is CommandKind.EMERGENCY
        ]
        return bool(coming) and max(coming).telegram.command.value != 0.0

    def carry_out_due(self, step: int, time: float) -> None:
        """Let happen what is due at a time step and its time [s]."""
        while self._due and self._due[0].step <= step:
            due = heapq.heappop(self._due)
            if due.copy is None:
                self._wait_is_over(due, step)
            else:
                self._arrive(due, due.copy, max(due.time, time))

    def _sent(self, telegram: _Telegram, attempt: int, step: int, time: float, fate: Attempt) -> None:
        slave = telegram.command.locomotive
        if fate.arrival is None:
            self._log(time, f"{slave}: telegram lost: {telegram}")
        for copy, arrival in enumerate(fate):
            if arrival is not None:
                self._expect(telegram, attempt, copy, step, arrival)
        link = self._radio.link(slave)
        if link.retries:
            self._expect(telegram, attempt, None, step, time + link.retry_interval)

    def _expect(self, telegram: _Telegram, attempt: int, copy: int | None, step: int, time: float) -> None:
        steps = time / self._time_step
        # A wave starts within the step that holds its time; tractive effort and air change between steps.
        late = telegram.command.kind.is_effort or self._air_between_steps
        due = math.ceil(steps - ROUNDING) if late else math.floor(steps + ROUNDING)
        heapq.heappush(self._due, _Due(max(due, step), time, next(self._order), telegram, attempt, copy))

    def _arrive(self, due: _Due, copy: int, time: float) -> None:
        telegram, slave = due.telegram, due.telegram.command.locomotive
        link = self._radio.link(slave)
        self._heard(slave, time)
        if link.retries:
            back = self._radio.acknowledge(slave, telegram.number, due.attempt, copy, due.time)
            if back is None:
                self._log(time, f"{slave}: acknowledgement lost: {telegram}")
            else:
                telegram.answered = min(back, telegram.answered)
        self._act(telegram, time)

    def _act(self, telegram: _Telegram, time: float) -> None:
        slave, kind = telegram.command.locomotive, telegram.command.kind
        counts = self._radio.counts[slave]
        # Of traction and electric brake the newer counts, so they are one kind here.
        stream = slave, "effort" if kind.is_effort else kind.value
        if telegram.arrived:
            counts.duplicates += 1
            self._log(time, f"{slave}: duplicate ignored: {telegram}")
        elif telegram.number < self._newest.get(stream, 0):
            counts.out_of_order += 1
            self._log(time, f"{slave}: out of order, ignored: {telegram}")
        else:
            self._newest[stream] = telegram.number
            self._carry_out(time, telegram.command)
        telegram.arrived = True

    def _wait_is_over(self, due: _Due, step: int) -> None:
        telegram, slave = due.telegram, due.telegram.command.locomotive
        link, counts = self._radio.link(slave), self._radio.counts[slave]
        answered = telegram.answered <= due.time
        if not answered and due.attempt < link.retries:
            self._log(due.time, f"{slave}: sent again, {due.attempt + 1} of {link.retries}: {telegram}")
            fate = self._radio.retry(slave, telegram.number, due.attempt + 1, due.time)
            self._sent(telegram, due.attempt + 1, step, due.time, fate)
            return
        if not answered:
            counts.given_up += 1
            self._log(due.time, f"{slave}: given up, not acknowledged: {telegram}")
        if telegram.number == counts.sent - 1:
            self._radio.told(slave, lost=not answered)
            self._seen(due.time, slave, answered)
