"""Samples that cannot be of a train, told before they become numbers that look like others."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from haul_ros.errors import RecordingError
from haul_ros.model.sample import FloatArray
from haul_ros.recording.series import Samples, TimeArray
from haul_ros.units import NS_PER_S

LARGEST = {
    "force": 1e8,
    "stroke": 1e6,  # the parts of a train that has parted may be far from one another
    "stroke_rate": 1e4,
    "chainage": 1e9,
    "speed": 1e4,
    "brake_force": 1e8,
    "pressure": 1e9,
}
"""Magnitudes [SI] that no sample reaches: some hundred times those of any train."""


class SampleCheck:
    """Looks at the samples of a recording piece by piece."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._last_ns: dict[str, int] = {}

    def add(self, block: Samples) -> None:
        """The next samples.

        Raises
        ------
        RecordingError
            One is no number or larger than any can be, or times do not rise.
        """
        for name, series in block._asdict().items():
            if not len(series.time_ns):
                continue
            last = self._last_ns.get(name, int(series.time_ns[0]))
            if series.time_ns[0] < last or (np.diff(series.time_ns) < 0).any():
                raise RecordingError(f"{self._path}: samples of {name} are not in order of time")
            self._last_ns[name] = int(series.time_ns[-1])
            for quantity, values in _arrays(series):
                if values.size and not np.abs(values).max() <= LARGEST[quantity]:
                    raise RecordingError(f"{self._path}: {_first(quantity, series.time_ns, series.names, values)}")


def _arrays(series: object) -> Iterator[tuple[str, FloatArray]]:
    for quantity in LARGEST:
        if (values := getattr(series, quantity, None)) is not None:
            yield quantity, values


def _first(quantity: str, time_ns: TimeArray, names: tuple[str, ...], values: FloatArray) -> str:
    row, column = np.argwhere(~(np.abs(values) <= LARGEST[quantity]))[0]
    found = (
        f"{names[column]} at {time_ns[row] / NS_PER_S:.3f} s: {quantity.replace('_', ' ')} is {values[row, column]:g}"
    )
    return f"{found}, expected at most {LARGEST[quantity]:g}"
