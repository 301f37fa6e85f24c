"""A run from its start to its end, as fast as it goes: what each sample period brought."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from haul_ros.errors import HaulError
from haul_ros.model.event import Event
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.simulation.events import EventWatch
from haul_ros.simulation.session import AppliedBrake, Session, TakenCommand, TakenLink
from haul_ros.units import NS_PER_S

EXTREMES_PERIOD_NS = NS_PER_S
"""Simulation time between two looks at the running extremes."""


class RunError(HaulError):
    """A run that its scenario's own commands make impossible."""


@dataclass(frozen=True, slots=True, eq=False)
class Period:
    """The state at the end of a sample period, and what happened in it.

    ``links`` are all of them in the first period, then those that changed; ``extremes`` are there
    once in `EXTREMES_PERIOD_NS`, at the start and at the end of the run.
    """

    sample: Sample
    commands: tuple[TakenCommand, ...]
    links: tuple[TakenLink, ...]
    applied_brakes: tuple[AppliedBrake, ...]
    events: tuple[Event, ...]
    extremes: CouplerExtremes | None


def periods(session: Session, stop: Callable[[], bool] = lambda: False) -> Iterator[Period]:
    """Run a session until it is finished, or until the end of the period in which ``stop`` has become true.

    The first period is the state before the first step.

    Raises
    ------
    RunError
        A command of the scenario cannot be carried out at its time.
    """
    watch = EventWatch(session)
    sample = session.sample()
    extremes_due_ns = sample.time_ns
    while True:
        last = session.finished or stop()
        due = sample.time_ns >= extremes_due_ns
        if due:
            extremes_due_ns = (sample.time_ns // EXTREMES_PERIOD_NS + 1) * EXTREMES_PERIOD_NS
        yield Period(
            sample=sample,
            commands=tuple(session.take_commands()),
            links=tuple(session.take_links()),
            applied_brakes=tuple(session.take_applied_brakes()),
            events=watch.look(sample),
            extremes=session.extremes() if due or last else None,
        )
        if last:
            return
        try:
            sample = session.advance()
        except HaulError as error:
            raise RunError(f"{session.scenario.name}: at {session.time:.3f} s: {error}") from error


def share_done(scenario: Scenario, sample: Sample) -> float:
    """How near a run is to its end, 0..1: speed shed or longest duration used up, whichever is further."""
    of_time = sample.time_ns / NS_PER_S / scenario.max_duration
    of_speed = 1.0 - float(sample.speed[0]) / scenario.initial_speed if scenario.initial_speed > 0.0 else 0.0
    return min(1.0, max(of_time, of_speed, 0.0))
