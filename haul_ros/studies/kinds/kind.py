"""What makes a kind of study."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from matplotlib.figure import Figure

from haul_ros.analysis.tables import Table
from haul_ros.studies.case import Case, CaseResult, Finished
from haul_ros.studies.claims import Claim
from haul_ros.studies.figures import peaks_figure
from haul_ros.studies.sweep import Sweep

Results = Sequence[Finished[CaseResult]]
"""All cases of a study, simulated, in its order."""


@dataclass(frozen=True, slots=True)
class Conclusion:
    """What a complete study comes to; ``tables`` by what their files' names have after the name of the study."""

    claims: Sequence[Claim] = ()
    figure: Figure | None = None
    tables: Mapping[str, Table] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of study.

    ``check`` raises a StudyError if a study lacks something that ``conclude`` reads. ``compute`` gives
    the result of a case that is not simulated; None: it is, and its peaks and profiles are written.
    ``conclude`` may go through the results several times; those of simulations are read one by one.
    """

    check: Callable[[Sweep], None]
    conclude: Callable[[Sweep, Iterable[Finished[Any]]], Conclusion]
    compute: Callable[[Case], object] | None = None


def judged(
    check: Callable[[Sweep], None],
    judge: Callable[[Sweep, Results], list[Claim]],
    figure: Callable[[Sweep, Results], Figure] = peaks_figure,
) -> Kind:
    """The kind of a few simulated cases with claims on them and a figure."""

    def conclude(study: Sweep, results: Iterable[Finished[CaseResult]]) -> Conclusion:
        finished = list(results)
        return Conclusion(judge(study, finished), figure(study, finished))

    return Kind(check, conclude)
