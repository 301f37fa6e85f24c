"""What the paper claims, and whether the computed cases bear it out: by case name, in the order of the study."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from haul_ros.studies.case import CaseResult
from haul_ros.studies.sweep import PaperValues

TOLERANCE = 0.03
"""Relative, against numbers that the text gives as "about"."""
POSITION_TOLERANCE = 0.03
"""Of the length of the train."""

_EQUAL = 0.03
_DIP = 0.8
"""The minimum between locomotives is called one below this part of the peak."""

Results = Mapping[str, CaseResult]


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim of the paper, whether it holds (None: it cannot be told, or there is none), and by how much."""

    text: str
    holds: bool | None
    found: str

    def __str__(self) -> str:
        verdict = {True: "holds", False: "does not hold", None: "result"}[self.holds]
        return f"{verdict}: {self.text}: {self.found}"


def _kn(force: float) -> str:
    return f"{force / 1e3:.1f} kN"


def _mm(stroke: float) -> str:
    return f"{stroke * 1e3:.2f} mm"


def _percent(value: float, reference: float) -> str:
    return f"{(value / reference - 1.0) * 100.0:+.1f} %"


def peak(result: CaseResult) -> float:
    """Largest force of the whole train [N]."""
    return float(result.force.max())


def _about(what: str, paper: float, computed: float) -> Claim:
    found = f"{_kn(computed)}, {_percent(computed, paper)}"
    return Claim(f"{what} about {paper / 1e3:.0f} kN", abs(computed / paper - 1.0) <= TOLERANCE, found)


def _rising(values: Sequence[float]) -> bool:
    return all(before < after for before, after in pairwise(values))


def _series(values: Sequence[float], unit: str, factor: float, digits: int = 1) -> str:
    return f"{'/'.join(f'{value * factor:.{digits}f}' for value in values)} {unit}"


def validation(results: Results, paper: Mapping[str, PaperValues]) -> list[Claim]:
    """Fig. 5: size and place of the peak, and the ends of the train."""
    ((name, result),) = results.items()
    text = paper[name]
    assert text.force is not None and text.position is not None
    force = result.force
    place = float(result.position[force.argmax()])
    lowest = {int(i) for i in np.argsort(force)[:2]}
    return [
        _about("largest force", text.force, peak(result)),
        Claim(
            f"it is at about {text.position:g} of the train",
            abs(place - text.position) <= POSITION_TOLERANCE,
            f"at {place:.3f}",
        ),
        Claim(
            "smallest at both ends",
            lowest == {0, len(force) - 1},
            f"{_kn(force[0])} at the head, {_kn(force[-1])} at the tail",
        ),
    ]


def distribution(results: Results, paper: Mapping[str, PaperValues]) -> list[Claim]:
    """Conclusion 1, Fig. 6: peaks in the four quarters, minimum mid-way between the locomotives."""
    ((name, result),) = results.items()
    text = paper[name]
    assert text.force is not None and text.stroke is not None
    stroke = result.largest_stroke
    quarters = [float(quarter.max()) for quarter in np.array_split(result.force, 4)]
    spread = max(quarters) / min(quarters) - 1.0
    return [
        _about("largest force", text.force, peak(result)),
        Claim(f"strokes under {text.stroke * 1e3:g} mm", stroke < text.stroke, _mm(stroke)),
        Claim(
            "four nearly equal peaks (of |F|; compression alone has two high and two low ones)",
            spread <= _EQUAL,
            f"{_series(quarters, 'kN', 1e-3)}, apart by {spread * 100:.1f} %",
        ),
        _middle(result),
    ]


def _middle(result: CaseResult) -> Claim:
    """Where |F| has its minimum inside each half of a 1+2+1 train, away from the ends of the half."""
    head, centre, _, tail = result.locomotives
    lows, places = [], []
    for first, last in ((head, centre), (centre + 1, tail)):
        margin = (last - first) // 5
        inside = result.force[first + margin : last - margin]
        lows.append(float(inside.min()))
        places.append((int(inside.argmin()) + margin + 0.5) / (last - first))
    holds = all(abs(place - 0.5) <= 0.05 for place in places) and max(lows) < _DIP * peak(result)
    found = f"{_series(lows, 'kN', 1e-3)} at {'/'.join(f'{place:.2f}' for place in places)} of the way"
    return Claim("smallest mid-way between locomotives", holds, found)


def initial_speed(results: Results, paper: Mapping[str, PaperValues]) -> list[Claim]:
    """Conclusion 1, Fig. 7: the higher the speed, the smaller the peak."""
    peaks = [peak(result) for result in results.values()]
    claims = [
        _about(name, text.force, peak(results[name])) for name, text in paper.items() if text.force and name in results
    ]
    order = Claim(
        "the peak falls with the initial speed",
        _rising(peaks[::-1]),
        f"{_series(peaks, 'kN', 1e-3)}, {_percent(peaks[-1], peaks[0])} from first to last",
    )
    return [*claims, order]


def synchronisation(results: Results, _paper: Mapping[str, PaperValues]) -> list[Claim]:
    """Conclusion 2, Fig. 8: forces rise with the delay and are lowest without one."""
    peaks = [peak(result) for result in results.values()]
    found = f"{_series(peaks, 'kN', 1e-3)}, {_percent(peaks[-1], peaks[0])} from first to last"
    return [Claim("the peak is lowest when all brake at once and rises with the delay", _rising(peaks), found)]


def stiffness(results: Results, _paper: Mapping[str, PaperValues]) -> list[Claim]:
    """Conclusion 3, Fig. 10: stiffer gears bear more force over less stroke."""
    forces = [peak(result) for result in results.values()]
    strokes = [result.largest_stroke for result in results.values()]
    return [
        Claim("stiffer gears bear more force", _rising(forces), _series(forces, "kN", 1e-3)),
        Claim("over less stroke", _rising(strokes[::-1]), _series(strokes, "mm", 1e3, 2)),
    ]


def rigid_arms(results: Results, _paper: Mapping[str, PaperValues]) -> list[Claim]:
    """Conclusion 4, Fig. 12: rigid arms make forces and strokes of the draft gears smaller."""
    claims = []
    for parameters in dict.fromkeys(name.partition(", ")[0] for name in results):
        single = results[f"{parameters}, single"]
        for group in ("pairs", "threes"):
            joined = results[f"{parameters}, {group}"]
            smaller = joined.gear_force < single.gear_force and joined.largest_stroke < single.largest_stroke
            force = f"{_kn(joined.gear_force)} ({_percent(joined.gear_force, single.gear_force)})"
            stroke = f"{_mm(joined.largest_stroke)} ({_percent(joined.largest_stroke, single.largest_stroke)})"
            bars = f"in the rigid bars {_kn(float(joined.force.max(where=~joined.geared, initial=0.0)))}"
            claims.append(
                Claim(
                    f"{parameters}: wagons in {group} have smaller forces and strokes",
                    smaller,
                    f"{force}, {stroke}; {bars}",
                )
            )
    return claims


def effect_of_pairs(results: Results) -> dict[str, float]:
    """Change of the largest draft gear force by rigid pairs, relative, by the name of the case without ", single"."""
    effects = {}
    for name, single in results.items():
        stem, found, _ = name.rpartition(", single")
        if found:
            effects[stem] = results[f"{stem}, pairs"].gear_force / single.gear_force - 1.0
    return effects


def rigid_arm_map(results: Results, _paper: Mapping[str, PaperValues]) -> list[Claim]:
    """Conclusion 4 over what the paper does not print."""
    effects = effect_of_pairs(results)
    claims = []
    for gear in dict.fromkeys(stem.partition(", ")[0] for stem in effects):
        values = [effect for stem, effect in effects.items() if stem.startswith(f"{gear}, ")]
        smaller = sum(value < 0.0 for value in values)
        found = f"in {smaller} of {len(values)} places, from {min(values) * 100:+.1f} % to {max(values) * 100:+.1f} %"
        claims.append(Claim(f"{gear}: pairs lower the force everywhere on the map", smaller == len(values), found))
    return claims


def comparison(results: Results, _paper: Mapping[str, PaperValues]) -> list[Claim]:
    """Cases beside one another, where the paper has no claim."""
    values = [f"{name} {_kn(peak(result))}, {_mm(result.largest_stroke)}" for name, result in results.items()]
    return [Claim("no claim of the paper", None, "; ".join(values))]


JUDGES: Mapping[str, Callable[[Results, Mapping[str, PaperValues]], list[Claim]]] = {
    "validation": validation,
    "distribution": distribution,
    "initial-speed": initial_speed,
    "synchronisation": synchronisation,
    "stiffness": stiffness,
    "rigid-arms": rigid_arms,
    "rigid-arm-map": rigid_arm_map,
    "marshalling": comparison,
}
"""The studies that have something to say, by name."""
