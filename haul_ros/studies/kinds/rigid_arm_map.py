"""The effect of rigid pairs on the peak, over what the paper does not print: brake wave speed and build-up time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from haul_ros.analysis.plotting import DIVERGING, LOW_SIZE, new_figure
from haul_ros.model.sample import FloatArray
from haul_ros.scenario.catalogue import catalogue_section
from haul_ros.studies.case import Case
from haul_ros.studies.claims import Claim
from haul_ros.studies.kinds.kind import Results, judged
from haul_ros.studies.kinds.needs import compared_axis, number_axis, unfit
from haul_ros.studies.kinds.rigid_arms import WAGONS, comparisons, needs_wagons, rest, rest_name
from haul_ros.studies.sweep import Sweep

WAVE = "wave_speeds.emergency_mps"
TIME = "build_up.full_time_s"
"""Keys of a brake system."""


@dataclass(frozen=True, slots=True)
class Panel:
    """The map of one train: ``effect`` (wave speeds, build-up times) is the relative change of the peak.

    ``case`` is any of its cases; ``group`` is how the joined wagons are called.
    """

    name: str
    case: Case
    group: str
    wave_speeds: tuple[float, ...]
    times: tuple[float, ...]
    effect: FloatArray


def _needs(study: Sweep) -> None:
    needs_wagons(study)
    number_axis(study, f"brake_systems.*.{WAVE}")
    number_axis(study, f"brake_systems.*.{TIME}")
    if len(compared_axis(study, WAGONS).points) != 2:
        raise unfit(study, f"expected two variants of {WAGONS}, single and joined")


def panels(study: Sweep, results: Results) -> list[Panel]:
    """A map for each combination of the other axes."""
    wave, time = (number_axis(study, f"brake_systems.*.{key}") for key in (WAVE, TIME))
    speeds, times = (tuple(cast(float, p.values[axis.name]) for p in axis.points) for axis in (wave, time))
    mapped = (WAGONS, wave.name, time.name)
    found: dict[tuple[str | int, ...], Panel] = {}
    for compared in comparisons(study, results):
        case = compared.case
        where = rest(study, case, *mapped)
        if where not in found:
            name, empty = rest_name(study, case, *mapped), np.full((len(speeds), len(times)), np.nan)
            found[where] = Panel(name, case, compared.group, speeds, times, empty)
        found[where].effect[wave.index(case), time.index(case)] = compared.effect
    return list(found.values())


def rigid_arm_map(study: Sweep, results: Results) -> list[Claim]:
    """Conclusion 4 over what the paper does not print."""
    claims = []
    for panel in panels(study, results):
        effect = panel.effect
        smaller = int((effect < 0.0).sum())
        low, high = effect.min() * 100, effect.max() * 100
        found = f"in {smaller} of {effect.size} places, from {low:+.1f} % to {high:+.1f} %"
        text = f"{panel.group} lower the force everywhere on the map"
        claims.append(
            Claim(f"{panel.name}: {text}" if panel.name else text, smaller == effect.size, found, study.in_fit())
        )
    return claims


def fitted_set(case: Case) -> tuple[str, float, float] | None:
    """Name, wave speed [m/s] and build-up time [s] of the brake system fitted together with the coupler of a case.

    That is the one of the same name in the catalogue; None if there is none, or it is not fitted.
    """
    name = str(case.overrides.get("coupler"))
    entry = catalogue_section("brake_systems").data["brake_systems"].get(name)
    if entry is None or not (_is_fitted(entry, WAVE) and _is_fitted(entry, TIME)):
        return None
    return name, float(entry["wave_speeds"]["emergency_mps"]), float(entry["build_up"]["full_time_s"])


def _is_fitted(entry: Mapping[str, object], key: str) -> bool:
    standing = entry["standing"]
    if isinstance(standing, Mapping):
        standing = standing.get(key, standing["default"])
    return standing == "fitted"


def map_figure(study: Sweep, results: Results) -> Figure:
    """The maps side by side, blue where pairs make the peak smaller, as the paper says; fitted sets are marked."""
    maps = panels(study, results)
    figure = new_figure(study.description, LOW_SIZE)
    drawn = np.atleast_1d(figure.subplots(1, len(maps), sharey=True))
    limit = max(float(np.abs(panel.effect).max()) for panel in maps) * 100.0
    for axes, panel in zip(drawn, maps, strict=True):
        mesh = _draw_panel(axes, panel, limit)
        _mark_fitted(axes, panel)
    drawn[0].set_ylabel("build-up time [s]")
    label = f"peak with {maps[0].group} over without [%]"
    figure.colorbar(mesh, ax=list(drawn), label=label, pad=0.01)
    return figure


def _draw_panel(axes: Axes, panel: Panel, limit: float) -> QuadMesh:
    columns, rows = np.arange(len(panel.wave_speeds) + 1), np.arange(len(panel.times) + 1)
    values = panel.effect * 100.0
    mesh = axes.pcolormesh(columns, rows, values.T, cmap=DIVERGING, vmin=-limit, vmax=limit)
    for (i, k), value in np.ndenumerate(values):
        shade = "white" if abs(value) > 0.6 * limit else "black"
        axes.text(i + 0.5, k + 0.5, f"{value:+.0f}", ha="center", va="center", fontsize=8, color=shade)
    axes.set_title(panel.name, fontsize=10)
    axes.set_xticks(columns[:-1] + 0.5, [f"{speed:g}" for speed in panel.wave_speeds])
    axes.set_yticks(rows[:-1] + 0.5, [f"{time:g}" for time in panel.times])
    axes.set_xlabel("brake wave speed [m/s]")
    return mesh


def _mark_fitted(axes: Axes, panel: Panel) -> None:
    fitted = fitted_set(panel.case)
    if fitted is None or fitted[1] not in panel.wave_speeds or fitted[2] not in panel.times:
        return
    _, speed, time = fitted
    x, y = panel.wave_speeds.index(speed) + 0.5, panel.times.index(time) + 0.5
    axes.plot([x], [y], "s", ms=26, mfc="none", mec="black", mew=1.8)
    axes.annotate(
        "fitted to the paper", (x, y), (0, 16), textcoords="offset points", ha="center", fontsize=8, weight="bold"
    )


RIGID_ARM_MAP = judged(_needs, rigid_arm_map, map_figure)
