"""Peaks per coupler as a table, in the units of the field, and tables as files."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from haul_ros.analysis.envelopes import bottomed_couplers, largest_force
from haul_ros.model.consist import Consist
from haul_ros.model.sample import CouplerExtremes

Table = Mapping[str, Sequence[object]]
"""Columns of equal length by name; the unit is the end of the name."""


def peak_table(consist: Consist, extremes: CouplerExtremes) -> Table:
    """One row per coupler from the head: where it is, and the largest of every time step.

    Forces and strokes are magnitudes; ``position`` is j/N for the j-th coupler of a train of N
    vehicles, ``distance_from_head_m`` that of the coupler with the train at rest, couplers free.
    """
    n, names = len(consist.vehicles), consist.vehicle_names
    bottomed = set(bottomed_couplers(consist, extremes))
    behind = np.cumsum([vehicle.length for vehicle in consist.vehicles])[:-1]
    return {
        "coupler": list(consist.coupler_names),
        "vehicle_before": list(names[:-1]),
        "vehicle_behind": list(names[1:]),
        "position": [j / n for j in range(1, n)],
        "distance_from_head_m": behind.tolist(),
        "max_compression_kN": (extremes.compression / 1e3).tolist(),
        "max_compression_time_s": extremes.compression_time.tolist(),
        "max_tension_kN": (extremes.tension / 1e3).tolist(),
        "max_tension_time_s": extremes.tension_time.tolist(),
        "max_force_kN": (largest_force(extremes) / 1e3).tolist(),
        "max_compression_stroke_mm": (extremes.compression_stroke * 1e3).tolist(),
        "max_tension_stroke_mm": (extremes.tension_stroke * 1e3).tolist(),
        "bottomed": [j in bottomed for j in range(n - 1)],
    }


def write_csv(table: Table, path: Path) -> None:
    """Write a table as CSV (RFC 4180), numbers to nine significant digits."""
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(table)
        for row in zip(*table.values(), strict=True):
            writer.writerow(f"{value:.9g}" if isinstance(value, float) else value for value in row)


def parquet_available() -> bool:
    """Whether pyarrow, which writes Parquet, is installed."""
    return find_spec("pyarrow") is not None


def write_parquet(table: Table, path: Path) -> None:
    """Write a table as Parquet, numbers in full; needs pyarrow."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({name: list(column) for name, column in table.items()}), path)
