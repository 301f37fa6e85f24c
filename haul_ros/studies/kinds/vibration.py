"""Natural frequencies of differently coupled trains (paper eqs. 8 to 12); nothing is simulated."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haul_ros.analysis.plotting import DASHES, new_figure, shades
from haul_ros.analysis.tables import Table
from haul_ros.model.consist import Consist
from haul_ros.physics.modal import Modes, natural_modes, stiffness_about_rest
from haul_ros.studies.case import Case, Finished
from haul_ros.studies.claims import Claim
from haul_ros.studies.figures import ALONG
from haul_ros.studies.kinds.kind import Conclusion, Kind
from haul_ros.studies.kinds.needs import no_samples, separate_axes, unfit
from haul_ros.studies.sweep import Sweep

_ROUNDING = 1e-9
"""A ratio of frequencies that differs from 1 by less says nothing."""

_GROUPS = {2: "pairs", 3: "threes"}


@dataclass(frozen=True, slots=True, eq=False)
class Train:
    """A train and its modes."""

    consist: Consist
    modes: Modes


Trains = Sequence[Finished[Train]]


def compute(case: Case) -> Train:
    """The train of a case."""
    consist = case.load().consist
    return Train(consist, natural_modes(consist))


def conclude(study: Sweep, results: Iterable[Finished[Train]]) -> Conclusion:
    """Claims, spectra and modes, the latter of the train that is varied in nothing."""
    trains = list(results)
    reference = next(train for train in trains if _is_plain(study, train.case))
    claims = [compare(reference, train) for train in trains if train is not reference]
    tables = {"": frequency_table(trains), "_modes": shape_table(reference.result.modes)}
    return Conclusion(claims, modes_figure(trains, reference, study.description), tables)


def _needs(study: Sweep) -> None:
    no_samples(study)
    separate_axes(study)
    if len(study.scenarios) > 1:
        raise unfit(study, f"expected one scenario, not {len(study.scenarios)}")
    for axis in study.axes:
        if axis.plain is None:
            raise unfit(
                study, f"expected {axis.name} (over) with one variant that sets nothing ({{}}), to compare with"
            )


def _is_plain(study: Sweep, case: Case) -> bool:
    return all(axis.index(case) == axis.plain for axis in study.axes)


def frequency_table(trains: Trains) -> Table:
    """A row per mode, a column of frequencies per train; a train of fewer masses has fewer modes (None)."""
    longest = max(len(train.result.modes.frequencies) for train in trains)
    columns = {f"{train.case.name} [Hz]": train.result.modes.frequencies.tolist() for train in trains}
    padded = {name: [*values, *[None] * (longest - len(values))] for name, values in columns.items()}
    return {"mode": list(range(longest)), **padded}


def shape_table(modes: Modes, count: int = 5) -> Table:
    """A row per vehicle, a column per mode after the first (the whole train), largest displacement 1."""
    n = modes.shapes.shape[1]
    columns = {
        f"mode_{number}": (modes.shapes[number] / np.abs(modes.shapes[number]).max()).tolist()
        for number in range(1, min(count + 1, len(modes.frequencies)))
    }
    return {"vehicle": list(range(1, n + 1)), **columns}


def compare(reference: Finished[Train], other: Finished[Train]) -> Claim:
    """Lower stiffness, or larger vibrating masses, lower the frequencies; trains may differ in one of them."""
    before, after = reference.result.consist, other.result.consist
    if len(before.vehicles) != len(after.vehicles):
        return _unlike(reference, other)
    match _stiffness_change(before, after), _mass_change(before, after), _bars(after) - _bars(before):
        case (-1, 0, 0):
            return _all("lower stiffness lowers", reference, other, -1.0)
        case (1, 0, 0):
            return _all("higher stiffness raises", reference, other, 1.0)
        case (0, 1, 0):
            return _all("heavier wagons lower", reference, other, -1.0)
        case (0, -1, 0):
            return _all("lighter wagons raise", reference, other, 1.0)
        case (0, 0, more) if more > 0:
            return _larger_masses(reference, other)
    return _unlike(reference, other)


def _stiffness_change(before: Consist, after: Consist) -> int | None:
    """Of the couplers that have a draft gear in both trains."""
    pairs = zip(before.couplers, after.couplers, strict=True)
    return _change((stiffness_about_rest(a), stiffness_about_rest(b)) for a, b in pairs if a and b)


def _mass_change(before: Consist, after: Consist) -> int | None:
    return _change((a.mass, b.mass) for a, b in zip(before.vehicles, after.vehicles, strict=True))


def _change(pairs: Iterable[tuple[float, float]]) -> int | None:
    """-1 if some values become smaller, 1 if larger, 0 if neither, None if both."""
    signs = {int(np.sign(after - before)) for before, after in pairs} - {0}
    return None if len(signs) > 1 else sum(signs)


def _bars(consist: Consist) -> int:
    return consist.couplers.count(None)


def _all(text: str, reference: Finished[Train], other: Finished[Train], sign: float) -> Claim:
    """All frequencies change with the sign."""
    ratios = other.result.modes.frequencies[1:] / reference.result.modes.frequencies[1:]
    found = f"by a factor of {ratios.min():.4f} to {ratios.max():.4f}"
    names = f"{reference.case.name} to {other.case.name}"
    return Claim(f"{text} all frequencies ({names})", bool((sign * (ratios - 1.0) > _ROUNDING).all()), found)


def _larger_masses(reference: Finished[Train], other: Finished[Train]) -> Claim:
    """The highest mode, masses against one another, and the lowest, the train as a bar, change unlike one another."""
    joined, single = other.result.modes.frequencies, reference.result.modes.frequencies
    highest, lowest = joined[-1] / single[-1], joined[1] / single[1]
    found = (
        f"highest {single[-1]:.3f} to {joined[-1]:.3f} Hz (factor {highest:.3f}); but there are fewer springs, and the "
        f"lowest goes from {single[1]:.4f} to {joined[1]:.4f} Hz (factor {lowest:.3f})"
    )
    text = f"larger masses by rigid arms (wagons in {_group(other.result.consist)}) lower the highest frequency"
    return Claim(text, highest < 1.0 - _ROUNDING, found)


def _group(consist: Consist) -> str:
    """How many vehicles the largest mass is made of, in words."""
    joined = groupby(consist.couplers, lambda gear: gear is None)
    largest = 1 + max(len(list(couplers)) for is_bar, couplers in joined if is_bar)
    return _GROUPS.get(largest, f"groups of {largest}")


def _unlike(reference: Finished[Train], other: Finished[Train]) -> Claim:
    lowest, highest = (
        f"{reference.result.modes.frequencies[n]:.4f} to {other.result.modes.frequencies[n]:.4f} Hz" for n in (1, -1)
    )
    text = f"{reference.case.name} to {other.case.name}, which differ in several things"
    return Claim(text, None, f"lowest {lowest}, highest {highest}")


def modes_figure(trains: Trains, reference: Finished[Train], title: str) -> Figure:
    """Natural frequencies of all trains, and the first modes of the reference along it."""
    figure = new_figure(title)
    spectrum, shapes = figure.subplots(2, 1, height_ratios=(3, 2))
    _draw_spectrum(spectrum, trains)
    _draw_shapes(shapes, reference.result.modes)
    shapes.set_ylabel(f"displacement,\n{reference.case.name}")
    return figure


def _draw_spectrum(axes: Axes, trains: Trains) -> None:
    for number, (train, colour) in enumerate(zip(trains, shades(len(trains)), strict=True)):
        found = train.result.modes.frequencies[1:]
        dashes = DASHES[number % len(DASHES)]
        axes.plot(np.arange(1, len(found) + 1), found, color=colour, ls=dashes, label=train.case.name)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("mode")
    axes.set_ylabel("natural frequency [Hz]")
    axes.grid(alpha=0.3, which="both")
    axes.legend(frameon=False)


def _draw_shapes(axes: Axes, modes: Modes) -> None:
    n = modes.shapes.shape[1]
    for number in range(1, min(4, len(modes.frequencies))):
        shape = modes.shapes[number] / np.abs(modes.shapes[number]).max()
        label = f"mode {number}, {modes.frequencies[number]:.3f} Hz"
        axes.plot((np.arange(n) + 0.5) / n, shape, ls=DASHES[number - 1], label=label)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(-1.1, 1.75)
    axes.grid(alpha=0.3)
    axes.set_xlabel(ALONG)
    axes.legend(frameon=False, ncol=3, loc="upper center")


VIBRATION = Kind(_needs, conclude, compute)
