"""Events that show from one state of the train to the next, the same live and in batch."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.brake_system import BrakeSystem
from haul_ros.model.consist import Consist
from haul_ros.model.event import Event, EventKind
from haul_ros.model.sample import FloatArray, Sample
from haul_ros.model.track import Track
from haul_ros.physics.train_model import ValveState
from haul_ros.simulation.applications import ApplicationWatch
from haul_ros.simulation.overspeed import OverspeedWatch
from haul_ros.simulation.releases import ReleaseWatch
from haul_ros.units import NS_PER_S, mps_to_kmh, seconds_to_ns

SLACK_SPEED = 0.1
"""Least relative speed [m/s] at which a closing gap is an event: the mean over the sample period in which it closes."""


@dataclass(frozen=True, slots=True, eq=False)
class TrainState:
    """What events are detected in.

    ``brake_targets`` (n_vehicles,): what each brake is to reach by the last wave, fractions of emergency
    pressure. ``bottomed_times`` (n_couplers,): when each draft gear first closed fully [s], NaN: never.
    ``stop_time``: when the last vehicle came to rest [s], None while the train moves. ``valves``: of a pneumatic brake.
    ``parted`` (n_couplers,): couplers that bear no draft any more; None: there are none.
    """

    sample: Sample
    brake_targets: FloatArray
    bottomed_times: FloatArray
    stop_time: float | None
    valves: ValveState | None = None
    parted: NDArray[np.bool_] | None = None


CONTACT = 1e-3
"""Least gap [m] of a parted coupler from which meeting again is an event."""


class EventDetector:
    """Compares the state of a train with the one before, once per sample period.

    Exact in time: closed draft gears, the stop of the whole train. Stamped with the end of the sample period: brake
    waves at locomotives and the tail, closing slack, vehicles that stop, the start of an overspeed. Whatever happens at
    several couplers or vehicles within one period is one event.
    """

    def __init__(
        self,
        consist: Consist,
        start: TrainState,
        track: Track | None = None,
        brakes: BrakeSystem | PneumaticBrake | None = None,
    ) -> None:
        self._coupler_names, self._vehicle_names = consist.coupler_names, consist.vehicle_names
        last = len(consist.vehicles) - 1
        self._watched = {last: f"tail, {consist.vehicle_names[last]}"}
        self._watched |= {locomotive.vehicle: locomotive.name for locomotive in consist.locomotives}
        self._half_slack = np.array([gear.slack / 2.0 if gear else 0.0 for gear in consist.couplers])
        self._has_slack = bool(self._half_slack.any())
        self._before = start
        self._applications = None
        if isinstance(brakes, PneumaticBrake):
            self._applications = ApplicationWatch(consist, brakes, partial(_named, names=self._vehicle_names))
        self._releases = ReleaseWatch(len(consist.vehicles))
        self.released = np.zeros(len(consist.vehicles), dtype=bool)
        """Vehicles whose pneumatic brake has released without a command so far."""
        self.overspeed = OverspeedWatch(consist, track or Track())
        """What of the train was faster than the line allows so far."""

    def update(self, now: TrainState) -> list[Event]:
        """Events between the last state and the present one."""
        before, self._before = self._before, now
        return [
            *self._waves(before, now),
            *self._valves(before.valves, now),
            *self._not_held(now),
            *self._newly_bottomed(before, now),
            *self._closed_slack(before.sample, now),
            *self._collisions(before.sample, now),
            *self._stops(before, now),
            *self._overspeed(now.sample),
        ]

    def rest(self, time_ns: int) -> list[Event]:
        """Events that wait for more of their kind, for the end of a run at a time [ns]."""
        return [] if self._applications is None else self._applications.rest(time_ns)

    def _waves(self, before: TrainState, now: TrainState) -> list[Event]:
        old, new = before.brake_targets, now.brake_targets
        return [
            Event(now.sample.time_ns, EventKind.WAVE, f"{name}: brake wave: {_application(old[i], new[i])}")
            for i, name in self._watched.items()
            if old[i] != new[i]
        ]

    def _valves(self, before: ValveState | None, now: TrainState) -> list[Event]:
        """Control valves of a pneumatic brake: what they do at locomotives and the tail, anywhere what nobody asked."""
        valves, time_ns = now.valves, now.sample.time_ns
        if before is None or valves is None:
            return []
        found = [
            Event(
                time_ns, EventKind.WAVE, f"{name}: control valve: {'application' if valves.applied[i] else 'release'}"
            )
            for i, name in self._watched.items()
            if before.applied[i] != valves.applied[i]
        ]
        tripped, released = valves.emergency & ~before.emergency, self._releases.unasked(before, valves, now.sample)
        if tripped.any() and not (valves.emergency_commanded or before.emergency_commanded):
            at = _named(np.flatnonzero(tripped), self._vehicle_names)
            found.append(Event(time_ns, EventKind.VALVE, f"{at}: undesired emergency: no locomotive has asked for it"))
        if released.any():
            self.released |= released
            at = _named(np.flatnonzero(released), self._vehicle_names)
            found.append(Event(time_ns, EventKind.VALVE, f"{at}: unintended release: no locomotive has asked for it"))
        return found

    def _not_held(self, now: TrainState) -> list[Event]:
        if self._applications is None or now.valves is None:
            return []
        return self._applications.update(now.sample, now.valves)

    def _newly_bottomed(self, before: TrainState, now: TrainState) -> list[Event]:
        times = now.bottomed_times
        new = np.flatnonzero(np.isnan(before.bottomed_times) & ~np.isnan(times))
        found = []
        for time in np.unique(times[new]) if len(new) else ():
            at = _named(new[times[new] == time], self._coupler_names)
            found.append(Event(seconds_to_ns(time), EventKind.BOTTOMED, f"{at}: draft gear closed fully"))
        return found

    def _collisions(self, before: Sample, state: TrainState) -> list[Event]:
        """Parts of a separated train that meet again, from a gap at which their draft gears were free."""
        if state.parted is None or not state.parted.any():
            return []
        now, half_slack = state.sample, self._half_slack
        closed = (before.stroke < np.minimum(half_slack, 0.0) - CONTACT) & (now.stroke >= half_slack)
        return [
            Event(
                now.time_ns,
                EventKind.SEPARATION,
                f"{self._coupler_names[k]}: the parts have met again at {before.stroke_rate[k]:.2f} m/s",
            )
            for k in np.flatnonzero(state.parted & closed)
        ]

    def _closed_slack(self, before: Sample, state: TrainState) -> list[Event]:
        now = state.sample
        elapsed = (now.time_ns - before.time_ns) / NS_PER_S
        if elapsed == 0.0 or not self._has_slack:
            return []
        found = []
        for side, word in ((1.0, "run-in"), (-1.0, "run-out")):
            old, new = side * before.stroke, side * now.stroke
            speed = (new - old) / elapsed
            bears = side > 0.0 or state.parted is None or ~state.parted  # a parted coupler opens, it does not run out
            closed = bears & (old < self._half_slack) & (new >= self._half_slack) & (speed > SLACK_SPEED)
            if len(at := np.flatnonzero(closed & (self._half_slack > 0.0))):
                what = f"slack {word} at up to {speed[at].max():.2f} m/s"
                found.append(Event(now.time_ns, EventKind.SLACK, f"{_named(at, self._coupler_names)}: {what}"))
        return found

    def _stops(self, before: TrainState, now: TrainState) -> list[Event]:
        found = []
        if len(at := np.flatnonzero((before.sample.speed != 0.0) & (now.sample.speed == 0.0))):
            stopped = f"{_named(at, self._vehicle_names)}: stopped"
            found.append(Event(now.sample.time_ns, EventKind.STOPPED, stopped))
        if now.stop_time is not None and before.stop_time is None:
            found.append(Event(seconds_to_ns(now.stop_time), EventKind.STOPPED, "train: stopped"))
        return found

    def _overspeed(self, now: Sample) -> list[Event]:
        found = self.overspeed.update(now.time_ns, now.chainage, now.speed)
        if found is None:
            return []
        limit, excess = mps_to_kmh(found.limit), mps_to_kmh(found.excess)
        what = (
            f"{mps_to_kmh(found.speed):.1f} km/h at {found.chainage:.1f} m, {excess:.1f} over the limit of {limit:.0f}"
        )
        return [Event(found.time_ns, EventKind.OVERSPEED, f"{self._vehicle_names[found.vehicle]}: {what}")]


def _application(before: float, target: float) -> str:
    """What a wave asks of a vehicle's valve, by the cylinder pressures before and after as fractions of emergency's."""
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
