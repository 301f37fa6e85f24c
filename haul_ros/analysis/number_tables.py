"""The numbers of a train as tables, in the units of the field, which end the names of their columns."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from haul_ros.analysis.brake_timing import LEVELS, Filling
from haul_ros.analysis.energy_flow import SampledEnergy
from haul_ros.analysis.envelopes import bottomed, largest_force
from haul_ros.analysis.fatigue import BIN_WIDTH, Spectrum
from haul_ros.analysis.motion import Stop
from haul_ros.analysis.numbers import CouplerNumbers, Numbers
from haul_ros.analysis.radio_delays import RadioDelay
from haul_ros.analysis.run_in import Contacts
from haul_ros.analysis.tables import Table
from haul_ros.analysis.train_layout import TrainLayout
from haul_ros.model.event import Event
from haul_ros.units import NS_PER_S, mps_to_kmh

_ENERGIES = {
    "kinetic_start": "kinetic_energy_start_MJ",
    "kinetic": "kinetic_energy_end_MJ",
    "brake_work": "brake_work_MJ",
    "resistance_work": "resistance_work_MJ",
    "gravity_work": "gravity_work_MJ",
    "traction_work": "traction_work_MJ",
    "electric_brake_work": "electric_brake_work_MJ",
    "gear_stored": "gear_stored_MJ",
    "gear_dissipated": "gear_dissipated_MJ",
    "imbalance": "imbalance_MJ",
}


def number_tables(
    numbers: Numbers, layout: TrainLayout, couplers: Collection[int] | None = None, events: Iterable[Event] = ()
) -> dict[str, Table]:
    """All tables by the names of their files; those of which nothing is known are left out.

    ``couplers`` are the chosen ones, by column (None: all).
    """
    names = None if couplers is None else {numbers.couplers.names[j] for j in couplers}
    tables: dict[str, Table] = {
        "peaks": _of(names, coupler_table(numbers.couplers, layout)),
        "run_ins": _of(names, contact_table(numbers.couplers)),
        "train": train_table(numbers),
    }
    if numbers.couplers.spectrum is not None:
        tables["rainflow"] = _of(names, rainflow_table(numbers.couplers.names, numbers.couplers.spectrum))
    if numbers.train.stops:
        tables["brake_applications"] = stop_table(numbers.train.stops)
    if numbers.train.fillings:
        tables["brake_timing"] = timing_table(numbers.train.fillings, layout)
    if numbers.train.radio:
        tables["radio_delays"] = radio_table(numbers.train.radio)
    if told := [event for event in events if numbers.begin <= event.time_ns / NS_PER_S <= numbers.end]:
        tables["events"] = event_table(told)
    return tables


def coupler_table(numbers: CouplerNumbers, layout: TrainLayout) -> Table:
    """One row per coupler from the head: where it is, its extremes, and what it went through.

    Forces and strokes are magnitudes; ``position`` is j/N for the j-th coupler of a train of N vehicles,
    ``distance_from_head_m`` that of the coupler with the train at rest, couplers free.
    """
    best, peaks, count = numbers.best, numbers.peaks, len(numbers.names)
    of_each = _per_coupler(numbers.contacts, count)
    columns: dict[str, object] = {
        "coupler": list(numbers.names),
        "vehicle_before": list(layout.vehicles[:-1]),
        "vehicle_behind": list(layout.vehicles[1:]),
        "position": [j / (count + 1) for j in range(1, count + 1)],
    }
    if layout.lengths is not None:
        columns["distance_from_head_m"] = np.cumsum(layout.lengths)[:-1]
    columns |= {
        "max_compression_kN": best.compression / 1e3,
        "max_compression_time_s": best.compression_time,
        "max_tension_kN": best.tension / 1e3,
        "max_tension_time_s": best.tension_time,
        "max_force_kN": largest_force(best) / 1e3,
        "max_compression_stroke_mm": best.compression_stroke * 1e3,
        "max_compression_stroke_time_s": peaks.compression_stroke_time,
        "max_tension_stroke_mm": best.tension_stroke * 1e3,
        "max_tension_stroke_time_s": peaks.tension_stroke_time,
        "reversals_to_buff": numbers.to_buff,
        "reversals_to_draft": numbers.to_draft,
        "limit_kN": np.full(count, numbers.limit / 1e3),
        "time_above_limit_in_buff_s": numbers.above_compression,
        "time_above_limit_in_draft_s": numbers.above_tension,
        **of_each,
        "work_taken_kJ": numbers.work_taken / 1e3,
    }
    if layout.full_strokes is not None:
        columns["bottomed"] = bottomed(layout.full_strokes, best)
    if numbers.dissipated is not None:
        columns["dissipated_energy_kJ"] = numbers.dissipated / 1e3
    if (spectrum := numbers.spectrum) is not None:
        columns |= {
            "rainflow_cycles": spectrum.cycles,
            "largest_cycle_range_kN": spectrum.largest_range / 1e3,
            f"damage_equivalent_range_m{spectrum.exponent:g}_kN": spectrum.equivalent_range() / 1e3,
        }
    return _plain(columns)


def contact_table(numbers: CouplerNumbers) -> Table:
    """One row per run-in or run-out, in order of time."""
    found = numbers.contacts
    return _plain(
        {
            "time_s": found.time,
            "coupler": [numbers.names[j] for j in found.coupler],
            "kind": ["run-in" if run_in else "run-out" for run_in in found.run_in],
            "closing_speed_m_per_s": found.speed,
            "peak_force_kN": found.peak / 1e3,
            "peak_force_time_s": found.peak_time,
        }
    )


def rainflow_table(names: tuple[str, ...], spectrum: Spectrum) -> Table:
    """One row per coupler and class of ranges in which there are cycles."""
    rows, bins = np.nonzero(spectrum.histogram)
    return _plain(
        {
            "coupler": [names[j] for j in rows],
            "range_from_kN": bins * BIN_WIDTH / 1e3,
            "range_to_kN": (bins + 1) * BIN_WIDTH / 1e3,
            "cycles": spectrum.histogram[rows, bins],
        }
    )


def stop_table(stops: Iterable[Stop]) -> Table:
    """One row per brake application of the first locomotive."""
    return _rows(
        {
            "begin_s": stop.begin,
            "end_s": stop.end,
            "demand": stop.demand,
            "initial_speed_kmh": mps_to_kmh(stop.initial_speed),
            "final_speed_kmh": mps_to_kmh(stop.final_speed),
            "stopping_time_s": stop.stopping_time,
            "stopping_distance_m": stop.stopping_distance,
            "mean_deceleration_m_per_s2": stop.mean_deceleration,
            "largest_deceleration_m_per_s2": stop.largest_deceleration,
        }
        for stop in stops
    )


def timing_table(fillings: Iterable[Filling], layout: TrainLayout) -> Table:
    """One row per application and vehicle: how its brake cylinder filled, from the begin of the application."""
    return _rows(
        {
            "application_begin_s": filling.begin,
            "vehicle": name,
            "place": layout.place(i),
            "cylinder_pressure_kPa": float(filling.pressure[i]) / 1e3,
            **{
                f"time_to_{level * 100:g}_percent_s": float(times[i])
                for level, times in zip(LEVELS, filling.times, strict=True)
            },
        }
        for filling in fillings
        for i, name in enumerate(layout.vehicles)
    )


def radio_table(delays: Iterable[RadioDelay]) -> Table:
    """One row per change of the master's brake and slave that should follow."""
    return _rows(
        {"slave": delay.slave, "time_s": delay.time, "demand": delay.demand, "delay_s": delay.delay} for delay in delays
    )


def event_table(events: Iterable[Event]) -> Table:
    """One row per event."""
    return _rows({"time_s": event.time_ns / NS_PER_S, "kind": event.kind.value, "text": event.text} for event in events)


def train_table(numbers: Numbers) -> Table:
    """One row: the train as a whole, from the first sample to the last."""
    columns: dict[str, object] = {
        "begin_s": numbers.begin,
        "end_s": numbers.end,
        "samples": numbers.samples,
        "sample_period_s": numbers.period,
        "largest_gap_s": numbers.largest_gap,
    }
    if len((motion := numbers.train.motion).time):
        columns |= {
            "initial_speed_kmh": mps_to_kmh(float(motion.head_speed[0])),
            "final_speed_kmh": mps_to_kmh(float(motion.head_speed[-1])),
            "largest_speed_kmh": mps_to_kmh(float(motion.head_speed.max())),
            "distance_m": motion.distance,
            "standing_since_s": motion.standing_since,
        }
    if (energy := numbers.train.energy) is not None:
        columns |= energy_columns(energy)
    return {name: [value] for name, value in columns.items()}


def energy_columns(energy: SampledEnergy) -> dict[str, float]:
    """Energies [MJ], and the relative imbalance."""
    found = {column: getattr(energy, name) / 1e6 for name, column in _ENERGIES.items()}
    return found | {"relative_imbalance": energy.relative_imbalance}


def arrays_of(tables: Mapping[str, Table], numbers: Numbers) -> dict[str, NDArray[np.generic]]:
    """Every column of the tables as an array ``table.column``, and the motion of the train at every sample."""
    arrays = {
        f"{name}.{column}": np.array([np.nan if value is None else value for value in values])
        for name, table in tables.items()
        for column, values in table.items()
    }
    motion = numbers.train.motion
    return arrays | {
        "motion.time_s": motion.time,
        "motion.head_speed_kmh": mps_to_kmh(1.0) * motion.head_speed,
        "motion.tail_speed_kmh": mps_to_kmh(1.0) * motion.tail_speed,
        "motion.mean_speed_kmh": mps_to_kmh(1.0) * motion.mean_speed,
        "motion.head_chainage_m": motion.head_chainage,
    }


def _per_coupler(contacts: Contacts, couplers: int) -> dict[str, object]:
    """How many run-ins and run-outs each coupler had, and the fastest of each [m/s], 0 where there was none."""
    columns: dict[str, object] = {}
    for name, chosen in (("run_in", contacts.run_in), ("run_out", ~contacts.run_in)):
        fastest = np.zeros(couplers)
        np.maximum.at(fastest, contacts.coupler[chosen], contacts.speed[chosen])
        columns[f"{name}s"] = np.bincount(contacts.coupler[chosen], minlength=couplers)
        columns[f"fastest_{name}_m_per_s"] = fastest
    return columns


def _plain(columns: Mapping[str, object]) -> Table:
    """Arrays as lists of Python's numbers."""
    return {name: column.tolist() if isinstance(column, np.ndarray) else column for name, column in columns.items()}  # type: ignore[misc]


def _of(names: Collection[str] | None, table: Table) -> Table:
    """The rows of some couplers, None: of all."""
    if names is None:
        return table
    rows = [i for i, name in enumerate(table["coupler"]) if name in names]
    return {column: [values[i] for i in rows] for column, values in table.items()}


def _rows(rows: Iterable[Mapping[str, object]]) -> Table:
    """Rows with the same names as columns; at least one."""
    found = list(rows)
    return {name: [row[name] for row in found] for name in found[0]}
