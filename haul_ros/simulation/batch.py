"""A run from its start to its end, as fast as it goes."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from haul_ros.errors import HaulError
from haul_ros.model.log import PeriodLog
from haul_ros.model.sample import Sample
from haul_ros.model.scenario import Scenario
from haul_ros.simulation.session import Session
from haul_ros.units import NS_PER_S


class RunError(HaulError):
    """A run that its scenario's own commands make impossible."""


def periods(session: Session, stop: Callable[[], bool] = lambda: False) -> Iterator[PeriodLog]:
    """Run a session until it is finished, or until ``stop`` has become true, a fraction of a second after that.

    The first log is that of the state before the first step; the last period ends with the longest duration.

    Raises
    ------
    RunError
        A command of the scenario cannot be carried out at its time.
    """
    while True:
        last = session.finished or stop()
        yield session.take_log(last=last)
        if last:
            return
        try:
            session.advance(min(session.steps_per_sample, session.steps_left), stop=stop)
        except HaulError as error:
            raise RunError(f"{session.scenario.name}: at {session.time:.3f} s: {error}") from error


def share_done(scenario: Scenario, sample: Sample) -> float:
    """How near a run is to its end, 0..1: speed shed or longest duration used up, whichever is further."""
    of_time = sample.time_ns / NS_PER_S / scenario.max_duration
    of_speed = 1.0 - float(sample.speed.max()) / scenario.initial_speed if scenario.initial_speed > 0.0 else 0.0
    return min(1.0, max(of_time, of_speed, 0.0))
