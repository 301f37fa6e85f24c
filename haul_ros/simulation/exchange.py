"""All radio of a run: commands to the slaves, outages, status telegrams, and what a slave makes of a lost link."""

from __future__ import annotations

import math
from collections.abc import Callable

from haul_ros.errors import CommandError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.consist import MASTER
from haul_ros.model.event import Event, EventKind
from haul_ros.model.log import LogEntry, RadioSeen
from haul_ros.model.radio import RadioLink, RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.model.scenario import Scenario
from haul_ros.simulation.heartbeats import Heartbeats
from haul_ros.simulation.locomotives import Locomotives
from haul_ros.simulation.outages import Outages
from haul_ros.simulation.radio import LinkStatus, Radio
from haul_ros.simulation.telegrams import ROUNDING, Telegrams
from haul_ros.units import seconds_to_ns

_IN_WORDS = {"hold": "it holds", "idle": "it idles", "apply": "it applies full service"}


class Exchange:
    """What goes between master and slaves; never looks further than the present time step, of which it is told.

    Parameters
    ----------
    scenario
        With the links.
    locomotives
        Carry out what arrives.
    place
        Where a locomotive is now [m], and its speed [m/s], by name.
    air_between_steps
        As for `Telegrams`.
    log
        Takes changes and events.
    """

    def __init__(
        self,
        scenario: Scenario,
        locomotives: Locomotives,
        place: Callable[[str], tuple[float, float]],
        *,
        air_between_steps: bool,
        log: list[LogEntry],
    ) -> None:
        self._locomotives = locomotives
        self._log = log
        self._time_step = scenario.time_step
        self._next_look = 0
        self._time = 0.0
        self._outages = Outages(scenario.radio, MASTER, place)
        self._outage: dict[str, str] = dict.fromkeys(self._outages.slaves, "")
        self._radio = Radio(scenario.radio, scenario.radio_seed, self._outages.out)
        self._heartbeats = Heartbeats(scenario.radio, self._radio.heartbeat, self._hear)
        self._telegrams = Telegrams(
            self._radio,
            scenario.time_step,
            air_between_steps=air_between_steps,
            carry_out=locomotives.carry_out,
            heard=self._heartbeats.heard,
            seen=self._acknowledged,
            log=self._note,
        )
        self._slaves = tuple(scenario.radio)
        self._given_up = dict.fromkeys(scenario.radio, False)
        for slave in self._slaves:
            log += [RadioSeen(0, slave, "heard", True), RadioSeen(0, slave, "acknowledged", True)]
        for slave, link in scenario.radio.items():
            if not link.reaches:
                self._tell(slave)

    @property
    def under_way(self) -> int:
        """How many telegrams are to arrive or to be acknowledged."""
        return len(self._telegrams)

    @property
    def pending(self) -> bool:
        """Whether any telegram is to arrive, or may be sent again."""
        return self._telegrams.pending

    def link(self, slave: str) -> RadioLink:
        """The link to a slave."""
        return self._radio.link(slave)

    def status(self, time: float) -> dict[str, LinkStatus]:
        """State of every link at a time [s], by slave."""
        return self._radio.status(time)

    def has_emergency_coming(self, slave: str) -> bool:
        """See `Telegrams.has_emergency_coming`."""
        return self._telegrams.has_emergency_coming(slave)

    def send(self, command: Command, step: int, time: float) -> None:
        """Send a command to the slave that it names, now."""
        self._telegrams.send(command, step, time)

    def change(self, change: RadioLinkChange, time: float) -> None:
        """Change a link at a time [s].

        Raises
        ------
        CommandError
            There is no such slave, or there can be no such link; nothing has changed then.
        """
        if change.slave not in self._slaves:
            known = ", ".join(self._slaves) or "none"
            raise CommandError(f"{change.slave}: no such slave locomotive, this train has {known}")
        before = self._radio.link(change.slave)
        try:
            link = change.applied_to(before)
        except ValueError as error:
            raise CommandError(f"{change.slave}: {error}") from error
        self._time = time
        self._log.append(TimedRequest(seconds_to_ns(time), change))
        if link.connected != before.connected:
            self._note(time, f"{change.slave}: radio link {'up' if link.connected else 'down'}")
        if link.fails != before.fails:
            what = {"none": "both directions work", "to_slave": "nothing reaches it", "from_slave": "no answers come"}
            self._note(time, f"{change.slave}: radio link: {what[link.fails]}")
        self._radio.set_link(change.slave, link)
        self._tell(change.slave)

    def next_step(self, step: int) -> int:
        """The next time step at which anything happens, after a present one at which all is done."""
        due = [self._telegrams.next_step]
        due += [self._next_look] if self._outage else []
        if (next_time := self._heartbeats.next_time) < math.inf:
            due.append(math.ceil(next_time / self._time_step - ROUNDING))
        # Rounding must not make a step of what was done at the present one: the train would never go on.
        return max(step + 1, min((found for found in due if found is not None), default=step + 2**62))

    def carry_out_due(self, step: int, time: float) -> None:
        """Let happen what is due at a time step and its time [s]."""
        self._time = time
        if self._outage and self._next_look <= step:
            self._look(time + ROUNDING * self._time_step)
            self._next_look = self._outages.next_look(step, self._time_step)
        self._heartbeats.carry_out_due(time + ROUNDING * self._time_step)
        self._telegrams.carry_out_due(step, time)

    def _look(self, time: float) -> None:
        for slave, before in self._outage.items():
            why = self._outages.why(slave, time)
            if bool(why) != bool(before):
                text = f"{slave}: radio outage {'begins' if why else 'ends'}: {why or before}"
                self._note(self._time, text)
                self._outage[slave] = why
                self._tell(slave)

    def _hear(self, slave: str, lost: bool) -> None:
        link = self._radio.link(slave)
        self._log.append(RadioSeen(seconds_to_ns(self._time), slave, "heard", not lost))
        if not lost:
            self._note(self._time, f"{slave}: heard the master again")
            self._tell(slave)
            return
        self._note(self._time, f"{slave}: heard nothing for {link.link_timeout:g} s: {_IN_WORDS[link.link_lost]}")
        self._tell(slave)
        if link.link_lost == "idle":
            self._locomotives.carry_out(self._time, Command(slave, CommandKind.TRACTION, 0.0))
        elif link.link_lost == "apply":
            self._locomotives.carry_out(self._time, Command(slave, CommandKind.BRAKE, 1.0))

    def _acknowledged(self, time: float, slave: str, answered: bool) -> None:
        if answered == self._given_up[slave]:
            self._given_up[slave] = not answered
            self._log.append(RadioSeen(seconds_to_ns(time), slave, "acknowledged", answered))
            if answered:
                self._note(time, f"{slave}: acknowledges again")

    def _tell(self, slave: str) -> None:
        """Let a slave listen to its brake pipe while it cannot be reached."""
        up = self._radio.link(slave).reaches and not self._outage.get(slave) and not self._heartbeats.lost(slave)
        self._locomotives.set_radio_link(slave, up)

    def _note(self, time: float, text: str) -> None:
        self._log.append(Event(seconds_to_ns(time), EventKind.RADIO, text))
