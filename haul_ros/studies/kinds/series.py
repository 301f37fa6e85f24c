"""One value varied: initial speed (paper Fig. 7), delay of the slaves (Fig. 8), stiffness of draft gears (Fig. 10)."""

from __future__ import annotations

from typing import cast

from haul_ros.studies.claims import Claim, about, is_rising, peak, percent, series
from haul_ros.studies.kinds.kind import Results, judged
from haul_ros.studies.kinds.needs import unfit, varied_number
from haul_ros.studies.sweep import Sweep

_SPEED = "initial_speed_kmh"
_DELAY = "radio.default.delay_s"
_STIFFNESS = "couplers.*.loading_stiffness_kN_per_mm"


def _ascending(study: Sweep, results: Results, pattern: str) -> Results:
    name = varied_number(study, pattern)
    return sorted(results, key=lambda finished: cast(float, finished.case.values[name]))


def initial_speed(study: Sweep, results: Results) -> list[Claim]:
    """Conclusion 1, Fig. 7: the higher the speed, the smaller the peak."""
    ascending = _ascending(study, results, _SPEED)
    claims = [
        about(finished.case.name, force, peak(finished.result), study.in_fit(finished.case))
        for finished in ascending
        if (force := study.paper_values(finished.case).force) is not None
    ]
    peaks = [peak(finished.result) for finished in ascending]
    found = f"{series(peaks, 'kN', 1e-3)}, {percent(peaks[-1], peaks[0])} from first to last"
    return [*claims, Claim("the peak falls with the initial speed", is_rising(peaks[::-1]), found, study.in_fit())]


def synchronisation(study: Sweep, results: Results) -> list[Claim]:
    """Conclusion 2, Fig. 8: forces rise with the delay and are lowest without one."""
    peaks = [peak(finished.result) for finished in _ascending(study, results, _DELAY)]
    found = f"{series(peaks, 'kN', 1e-3)}, {percent(peaks[-1], peaks[0])} from first to last"
    text = "the peak is lowest when all brake at once and rises with the delay"
    return [Claim(text, is_rising(peaks), found, study.in_fit())]


def stiffness(study: Sweep, results: Results) -> list[Claim]:
    """Conclusion 3, Fig. 10: stiffer gears bear more force over less stroke."""
    ascending = _ascending(study, results, _STIFFNESS)
    forces = [peak(finished.result) for finished in ascending]
    strokes = [finished.result.largest_stroke for finished in ascending]
    return [
        Claim("stiffer gears bear more force", is_rising(forces), series(forces, "kN", 1e-3), study.in_fit()),
        Claim("over less stroke", is_rising(strokes[::-1]), series(strokes, "mm", 1e3, 2), study.in_fit()),
    ]


def _needs_speeds(study: Sweep) -> None:
    varied_number(study, _SPEED)


def _needs_delays(study: Sweep) -> None:
    name = varied_number(study, _DELAY)
    if all(case.values[name] != 0 for case in study.cases()):
        raise unfit(study, f"expected a case with {_DELAY} = 0 among them")


def _needs_stiffnesses(study: Sweep) -> None:
    varied_number(study, _STIFFNESS)


INITIAL_SPEED = judged(_needs_speeds, initial_speed)
SYNCHRONISATION = judged(_needs_delays, synchronisation)
STIFFNESS = judged(_needs_stiffnesses, stiffness)
