"""Events of a run, the same live and in batch: some known exactly, others seen from sample to sample."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from haul_ros.model.event import Event, EventKind
from haul_ros.model.sample import Sample
from haul_ros.simulation.session import Session
from haul_ros.units import NS_PER_S, seconds_to_ns

SLACK_SPEED = 0.1
"""Least relative speed [m/s] at which a closing gap is an event: the mean over the sample period in which it closes."""


class EventWatch:
    """Looks at a session once per sample period.

    Exact in time: emergencies, radio, closed draft gears, the stop of the whole train. Seen at the end of the sample
    period: brake waves at locomotives and the tail, closing slack, vehicles that stop. Whatever happens at several
    couplers or vehicles within one period is one event.
    """

    def __init__(self, session: Session) -> None:
        consist = session.consist
        self._session = session
        self._coupler_names, self._vehicle_names = consist.coupler_names, consist.vehicle_names
        last = len(consist.vehicles) - 1
        self._watched = {last: f"tail, {consist.vehicle_names[last]}"}
        self._watched |= {locomotive.vehicle: locomotive.name for locomotive in consist.locomotives}
        self._half_slack = np.array([gear.slack / 2.0 if gear else 0.0 for gear in consist.couplers])
        self._has_slack = bool(self._half_slack.any())
        self._before = session.sample()
        self._targets = session.brake_targets()
        self._bottomed = session.bottomed_times()
        self._standing = session.at_standstill

    def look(self, sample: Sample) -> tuple[Event, ...]:
        """Events since the last look, in order of time; ``sample`` is the present one."""
        found = [
            *self._session.take_events(),
            *self._waves(sample),
            *self._newly_bottomed(),
            *self._closed_slack(sample),
            *self._stops(sample),
        ]
        self._before = sample
        return tuple(sorted(found, key=lambda event: event.time_ns))

    def _waves(self, sample: Sample) -> list[Event]:
        before, self._targets = self._targets, self._session.brake_targets()
        return [
            Event(sample.time_ns, EventKind.WAVE, f"{name}: brake wave: {_told(before[i], self._targets[i])}")
            for i, name in self._watched.items()
            if before[i] != self._targets[i]
        ]

    def _newly_bottomed(self) -> list[Event]:
        before, self._bottomed = self._bottomed, self._session.bottomed_times()
        new = np.flatnonzero(np.isnan(before) & ~np.isnan(self._bottomed))
        if not len(new):
            return []
        found = []
        for time in np.unique(self._bottomed[new]):
            at = _named(new[self._bottomed[new] == time], self._coupler_names)
            found.append(Event(seconds_to_ns(time), EventKind.BOTTOMED, f"{at}: draft gear closed fully"))
        return found

    def _closed_slack(self, sample: Sample) -> list[Event]:
        elapsed = (sample.time_ns - self._before.time_ns) / NS_PER_S
        if elapsed == 0.0 or not self._has_slack:
            return []
        found = []
        for side, word in ((1.0, "run-in"), (-1.0, "run-out")):
            before, now = side * self._before.stroke, side * sample.stroke
            speed = (now - before) / elapsed
            closed = (before < self._half_slack) & (now >= self._half_slack) & (speed > SLACK_SPEED)
            if len(at := np.flatnonzero(closed & (self._half_slack > 0.0))):
                what = f"slack {word} at up to {speed[at].max():.2f} m/s"
                found.append(Event(sample.time_ns, EventKind.SLACK, f"{_named(at, self._coupler_names)}: {what}"))
        return found

    def _stops(self, sample: Sample) -> list[Event]:
        found = []
        if len(at := np.flatnonzero((self._before.speed != 0.0) & (sample.speed == 0.0))):
            found.append(Event(sample.time_ns, EventKind.STOPPED, f"{_named(at, self._vehicle_names)}: stopped"))
        stood, self._standing = self._standing, self._session.at_standstill
        stop_time = self._session.stop_time
        if stop_time is not None and not stood:
            found.append(Event(seconds_to_ns(stop_time), EventKind.STOPPED, "train: stopped"))
        return found


def _told(before: float, target: float) -> str:
    """What a wave told a vehicle's valve, by the cylinder pressures before and after as fractions of emergency's."""
    if target == 1.0:
        return "emergency"
    return f"{'service application' if target > before else 'release'} to {100.0 * target:.0f} % of emergency"


def _named(indices: Iterable[int], names: Sequence[str]) -> str:
    """Names of rising indices, neighbours as ranges."""
    runs: list[list[int]] = []
    for index in indices:
        if runs and index == runs[-1][1] + 1:
            runs[-1][1] = index
        else:
            runs.append([index, index])
    return ", ".join(names[a] if a == b else f"{names[a]} to {names[b]}" for a, b in runs)
