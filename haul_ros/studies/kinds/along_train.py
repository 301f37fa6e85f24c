"""One train along its length: the validation train (paper Fig. 5), and peaks of the 1+2+1 train (Fig. 6)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from haul_ros.studies.case import CaseResult
from haul_ros.studies.claims import Claim, about, kn, mm, peak, relative, series
from haul_ros.studies.kinds.kind import Results, judged
from haul_ros.studies.kinds.needs import one_case
from haul_ros.studies.sweep import Sweep

POSITION_TOLERANCE = 0.03
"""Of the length of the train."""

_EQUAL = 0.03
_DIP = 0.8
"""The minimum between locomotives is called one below this part of the peak."""


def validation(study: Sweep, results: Results) -> list[Claim]:
    """Fig. 5: size and position of the peak, and the ends of the train."""
    (finished,) = results
    text, result = study.paper_values(finished.case), finished.result
    assert text.force is not None and text.position is not None
    force = result.force
    position = float(result.position[force.argmax()])
    lowest = {int(i) for i in np.argsort(force)[:2]}
    fitted = study.in_fit(finished.case)
    return [
        about("largest force", text.force, peak(result), fitted),
        Claim(
            f"it is at about {text.position:g} of the train",
            abs(position - text.position) <= POSITION_TOLERANCE,
            f"at {position:.3f}",
            fitted,
        ),
        Claim(
            "smallest at both ends",
            lowest == {0, len(force) - 1},
            f"{kn(force[0])} at the head, {kn(force[-1])} at the tail",
            fitted,
        ),
    ]


def distribution(study: Sweep, results: Results) -> list[Claim]:
    """Conclusion 1, Fig. 6: peaks in the four quarters, minimum mid-way between the locomotives."""
    (finished,) = results
    text, result = study.paper_values(finished.case), finished.result
    assert text.force is not None and text.stroke is not None
    stroke = result.largest_stroke
    fitted = study.in_fit(finished.case)
    return [
        about("largest force", text.force, peak(result), fitted),
        Claim(f"strokes under {text.stroke * 1e3:g} mm", stroke < text.stroke, mm(stroke), fitted),
        _quarters(result, fitted),
        _middle(result, fitted),
    ]


def _quarters(result: CaseResult, fitted: bool) -> Claim:
    text = "four nearly equal peaks (of |F|; compression alone has two high and two low ones)"
    if len(result.force) < 4:
        return Claim(text, None, f"{len(result.force)} couplers have no quarters")
    quarters = [float(quarter.max()) for quarter in np.array_split(result.force, 4)]
    spread = relative(max(quarters), min(quarters))
    return Claim(text, spread <= _EQUAL, f"{series(quarters, 'kN', 1e-3)}, apart by {spread * 100:.1f} %", fitted)


def _middle(result: CaseResult, fitted: bool) -> Claim:
    """Where |F| has its minimum between locomotives that have wagons between them, away from both of them."""
    text = "smallest mid-way between locomotives"
    lows, shares = [], []
    for first, last in pairwise(result.locomotives.tolist()):
        if last - first > 1:
            margin = (last - first) // 5
            inside = result.force[first + margin : last - margin]
            lows.append(float(inside.min()))
            shares.append((int(inside.argmin()) + margin + 0.5) / (last - first))
    if not lows:
        return Claim(text, None, "no wagons between locomotives")
    holds = all(abs(share - 0.5) <= 0.05 for share in shares) and max(lows) < _DIP * peak(result)
    return Claim(
        text,
        holds,
        f"{series(lows, 'kN', 1e-3)} at {'/'.join(f'{share:.2f}' for share in shares)} of the way",
        fitted,
    )


def _needs_validation(study: Sweep) -> None:
    one_case(study, "force_kN", "position")


def _needs_distribution(study: Sweep) -> None:
    one_case(study, "force_kN", "stroke_mm")


VALIDATION = judged(_needs_validation, validation)
DISTRIBUTION = judged(_needs_distribution, distribution)
