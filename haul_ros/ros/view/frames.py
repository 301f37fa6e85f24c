"""Samples from topics to frames of the page: ten a second, in the units of the field."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from haul_ros.messages.cdr import ArrayCodec, JointStateCodec
from haul_ros.messages.quantities import CouplerArrays, VehicleArrays, pressure_codec
from haul_ros.model.sample import FloatArray
from haul_ros.page.train import head_middle_tail, places_of
from haul_ros.units import NS_PER_S, mps_to_kmh

_STAMP = struct.Struct("<iI")
_STAMP_PLACE = 4
"""Behind the head of CDR."""


class FrameMaker:
    """Makes frames of one train, whose names it takes from the first messages.

    A frame is the time [s] as float64, then float32: speed of head, middle and tail [km/h], force [kN] and stroke [mm]
    of each coupler, pressure [kPa] of each brake cylinder and, of a pneumatic brake, of the brake pipe at each vehicle.
    Of several samples in a frame it has the forces of largest magnitude, so that no peak is lost, else the last.
    """

    def __init__(self, *, pneumatic: bool) -> None:
        self.pneumatic = pneumatic
        self.couplers: JointStateCodec | None = None
        self.vehicles: JointStateCodec | None = None
        self._pressure: ArrayCodec | None = None
        self.places: list[float] = []
        """How far each vehicle was behind the head in the first message [m]."""
        self._speed = np.zeros(3)
        self._cylinder = self._pipe = np.zeros(0)

    @property
    def complete(self) -> bool:
        """Whether all names are known."""
        return self.couplers is not None and self.vehicles is not None

    def frame(
        self, couplers: Sequence[bytes], vehicles: Sequence[bytes], cylinder: Sequence[bytes], pipe: Sequence[bytes]
    ) -> tuple[float, bytes] | None:
        """Time [s] and frame of messages that have come, None: there is nothing new, or not yet all that it needs.

        Raises
        ------
        ValueError
            A message is of another train.
        """
        if couplers and self.couplers is None:
            self.couplers = JointStateCodec.of(couplers[-1])
        if vehicles and self.vehicles is None:
            self.vehicles = JointStateCodec.of(vehicles[-1])
            chainage = VehicleArrays(*self.vehicles.decode(vehicles[-1])).chainage
            self.places = places_of(chainage)
            self._pressure = pressure_codec(len(self.vehicles.names))
            self._cylinder = self._pipe = np.zeros(len(self.vehicles.names))
        if self.couplers is None or self.vehicles is None or self._pressure is None:
            return None
        if vehicles:
            speed = VehicleArrays(*self.vehicles.decode(vehicles[-1])).speed
            self._speed = mps_to_kmh(1.0) * head_middle_tail(speed[np.newaxis])[0]
        if cylinder:
            self._cylinder = self._pressure.decode(cylinder[-1]) / 1e3
        if pipe:
            self._pipe = self._pressure.decode(pipe[-1]) / 1e3
        if not couplers:
            return None
        arrays = [CouplerArrays(*self.couplers.decode(message)) for message in couplers]
        force = _largest(np.array([array.force for array in arrays])) / 1e3
        values = [
            self._speed,
            force,
            arrays[-1].stroke * 1e3,
            self._cylinder,
            *([self._pipe] if self.pneumatic else []),
        ]
        time = sample_time(couplers[-1])
        return time, struct.pack("<d", time) + np.concatenate(values).astype("<f4").tobytes()


def sample_time(message: bytes) -> float:
    """The stamp of a message that begins with a header [s]."""
    seconds, nanoseconds = _STAMP.unpack_from(message, _STAMP_PLACE)
    return float(seconds) + float(nanoseconds) / NS_PER_S


def _largest(values: FloatArray) -> FloatArray:
    """Of values (n, k) those of largest magnitude (k,)."""
    highest, lowest = values.max(axis=0), values.min(axis=0)
    largest: FloatArray = np.where(highest >= -lowest, highest, lowest)
    return largest
