"""Tables of a study, in the units of the field: per case, per case and coupler, quantiles along the train."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from haul_ros.analysis.tables import Table
from haul_ros.model.sample import FloatArray
from haul_ros.studies.case import CaseResult, Finished
from haul_ros.studies.sweep import PaperValues
from haul_ros.units import mps_to_kmh

QUANTILES = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
"""Of the cases, at each coupler; 0 and 1 are the smallest and the largest."""


def case_row(finished: Finished[CaseResult], paper: PaperValues) -> dict[str, object]:
    """The peaks of one case over the whole train, and what the paper's text says (None: nothing)."""
    case, result = finished.case, finished.result
    extremes, position = result.extremes, result.position
    return {
        "case": case.name,
        "scenario": case.scenario_name,
        **case.values,
        "max_force_kN": float(result.force.max()) / 1e3,
        "max_force_position": float(position[result.force.argmax()]),
        "max_draft_gear_force_kN": result.gear_force / 1e3,
        "max_compression_kN": float(extremes.compression.max()) / 1e3,
        "max_compression_position": float(position[extremes.compression.argmax()]),
        "max_tension_kN": float(extremes.tension.max()) / 1e3,
        "max_tension_position": float(position[extremes.tension.argmax()]),
        "max_stroke_mm": result.largest_stroke * 1e3,
        "stop_time_s": None if math.isnan(result.stop_time) else result.stop_time,
        "distance_m": result.distance,
        "top_speed_kmh": mps_to_kmh(result.top_speed),
        "unintended_releases": result.released,
        "unbraked_at_end": result.unbraked,
        "bottomed_couplers": int(np.isfinite(extremes.bottomed_time).sum()),
        "unconverged_steps": result.unconverged_steps,
        "relative_energy_imbalance": result.relative_imbalance,
        "energy_fault": result.energy_fault or None,
        "paper_force_kN": None if paper.force is None else paper.force / 1e3,
        "paper_stroke_mm": None if paper.stroke is None else paper.stroke * 1e3,
    }


def columns(rows: Sequence[dict[str, object]]) -> Table:
    """Rows as columns; a row without a column has None there, and a column of unlike values becomes text."""
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: _alike([row.get(name) for row in rows]) for name in names}


def _alike(values: list[object]) -> list[object]:
    given = [value for value in values if value is not None]
    kinds = {type(value) for value in given}
    if kinds <= {int, float} or kinds in ({str}, {bool}, set()):
        return values
    return [None if value is None else str(value) for value in values]


def profile_table(finished: Finished[CaseResult]) -> Table:
    """One row per coupler from the head: largest forces and strokes, as magnitudes."""
    result = finished.result
    n = len(result.geared)
    return {
        "case": [finished.case.name] * n,
        "coupler": list(range(1, n + 1)),
        "position": result.position.tolist(),
        "rigid": (~result.geared).tolist(),
        "max_compression_kN": (result.extremes.compression / 1e3).tolist(),
        "max_tension_kN": (result.extremes.tension / 1e3).tolist(),
        "max_force_kN": (result.force / 1e3).tolist(),
        "max_compression_stroke_mm": (result.extremes.compression_stroke * 1e3).tolist(),
        "max_tension_stroke_mm": (result.extremes.tension_stroke * 1e3).tolist(),
    }


def quantile_table(forces: FloatArray, position: FloatArray) -> Table:
    """Quantiles over the cases of |F| [N], given as (n_cases, n_couplers), at each coupler."""
    found = np.quantile(forces, QUANTILES, axis=0) / 1e3
    return {
        "coupler": list(range(1, len(position) + 1)),
        "position": position.tolist(),
        **{f"force_quantile_{q:g}_kN": row.tolist() for q, row in zip(QUANTILES, found, strict=True)},
    }
