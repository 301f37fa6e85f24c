"""Cases that the paper has no claim on: a few beside one another, or many as quantiles along the train."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from haul_ros.model.sample import FloatArray
from haul_ros.studies.case import CaseResult, Finished
from haul_ros.studies.claims import Claim, kn, mm, peak
from haul_ros.studies.figures import peaks_figure, quantiles_figure
from haul_ros.studies.kinds.kind import Conclusion, Kind, Results, judged
from haul_ros.studies.kinds.needs import no_samples
from haul_ros.studies.sweep import Sweep
from haul_ros.studies.tables import quantile_table

_MOST_LINES = 8
"""Cases that a figure shows one by one."""


def comparison(_study: Sweep, results: Results) -> list[Claim]:
    """The peaks of all cases in one line."""
    values = [f"{f.case.name} {kn(peak(f.result))}, {mm(f.result.largest_stroke)}" for f in results]
    return [Claim("no claim of the paper", None, "; ".join(values))]


def sweep(study: Sweep, results: Iterable[Finished[CaseResult]]) -> Conclusion:
    """Profiles of a few cases, quantiles of many or of random samples."""
    if len(study) <= _MOST_LINES and not study.draws:
        return Conclusion(figure=peaks_figure(study, list(results)))
    forces, position = _forces(results)
    if forces is None:  # trains of different length have no quantiles by coupler
        return Conclusion()
    low, middle, high = np.quantile(forces.max(axis=1), (0.05, 0.5, 0.95)) / 1e3
    found = f"median {middle:.1f} kN, 5 to 95 % of {len(forces)} cases between {low:.1f} and {high:.1f} kN"
    figure = quantiles_figure(forces, position, study.description)
    return Conclusion([Claim("largest force", None, found)], figure, {"_quantiles": quantile_table(forces, position)})


def _forces(results: Iterable[Finished[CaseResult]]) -> tuple[FloatArray | None, FloatArray]:
    """|F| (n_cases, n_couplers) [N] and the positions of the couplers; None if the trains differ in length."""
    rows, position = [], np.empty(0)
    for finished in results:
        rows.append(finished.result.force)
        position = finished.result.position
        if len(rows[0]) != len(rows[-1]):
            return None, position
    return np.array(rows), position


def _needs_nothing(_study: Sweep) -> None:
    """Any cases will do."""


COMPARISON = judged(no_samples, comparison)
SWEEP = Kind(_needs_nothing, sweep)
