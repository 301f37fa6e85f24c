"""The essence of a run: when and where it stopped, its peaks, energy and numerics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from haul_ros.analysis.envelopes import bottomed_couplers
from haul_ros.model.consist import Consist
from haul_ros.model.sample import CouplerExtremes, FloatArray
from haul_ros.model.scenario import Scenario
from haul_ros.physics.energy import EnergyBalance
from haul_ros.physics.train_model import StepStatistics
from haul_ros.recording.series import VehicleSeries
from haul_ros.simulation.overspeed import Overspeeds, OverspeedWatch
from haul_ros.simulation.radio import LinkStatus
from haul_ros.simulation.session import Session
from haul_ros.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class CouplerPeak:
    """A largest value over all couplers.

    ``value`` is a force [N] or stroke [m], as a magnitude; ``between`` names the vehicles before
    and behind; ``position`` is that of the coupler, j/N for the j-th of a train of N vehicles;
    ``time`` [s] is when it occurred (None: not known).
    """

    value: float
    coupler: str
    between: tuple[str, str]
    position: float
    time: float | None


@dataclass(frozen=True, slots=True)
class RunSummary:
    """What a run gave, in SI units.

    ``duration`` [s] is what was simulated; ``stop_time`` [s] is when the last vehicle came to rest,
    None if the train was moving at the end, then with ``final_speed`` [m/s]; ``distance`` [m] is
    what the head travelled. Peaks are taken at every time step, None where no coupler bore any.
    ``stop_time_resolution`` [s] is how exactly the stop time is known. ``radio`` has what went over
    each link, by slave. A recording has no ``energy``, no ``solver`` and no ``radio`` (None).
    ``overspeeds``: speed over the limits of the line, in the samples.
    ``real_time_factor`` is simulated over wall time, None if it was not measured.
    """

    scenario: str
    description: str
    vehicles: int
    couplers: int
    mass: float
    length: float
    initial_speed: float
    duration: float
    stop_time: float | None
    stop_time_resolution: float
    final_speed: float
    distance: float
    compression: CouplerPeak | None
    tension: CouplerPeak | None
    compression_stroke: CouplerPeak | None
    tension_stroke: CouplerPeak | None
    bottomed: tuple[str, ...]
    overspeeds: Overspeeds
    energy: EnergyBalance | None
    solver: StepStatistics | None
    real_time_factor: float | None
    radio: Mapping[str, LinkStatus] | None
    caveats: tuple[str, ...]

    @property
    def stroke(self) -> CouplerPeak | None:
        """The larger of the largest strokes in compression and tension."""
        strokes = [peak for peak in (self.compression_stroke, self.tension_stroke) if peak]
        return max(strokes, key=lambda peak: peak.value, default=None)


def peak(consist: Consist, values: FloatArray, times: FloatArray | None = None) -> CouplerPeak | None:
    """The largest of one value per coupler, the first of equals; None if none is above 0."""
    if not len(values) or np.max(values) <= 0.0:
        return None
    j = int(np.argmax(values))
    names = consist.vehicle_names
    return CouplerPeak(
        value=float(values[j]),
        coupler=consist.coupler_names[j],
        between=(names[j], names[j + 1]),
        position=(j + 1) / len(names),
        time=None if times is None else float(times[j]),
    )


def summarize_session(session: Session, wall_time: float | None = None) -> RunSummary:
    """Summary of a session as it stands, after ``wall_time`` [s] of computing (None: not measured)."""
    return _summary(
        session.scenario,
        session.extremes(),
        duration=session.time,
        stop_time=session.stop_time,
        stop_time_resolution=session.scenario.time_step,
        final_speed=float(session.sample().speed[0]),
        distance=session.travelled,
        overspeeds=session.overspeeds(),
        energy=session.energy(),
        solver=session.status().solver,
        real_time_factor=session.time / wall_time if wall_time else None,
        radio=session.status().radio,
    )


def summarize_journey(scenario: Scenario, journey: Journey, extremes: CouplerExtremes) -> RunSummary:
    """Summary of a run from a journey of at least one sample, and the extremes of all couplers."""
    assert journey.times_ns is not None
    return _summary(
        scenario,
        extremes,
        duration=(journey.times_ns[1] - journey.times_ns[0]) / NS_PER_S,
        stop_time=None if journey.standing_since_ns is None else journey.standing_since_ns / NS_PER_S,
        stop_time_resolution=1.0 / scenario.record_rate,
        final_speed=journey.final_speed,
        distance=journey.chainage[1] - journey.chainage[0],
        overspeeds=journey.watch.found,
        energy=None,
        solver=None,
        real_time_factor=None,
        radio=None,
    )


class Journey:
    """What a summary needs of the vehicles' samples, taken piece by piece.

    ``times_ns`` and ``chainage`` [m] are those of the head in the first and the last sample; ``standing_since_ns`` is
    the time of the first sample from which on every vehicle stands, None if one moves in the last.
    """

    def __init__(self, watch: OverspeedWatch) -> None:
        self.watch = watch
        self.times_ns: tuple[int, int] | None = None
        self.chainage = (0.0, 0.0)
        self.standing_since_ns: int | None = None
        self.final_speed = 0.0

    def add(self, vehicles: VehicleSeries) -> None:
        """The next samples."""
        if not len(vehicles.time_ns):
            return
        time_ns, head = vehicles.time_ns, vehicles.chainage[:, 0]
        first_ns, first = (self.times_ns[0], self.chainage[0]) if self.times_ns else (int(time_ns[0]), float(head[0]))
        self.times_ns, self.chainage = (first_ns, int(time_ns[-1])), (first, float(head[-1]))
        self.final_speed = float(vehicles.speed[-1, 0])
        if self.watch.has_limits:
            for time, chainage, speed in zip(time_ns, vehicles.chainage, vehicles.speed, strict=True):
                self.watch.update(int(time), chainage, speed)
        moving = np.flatnonzero(vehicles.speed.any(axis=1))
        if len(moving):
            standing = int(moving[-1]) + 1
            self.standing_since_ns = int(time_ns[standing]) if standing < len(time_ns) else None
        elif self.standing_since_ns is None:
            self.standing_since_ns = int(time_ns[0])


def _summary(
    scenario: Scenario,
    extremes: CouplerExtremes,
    *,
    duration: float,
    stop_time: float | None,
    stop_time_resolution: float,
    final_speed: float,
    distance: float,
    overspeeds: Overspeeds,
    energy: EnergyBalance | None,
    solver: StepStatistics | None,
    real_time_factor: float | None,
    radio: Mapping[str, LinkStatus] | None,
) -> RunSummary:
    consist = scenario.consist
    return RunSummary(
        scenario=scenario.name,
        description=scenario.description,
        vehicles=len(consist.vehicles),
        couplers=len(consist.couplers),
        mass=consist.mass,
        length=consist.length,
        initial_speed=scenario.initial_speed,
        duration=duration,
        stop_time=stop_time,
        stop_time_resolution=stop_time_resolution,
        final_speed=final_speed,
        distance=distance,
        compression=peak(consist, extremes.compression, extremes.compression_time),
        tension=peak(consist, extremes.tension, extremes.tension_time),
        compression_stroke=peak(consist, extremes.compression_stroke),
        tension_stroke=peak(consist, extremes.tension_stroke),
        bottomed=tuple(consist.coupler_names[j] for j in bottomed_couplers(consist, extremes)),
        overspeeds=overspeeds,
        energy=energy,
        solver=solver,
        real_time_factor=real_time_factor,
        radio=radio,
        caveats=scenario.caveats,
    )
