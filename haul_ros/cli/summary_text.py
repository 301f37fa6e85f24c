"""A summary in words and as JSON, in the units of the field."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from haul_ros.analysis.summary import CouplerPeak, RunSummary
from haul_ros.cli.layout import caveat_entries, rows
from haul_ros.errors import one_line
from haul_ros.physics.energy import EnergyBalance
from haul_ros.physics.train_model import StepStatistics
from haul_ros.simulation.overspeed import Overspeed
from haul_ros.simulation.radio import LinkStatus
from haul_ros.units import NS_PER_S, mps_to_kmh

_Number = tuple[str, Callable[[RunSummary], float | None]]


def _peak_numbers(name: str, peak_of: Callable[[RunSummary], CouplerPeak | None]) -> list[_Number]:
    return [
        (f"{name} [kN]", lambda run: peak.value / 1e3 if (peak := peak_of(run)) else 0.0),
        ("  at [s]", lambda run: peak.time if (peak := peak_of(run)) else None),
        ("  of the train", lambda run: peak.position if (peak := peak_of(run)) else None),
    ]


_COMPARED: list[_Number] = [
    ("stop [s]", lambda run: run.stop_time),
    ("distance [m]", lambda run: run.distance),
    ("final speed [km/h]", lambda run: mps_to_kmh(run.final_speed)),
    *_peak_numbers("compression", lambda run: run.compression),
    *_peak_numbers("tension", lambda run: run.tension),
    ("stroke [mm]", lambda run: run.stroke.value * 1e3 if run.stroke else 0.0),
]
"""Numbers of a run in the order of their lines, each with its name; the indented ones belong to the one above."""


def summary_lines(summary: RunSummary) -> list[str]:
    """The summary in words, a line per fact."""
    entries = [
        ("train", _train(summary)),
        ("stopped" if summary.stop_time is not None else "still moving", _end(summary)),
        ("peak compression", _force(summary.compression)),
        ("peak tension", _force(summary.tension)),
        ("largest stroke", _stroke(summary)),
    ]
    if worst := summary.overspeeds.worst:
        entries.append(("over the limit", _overspeed(summary.overspeeds.count, worst)))
    if summary.energy:
        entries.append(("energy", _energy(summary.energy)))
    if summary.solver:
        entries.append(("Newton", _newton(summary.solver)))
    if summary.radio:
        entries += [("radio", text) for slave, link in summary.radio.items() if (text := _radio(slave, link))]
    if summary.real_time_factor is not None:
        entries.append(("speed", f"{summary.real_time_factor:.0f} x real time"))
    entries += caveat_entries(summary.caveats)
    return [one_line(f"{summary.scenario}: {summary.description}"), *rows(entries)]


def side_by_side(recorded: RunSummary, again: RunSummary) -> list[str]:
    """The numbers of two runs in columns."""
    lines = [f"  {'':18} {'recorded':>14} {'run again':>14}"]
    for name, number in _COMPARED:
        pair = [f"{value:14.3f}" if (value := number(run)) is not None else f"{'-':>14}" for run in (recorded, again)]
        lines.append(f"  {name:18} {' '.join(pair)}")
    return lines


def warnings(summary: RunSummary) -> list[str]:
    """What makes the numbers doubtful, a line each."""
    found = []
    if summary.solver and summary.solver.unconverged_steps:
        found.append(
            f"{summary.solver.unconverged_steps} smallest parts of time steps did not converge (residual up to "
            f"{summary.solver.worst_residual:.3g} N): do not trust these numbers, try a smaller time_step_ms"
        )
    if summary.energy and (fault := summary.energy.fault):
        found.append(f"the energy balance does not hold, {fault}: do not trust these numbers")
    if summary.bottomed:
        more = f" and {len(summary.bottomed) - 1} more" if len(summary.bottomed) > 1 else ""
        found.append(f"draft gear closed fully at {summary.bottomed[0]}{more}: the force there is steel on steel")
    return found


def summary_json(summary: RunSummary) -> dict[str, Any]:
    """The summary as a JSON object, units in the keys."""
    return {
        "scenario": summary.scenario,
        "description": summary.description,
        "vehicles": summary.vehicles,
        "couplers": summary.couplers,
        "mass_t": summary.mass / 1e3,
        "length_m": summary.length,
        "initial_speed_kmh": mps_to_kmh(summary.initial_speed),
        "duration_s": summary.duration,
        "stop_time_s": summary.stop_time,
        "stop_time_resolution_s": summary.stop_time_resolution,
        "final_speed_kmh": mps_to_kmh(summary.final_speed),
        "distance_m": summary.distance,
        **_peak_json("peak_compression", "kN", 1e-3, summary.compression),
        **_peak_json("peak_tension", "kN", 1e-3, summary.tension),
        **_peak_json("largest_compression_stroke", "mm", 1e3, summary.compression_stroke),
        **_peak_json("largest_tension_stroke", "mm", 1e3, summary.tension_stroke),
        "largest_stroke_mm": summary.stroke.value * 1e3 if summary.stroke else 0.0,
        "bottomed_couplers": list(summary.bottomed),
        "overspeeds": summary.overspeeds.count,
        "largest_overspeed": _overspeed_json(worst) if (worst := summary.overspeeds.worst) else None,
        "energy": _energy_json(summary.energy) if summary.energy else None,
        "newton": _newton_json(summary.solver) if summary.solver else None,
        "radio": _radio_json(summary.radio) if summary.radio is not None else None,
        "real_time_factor": summary.real_time_factor,
        "caveats": list(summary.caveats),
        "warnings": warnings(summary),
    }


def _train(summary: RunSummary) -> str:
    size = f"{summary.mass / 1e3:.0f} t, {summary.length:.1f} m"
    speed = f"from {mps_to_kmh(summary.initial_speed):.1f} km/h"
    return f"{summary.vehicles} vehicles, {summary.couplers} couplers, {size}, {speed}"


def _end(summary: RunSummary) -> str:
    if summary.stop_time is None:
        speed = mps_to_kmh(summary.final_speed)
        return f"at {speed:.1f} km/h after {summary.duration:.3f} s and {summary.distance:.1f} m"
    sampled = summary.solver is None
    resolution = f" (to {summary.stop_time_resolution:g} s, from samples)" if sampled else ""
    return f"after {summary.stop_time:.3f} s{resolution} and {summary.distance:.1f} m"


def _where(peak: CouplerPeak) -> str:
    before, behind = peak.between
    return f"{peak.coupler} between {before} and {behind}, {peak.position:.3f} of the train"


def _force(peak: CouplerPeak | None) -> str:
    return f"{peak.value / 1e3:.1f} kN at {peak.time:.3f} s in {_where(peak)}" if peak else "none"


def _stroke(summary: RunSummary) -> str:
    if summary.stroke is None:
        return "none"
    direction = "compression" if summary.stroke is summary.compression_stroke else "tension"
    return f"{summary.stroke.value * 1e3:.2f} mm in {direction}, {_where(summary.stroke)}"


def _overspeed(count: int, worst: Overspeed) -> str:
    where = f"{worst.chainage:.0f} m after {worst.time_ns / NS_PER_S:.1f} s"
    speeds = f"{mps_to_kmh(worst.speed):.1f} km/h where {mps_to_kmh(worst.limit):.0f} are allowed"
    return f"{'once' if count == 1 else f'{count} times'}, at most {speeds}, at {where}"


def _energy(energy: EnergyBalance) -> str:
    given = {"gravity": energy.gravity_work, "traction": energy.traction_work}
    parts = [
        f"{energy.kinetic_start / 1e6:.1f} MJ initial",
        *(f"{name} {work / 1e6:+.1f}" for name, work in given.items() if work != 0.0),
        f"brakes {energy.brake_work / 1e6:.1f}",
        *([f"electric brakes {energy.electric_brake_work / 1e6:.1f}"] if energy.electric_brake_work else []),
        f"resistance {energy.resistance_work / 1e6:.1f}",
        f"draft gears {energy.gear_dissipated / 1e6:.2f} MJ",
    ]
    return f"{', '.join(parts)}; relative imbalance {energy.relative_imbalance:.1e}"


def _newton(solver: StepStatistics) -> str:
    iterations = f"{solver.newton_iterations_mean:.2f} iterations a step, at most {solver.newton_iterations_max}"
    divided = f"{solver.divided_steps + solver.fallback_steps} of {solver.steps} steps divided"
    return f"{iterations}; {divided}, {solver.unconverged_steps} unconverged"


def _failures(link: LinkStatus) -> dict[str, int]:
    return {
        "lost": link.lost,
        "sent again": link.retried,
        "given up": link.given_up,
        "duplicates ignored": link.duplicates,
        "out of order": link.out_of_order,
    }


def _radio(slave: str, link: LinkStatus) -> str:
    """What went wrong on a link; empty: nothing."""
    wrong = [f"{count} {what}" for what, count in _failures(link).items() if count]
    return f"{slave}: {link.sent} telegrams, {', '.join(wrong)}" if wrong else ""


def _radio_json(links: Mapping[str, LinkStatus]) -> dict[str, dict[str, int]]:
    return {
        slave: {"sent": link.sent} | {what.replace(" ", "_"): count for what, count in _failures(link).items()}
        for slave, link in links.items()
    }


def _peak_json(name: str, unit: str, factor: float, peak: CouplerPeak | None) -> dict[str, Any]:
    found = {
        f"{name}_{unit}": peak.value * factor if peak else 0.0,
        f"{name}_coupler": peak.coupler if peak else None,
        f"{name}_between": list(peak.between) if peak else None,
        f"{name}_position": peak.position if peak else None,
    }
    if peak and peak.time is not None:
        found[f"{name}_time_s"] = peak.time
    return found


def _overspeed_json(worst: Overspeed) -> dict[str, float]:
    return {
        "speed_kmh": mps_to_kmh(worst.speed),
        "limit_kmh": mps_to_kmh(worst.limit),
        "chainage_m": worst.chainage,
        "time_s": worst.time_ns / NS_PER_S,
    }


def _energy_json(energy: EnergyBalance) -> dict[str, float]:
    return {
        "kinetic_start_MJ": energy.kinetic_start / 1e6,
        "kinetic_MJ": energy.kinetic / 1e6,
        "brake_work_MJ": energy.brake_work / 1e6,
        "resistance_work_MJ": energy.resistance_work / 1e6,
        "gravity_work_MJ": energy.gravity_work / 1e6,
        "traction_work_MJ": energy.traction_work / 1e6,
        "electric_brake_work_MJ": energy.electric_brake_work / 1e6,
        "gear_stored_MJ": energy.gear_stored / 1e6,
        "gear_dissipated_MJ": energy.gear_dissipated / 1e6,
        "relative_imbalance": energy.relative_imbalance,
    }


def _newton_json(solver: StepStatistics) -> dict[str, float]:
    return {
        "steps": solver.steps,
        "iterations_mean": solver.newton_iterations_mean,
        "iterations_max": solver.newton_iterations_max,
        "divided_steps": solver.divided_steps,
        "fallback_steps": solver.fallback_steps,
        "unconverged_steps": solver.unconverged_steps,
        "worst_residual_N": solver.worst_residual,
    }
