"""Wagons joined by rigid arms beside single ones (paper Fig. 12)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from haul_ros.studies.case import Case, CaseResult
from haul_ros.studies.claims import Claim, kn, mm, percent, relative
from haul_ros.studies.kinds.kind import Results, judged
from haul_ros.studies.kinds.needs import compared_axis, no_samples, separate_axes
from haul_ros.studies.sweep import Sweep

WAGONS = "wagons"


@dataclass(frozen=True, slots=True)
class Comparison:
    """A case with joined wagons, what it gave, and what the same train with single wagons gave.

    ``group`` is how the joined wagons are called.
    """

    case: Case
    joined: CaseResult
    single: CaseResult
    group: str

    @property
    def effect(self) -> float:
        """Change of the largest draft gear force, relative."""
        return relative(self.joined.gear_force, self.single.gear_force)


def needs_wagons(study: Sweep) -> None:
    """Refuse a study without an axis of wagons of which one variant sets nothing, and that is single wagons."""
    no_samples(study)
    separate_axes(study)
    compared_axis(study, WAGONS)


def comparisons(study: Sweep, results: Results) -> Iterator[Comparison]:
    """Each case with joined wagons beside the one with single wagons that is equal in all else."""
    wagons = compared_axis(study, WAGONS)
    single = {rest(study, f.case, WAGONS): f.result for f in results if wagons.index(f.case) == wagons.plain}
    for finished in results:
        number = wagons.index(finished.case)
        if number != wagons.plain:
            beside = single[rest(study, finished.case, WAGONS)]
            yield Comparison(finished.case, finished.result, beside, wagons.points[number].name)


def rest(study: Sweep, case: Case, *without: str) -> tuple[str | int, ...]:
    """Scenario of a case, and where it lies on all axes but these."""
    return (case.scenario, *(axis.index(case) for axis in study.axes if axis.name not in without))


def rest_name(study: Sweep, case: Case, *without: str) -> str:
    """The same in words, for people; empty if there is nothing else."""
    scenario = [case.scenario_name] if len(study.scenarios) > 1 else []
    names = [axis.points[axis.index(case)].name for axis in study.axes if axis.name not in without]
    return ", ".join([*scenario, *names])


def rigid_arms(study: Sweep, results: Results) -> list[Claim]:
    """Conclusion 4, Fig. 12: rigid arms make forces and strokes of the draft gears smaller."""
    claims = []
    for compared in comparisons(study, results):
        single, joined = compared.single, compared.joined
        smaller = joined.gear_force < single.gear_force and joined.largest_stroke < single.largest_stroke
        force = f"{kn(joined.gear_force)} ({percent(joined.gear_force, single.gear_force)})"
        stroke = f"{mm(joined.largest_stroke)} ({percent(joined.largest_stroke, single.largest_stroke)})"
        bars = f"in the rigid bars {kn(float(joined.force.max(where=~joined.geared, initial=0.0)))}"
        text = f"wagons in {compared.group} have smaller forces and strokes"
        name = rest_name(study, compared.case, WAGONS)
        fitted = study.in_fit(compared.case)
        claims.append(Claim(f"{name}: {text}" if name else text, smaller, f"{force}, {stroke}; {bars}", fitted))
    return claims


RIGID_ARMS = judged(needs_wagons, rigid_arms)
