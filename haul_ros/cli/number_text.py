"""The numbers of a recording in words and as JSON, in the units of the field."""

from __future__ import annotations

from typing import Any

import numpy as np

from haul_ros.analysis.brake_timing import LEVELS
from haul_ros.analysis.energy_flow import SampledEnergy
from haul_ros.analysis.number_tables import energy_columns, radio_table, stop_table, train_table
from haul_ros.analysis.numbers import CouplerNumbers, Numbers
from haul_ros.analysis.run_in import LEAST_FORCE
from haul_ros.analysis.train_layout import TrainLayout
from haul_ros.errors import one_line
from haul_ros.model.sample import FloatArray
from haul_ros.units import mps_to_kmh

_MOST_STOPS = 5
"""Brake applications that are told in words; the table has all."""


def number_lines(numbers: Numbers, layout: TrainLayout) -> list[tuple[str, str]]:
    """The numbers in words, each with its name."""
    couplers = numbers.couplers
    every = f"every {numbers.period:.6g} s, at most {numbers.largest_gap:.6g} s apart"
    entries = [
        ("samples", f"{numbers.samples} from {numbers.begin:.3f} to {numbers.end:.3f} s, {every}"),
        *_stop_lines(numbers, layout),
        *_radio_lines(numbers),
        ("run-ins", _contacts(couplers, run_in=True)),
        ("run-outs", _contacts(couplers, run_in=False)),
        ("force reversals", _reversals(couplers)),
        (f"above {couplers.limit / 1e3:.0f} kN", _above(couplers)),
    ]
    if (dissipated := couplers.dissipated) is not None:
        told = f"{dissipated.sum() / 1e6:.3f} MJ, {_most(couplers, dissipated / 1e3, 'kJ')}"
        entries.append(("gears dissipated", told))
    if (spectrum := couplers.spectrum) is not None and len(couplers.names):
        told = f"damage-equivalent range of one cycle, m = {spectrum.exponent:g}: "
        entries.append(("fatigue", told + _most(couplers, spectrum.equivalent_range() / 1e3, "kN")))
    if (energy := numbers.train.energy) is not None:
        entries.append(("energy, samples", _energy(energy)))
    return entries + [("left out", one_line(note)) for note in numbers.notes]


def peak_lines(numbers: Numbers, layout: TrainLayout) -> list[tuple[str, str]]:
    """What stands in place of a summary, where there is none: of a part of the time, or without scenario."""
    best, couplers, motion = numbers.couplers.best, numbers.couplers, numbers.train.motion
    entries = [("train", f"{len(layout.vehicles)} vehicles, {len(layout.couplers)} couplers")]
    if len(motion.time):
        since = motion.standing_since
        end = (
            f"at {mps_to_kmh(float(motion.head_speed[-1])):.1f} km/h"
            if since is None
            else f"standing since {since:.3f} s"
        )
        begin = f"from {mps_to_kmh(float(motion.head_speed[0])):.1f} km/h"
        entries.append(("motion", f"{begin}, {end} after {motion.distance:.1f} m"))
    for name, force, time in (
        ("peak compression", best.compression, best.compression_time),
        ("peak tension", best.tension, best.tension_time),
    ):
        at = int(np.argmax(force)) if len(force) else 0
        told = f"{force[at] / 1e3:.1f} kN at {time[at]:.3f} s in {couplers.names[at]}" if force.any() else "none"
        entries.append((name, told))
    stroke = np.maximum(best.compression_stroke, best.tension_stroke)
    entries.append(("largest stroke", _most(couplers, stroke * 1e3, "mm")))
    return entries


def numbers_json(numbers: Numbers) -> dict[str, Any]:
    """The numbers as a JSON object, units in the keys; those of single couplers are in the tables."""
    couplers = numbers.couplers
    found = couplers.contacts
    (row,) = _records(train_table(numbers))
    return {
        "samples": {key: row[key] for key in ("begin_s", "end_s", "samples", "sample_period_s", "largest_gap_s")},
        "train": {key: value for key, value in row.items() if key in _MOTION},
        "energy_from_samples": energy_columns(numbers.train.energy) if numbers.train.energy else None,
        "brake_applications": _records(stop_table(numbers.train.stops)) if numbers.train.stops else [],
        "radio_delays": _records(radio_table(numbers.train.radio)) if numbers.train.radio else [],
        "run_ins": int(found.run_in.sum()),
        "fastest_run_in_m_per_s": float(found.speed[found.run_in].max(initial=0.0)),
        "run_outs": int((~found.run_in).sum()),
        "fastest_run_out_m_per_s": float(found.speed[~found.run_in].max(initial=0.0)),
        "force_reversals": int((couplers.to_buff + couplers.to_draft).sum()),
        "limit_kN": couplers.limit / 1e3,
        "longest_time_above_limit_s": float(_time_above(couplers).max(initial=0.0)),
        "largest_damage_equivalent_range_kN": (
            None if couplers.spectrum is None else float(couplers.spectrum.equivalent_range().max(initial=0.0)) / 1e3
        ),
        "damage_exponent": None if couplers.spectrum is None else couplers.spectrum.exponent,
        "peaks_from": "samples" if couplers.extremes is None else "every time step",
        "left_out": list(numbers.notes),
    }


_MOTION = ("initial_speed_kmh", "final_speed_kmh", "largest_speed_kmh", "distance_m", "standing_since_s")


def _records(table: Any) -> list[dict[str, object]]:
    return [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]


def _stop_lines(numbers: Numbers, layout: TrainLayout) -> list[tuple[str, str]]:
    entries = []
    train = numbers.train
    for number, stop in enumerate(train.stops[:_MOST_STOPS]):
        told = f"at {stop.begin:.3f} s from {mps_to_kmh(stop.initial_speed):.1f} km/h"
        if stop.stopping_time is not None and stop.stopping_distance is not None:
            told += f": stopped after {stop.stopping_time:.3f} s and {stop.stopping_distance:.1f} m"
            if stop.mean_deceleration is not None:
                told += f", {stop.mean_deceleration:.3f} m/s2 in the mean"
        else:
            told += f": at {mps_to_kmh(stop.final_speed):.1f} km/h at {stop.end:.3f} s"
        entries.append(("brake applied", f"{told}, at most {stop.largest_deceleration:.3f} m/s2"))
        if number < len(train.fillings):
            times = train.fillings[number].times
            places = [i for i in range(len(layout.vehicles)) if layout.place(i)]
            parts = [
                f"{level:.0%} after {' / '.join(f'{row[i]:.2f}' for i in places)} s"
                for level, row in zip(LEVELS, times, strict=True)
            ]
            entries.append(("  cylinders", f"{', '.join(parts)} at {', '.join(map(layout.place, places))}"))
    if len(train.stops) > _MOST_STOPS:
        entries.append(("brake applied", f"{len(train.stops) - _MOST_STOPS} times more"))
    return entries


def _energy(energy: SampledEnergy) -> str:
    parts = [
        f"{name.removesuffix('_MJ').replace('_', ' ')} {value:.1f}"
        for name, value in energy_columns(energy).items()
        if name.endswith("_MJ") and name != "imbalance_MJ" and value
    ]
    return f"{', '.join(parts)} MJ; relative imbalance {energy.relative_imbalance:.1e}"


def _radio_lines(numbers: Numbers) -> list[tuple[str, str]]:
    entries = []
    for slave in dict.fromkeys(delay.slave for delay in numbers.train.radio):
        delays = [delay.delay for delay in numbers.train.radio if delay.slave == slave]
        came = [delay for delay in delays if delay is not None]
        told = f"{min(came):.3f} to {max(came):.3f} s" if came else "none"
        missing = f", {len(delays) - len(came)} not followed" if len(came) < len(delays) else ""
        entries.append(
            ("radio delay", f"{slave}: {told} in {len(delays)} command{'s' if len(delays) > 1 else ''}{missing}")
        )
    return entries


def _contacts(couplers: CouplerNumbers, *, run_in: bool) -> str:
    chosen = np.flatnonzero(couplers.contacts.run_in == run_in)
    if not len(chosen):
        return f"none of {LEAST_FORCE / 1e3:.0f} kN and more"
    fastest = chosen[np.argmax(couplers.contacts.speed[chosen])]
    name, time = couplers.names[couplers.contacts.coupler[fastest]], couplers.contacts.time[fastest]
    speed = f"fastest at {couplers.contacts.speed[fastest]:.3f} m/s in {name} at {time:.3f} s"
    return f"{len(chosen)} of {LEAST_FORCE / 1e3:.0f} kN and more, {speed}"


def _reversals(couplers: CouplerNumbers) -> str:
    of_each = couplers.to_buff + couplers.to_draft
    if not of_each.any():
        return "none"
    return f"{of_each.sum()}, most in {couplers.names[int(np.argmax(of_each))]}: {of_each.max()}"


def _time_above(couplers: CouplerNumbers) -> FloatArray:
    return couplers.above_compression + couplers.above_tension


def _above(couplers: CouplerNumbers) -> str:
    return _most(couplers, _time_above(couplers), "s") if _time_above(couplers).any() else "never"


def _most(couplers: CouplerNumbers, values: FloatArray, unit: str) -> str:
    if not len(values):
        return "none"
    return f"at most {values.max():.4g} {unit} in {couplers.names[int(np.argmax(values))]}"
