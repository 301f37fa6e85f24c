"""The quantities of a page, gathered from a recording piece by piece."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haul_ros.analysis.history import Thinning
from haul_ros.model.sample import FloatArray
from haul_ros.page.train import head_middle_tail, places_of
from haul_ros.recording.series import PressureSeries, Samples
from haul_ros.recording.train_source import TrainSource
from haul_ros.units import mps_to_kmh


class PageSamples:
    """Quantities of a train at no more than ``most`` instants; of several samples in one that of largest magnitude."""

    def __init__(self, source: TrainSource, most: int) -> None:
        couplers, vehicles = len(source.couplers), len(source.couplers) + 1
        self._rows = {"force": couplers, "stroke": couplers, "speed": 3, "cylinder": vehicles, "pipe": vehicles}
        self._taken = {key: Thinning(source.samples, most) for key in self._rows}
        self._has_pipe = False
        self.places: list[float] = []
        """How far each vehicle was behind the head in the first sample [m], empty: vehicles were not recorded."""

    def add(self, block: Samples) -> None:
        """The next samples."""
        couplers, vehicles, pressure = block
        self._add("force", couplers.time_ns, couplers.force / 1e3)
        self._add("stroke", couplers.time_ns, couplers.stroke * 1e3)
        if len(vehicles.time_ns):
            self.places = self.places or places_of(vehicles.chainage[0])
            self._add("speed", vehicles.time_ns, mps_to_kmh(1.0) * head_middle_tail(vehicles.speed))
        self._add("cylinder", pressure.time_ns, pressure.pressure / 1e3)

    def add_pipe(self, pipe: PressureSeries) -> None:
        """Pressures of the brake pipe, of a pneumatic brake."""
        self._has_pipe = True
        self._add("pipe", pipe.time_ns, pipe.pressure / 1e3)

    def _add(self, key: str, time_ns: NDArray[np.int64], values: FloatArray) -> None:
        if len(time_ns) and values.shape[1] == self._rows[key]:
            self._taken[key].add(time_ns, values)

    @property
    def time(self) -> FloatArray:
        """Of each instant (n,) [s]."""
        return self._taken["force"].time

    def quantities(self) -> dict[str, FloatArray]:
        """Force [kN], stroke [mm], speed [km/h], pressures [kPa] (n, k) at all instants: the newest that had come.

        What was not recorded is NaN; the brake pipe is there with a pneumatic brake only.
        """
        keys = [key for key in self._rows if key != "pipe" or self._has_pipe]
        return {key: self._at_instants(key) for key in keys}

    def _at_instants(self, key: str) -> FloatArray:
        taken, time = self._taken[key], self.time
        if not len(taken.time):
            return np.full((len(time), self._rows[key]), np.nan)
        newest = np.searchsorted(taken.time, time, side="right") - 1
        return taken.values[np.maximum(newest, 0)]
