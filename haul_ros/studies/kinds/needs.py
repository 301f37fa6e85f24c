"""What kinds of studies need to find in a study, refused in one line where it is missing."""

from __future__ import annotations

from fnmatch import fnmatchcase

from haul_ros.studies.errors import StudyError
from haul_ros.studies.sweep import Axis, Sweep


def unfit(study: Sweep, problem: str) -> StudyError:
    """The error to raise."""
    return StudyError(f"kind {study.kind}: {problem}")


def no_samples(study: Sweep) -> None:
    """Refuse random samples: cases are compared one by one."""
    if study.draws:
        raise unfit(study, "expected no draw, its cases are compared one by one")


def one_case(study: Sweep, *quantities: str) -> None:
    """Refuse several cases, or one without these quantities (as in study files) of the paper."""
    no_samples(study)
    if len(study) != 1:
        raise unfit(study, f"expected one case, not {len(study)}")
    paper = study.paper_values(next(study.cases()))
    given = {"force_kN": paper.force, "stroke_mm": paper.stroke, "position": paper.position}
    if missing := [name for name in quantities if given[name] is None]:
        raise unfit(study, f"expected {' and '.join(missing)} in paper, for its case")


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def varied_number(study: Sweep, pattern: str) -> str:
    """The one value (its name fits a pattern as ``couplers.*.slack_mm``) that is another number in every case."""
    no_samples(study)
    cases = list(study.cases())
    names = [name for name in cases[0].values if fnmatchcase(name, pattern)]
    found = {_number(case.values.get(names[0])) for case in cases} if len(names) == 1 else set()
    if len(cases) < 2 or len(found) < len(cases) or None in found:
        raise unfit(study, f"expected several cases that differ in {pattern}, each with a number of its own")
    return names[0]


def number_axis(study: Sweep, pattern: str) -> Axis:
    """The one axis over a key that fits a pattern, of numbers that differ."""
    axes = [axis for axis in study.axes if fnmatchcase(axis.name, pattern)]
    values = [_number(point.values[axis.name]) for axis in axes for point in axis.points]
    if len(axes) != 1 or None in values or len(set(values)) < len(values):
        raise unfit(study, f"expected {pattern} among what is varied (over), with numbers that differ")
    return axes[0]


def compared_axis(study: Sweep, name: str) -> Axis:
    """The axis of that name: variants of which one sets nothing, so that the others are compared with it."""
    axis = next((axis for axis in study.axes if axis.name == name), None)
    if axis is None or axis.plain is None or len(axis.points) < 2:
        raise unfit(study, f"expected {name} (over) with one variant that sets nothing ({{}}), and others beside it")
    return axis


def separate_axes(study: Sweep) -> None:
    """Refuse variants that set what is varied by another axis: a case would not lie where its axes say."""
    for axis in study.axes:
        for other in study.axes:
            if axis is not other and any(other.name in point.overrides for point in axis.points):
                raise unfit(study, f"{axis.name} sets {other.name}, which is varied beside it (over)")
