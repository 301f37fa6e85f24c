"""The train as the page knows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from haul_ros.model.command import Command
from haul_ros.model.sample import CouplerExtremes, FloatArray

Message = str | bytes
"""To a live page: JSON text, or the bytes of a frame."""


def train(
    couplers: Sequence[str],
    vehicles: Sequence[str],
    locomotives: Mapping[str, int | None],
    places: Sequence[float],
    *,
    pneumatic: bool,
) -> dict[str, object]:
    """Names from the head; ``locomotives`` are indices of vehicles by name, None: not known.

    ``places`` says how far each vehicle is behind the head [m], empty: not known.
    """
    return {
        "couplers": list(couplers),
        "vehicles": list(vehicles),
        "locomotives": [{"name": name, "vehicle": vehicle} for name, vehicle in locomotives.items()],
        "places": list(places),
        "pneumatic": pneumatic,
    }


def locomotive_vehicles(vehicles: Sequence[str], locomotives: Sequence[str]) -> dict[str, int | None]:
    """At which vehicle (index) each locomotive is; None: not known.

    No topic tells it. Where as many vehicles are of the type of the first, ``SS4`` in ``vehicle_001_SS4``, as there are
    locomotives, these are they, as in all shipped scenarios.
    """
    types = [name.split("_", 2)[-1] for name in vehicles]
    alike = [index for index, kind in enumerate(types) if kind == types[0]]
    if len(alike) != len(locomotives):
        return dict.fromkeys(locomotives)
    return dict(zip(locomotives, alike, strict=True))


def places_of(chainage: FloatArray) -> list[float]:
    """How far each vehicle is behind the head [m], of chainages (n_vehicles,) [m]."""
    return [float(place) for place in np.nan_to_num(chainage[0] - chainage)]


def head_middle_tail(values: FloatArray) -> FloatArray:
    """Of values (n, vehicles) those of head, middle and tail (n, 3)."""
    last = values.shape[1] - 1
    return values[:, [0, last // 2, last]]


def peaks(extremes: CouplerExtremes) -> dict[str, list[float]]:
    """Largest forces [kN] and strokes [mm] of each coupler as magnitudes, times [s]."""
    found = {
        "compression": extremes.compression / 1e3,
        "compression_time": extremes.compression_time,
        "tension": extremes.tension / 1e3,
        "tension_time": extremes.tension_time,
        "compression_stroke": extremes.compression_stroke * 1e3,
        "tension_stroke": extremes.tension_stroke * 1e3,
    }
    return {name: np.nan_to_num(values, posinf=0.0, neginf=0.0).tolist() for name, values in found.items()}


def command_entry(time: float, command: Command) -> dict[str, object]:
    """A command at a time [s], as the page draws it."""
    return {"time": time, "locomotive": command.locomotive, "kind": command.kind.value, "value": command.value}
