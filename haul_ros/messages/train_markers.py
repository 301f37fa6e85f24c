"""The train as coloured boxes, for RViz and the 3D panels of others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from haul_ros.messages.cdr import new_header, new_message, serialize
from haul_ros.messages.force_colours import force_colours
from haul_ros.model.consist import Consist
from haul_ros.model.sample import FloatArray, Sample
from haul_ros.units import NS_PER_S

MARKER = "visualization_msgs/msg/Marker"
MARKERS = "visualization_msgs/msg/MarkerArray"

_CUBE_LIST, _TEXT, _ADD = 6, 9, 0
_GAP = 0.8
"""Of its length [m], what a vehicle's box lacks for the couplers at its ends to be seen."""
_WIDTH, _HEIGHT, _LOCOMOTIVE_HEIGHT = 3.2, 3.6, 5.0
"""Of the boxes [m]; assumed, no vehicle's own."""
_LETTERS = 8.0
"""Height [m] of letters."""


class TrainMarkers:
    """A ``visualization_msgs/MarkerArray``: x forward from where the head of the train is, z upwards, in metres.

    One list of cubes for each length of vehicles, in namespace ``vehicles``; the locomotives are those of
    ``locomotives`` and taller. A vehicle has the colour of the larger force at its two ends. ``largest`` is a text at
    the coupler of the largest force of all, with its number and force in kN.
    """

    def __init__(self, consist: Consist) -> None:
        lengths = np.array([vehicle.length for vehicle in consist.vehicles])
        driven = np.zeros(len(lengths), dtype=bool)
        driven[[locomotive.vehicle for locomotive in consist.locomotives]] = True
        self._half_length = lengths[0] / 2.0
        self._names = consist.coupler_names
        self._lists = [
            (name, height, float(length), np.flatnonzero((lengths == length) & (driven == of_locomotives)))
            for of_locomotives, name, height in (
                (False, "vehicles", _HEIGHT),
                (True, "locomotives", _LOCOMOTIVE_HEIGHT),
            )
            for length in np.unique(lengths[driven == of_locomotives])
        ]

    def encode(self, sample: Sample, frame: str, limit: float) -> bytes:
        """CDR bytes for a sample; forces of ``limit`` [N] have the darkest colours.

        The frame moves along the line with the head of the train, so boxes stay where the viewer looks.
        """
        header = new_header(*divmod(sample.time_ns, NS_PER_S), frame)
        x = sample.chainage - (sample.chainage[0] + self._half_length)
        colours = force_colours(_larger_at_ends(sample.coupler_force), limit) / 255.0
        boxes = [
            _marker(
                header,
                (name, number),
                _CUBE_LIST,
                scale=(length - _GAP, _WIDTH, height),
                points=[(x[i], 0.0, height / 2.0) for i in of],
                colours=colours[of],
            )
            for number, (name, height, length, of) in enumerate(self._lists)
        ]
        return serialize(new_message(MARKERS, [*boxes, *self._largest(header, sample.coupler_force, x)]), MARKERS)

    def _largest(self, header: Any, force: FloatArray, x: FloatArray) -> list[Any]:
        if not len(force):
            return []
        at = int(np.argmax(np.abs(force)))
        text = f"{self._names[at]}: {force[at] / 1e3:.0f} kN"
        place = ((x[at] + x[at + 1]) / 2.0, 0.0, _LOCOMOTIVE_HEIGHT + _LETTERS)
        return [_marker(header, ("largest", 0), _TEXT, scale=(0.0, 0.0, _LETTERS), place=place, text=text)]


def _larger_at_ends(force: FloatArray) -> FloatArray:
    """Of the forces (n,) at its two ends the larger in magnitude for each of n + 1 vehicles."""
    ahead, behind = np.concatenate(([0.0], force)), np.concatenate((force, [0.0]))
    larger: FloatArray = np.where(np.abs(ahead) > np.abs(behind), ahead, behind)
    return larger


def _marker(
    header: Any,
    name: tuple[str, int],
    kind: int,
    *,
    scale: tuple[float, float, float],
    place: tuple[float, float, float] = (0.0, 0.0, 0.0),
    points: Sequence[tuple[float, float, float]] = (),
    colours: Sequence[Any] | np.ndarray[Any, Any] = (),
    text: str = "",
) -> Any:
    point, quaternion, rgba = "geometry_msgs/msg/Point", "geometry_msgs/msg/Quaternion", "std_msgs/msg/ColorRGBA"
    nowhere = np.empty(0, np.uint8)
    return new_message(
        MARKER,
        header,
        *name,
        kind,
        _ADD,
        new_message("geometry_msgs/msg/Pose", new_message(point, *place), new_message(quaternion, 0.0, 0.0, 0.0, 1.0)),
        new_message("geometry_msgs/msg/Vector3", *scale),
        new_message(rgba, 0.6, 0.6, 0.6, 1.0),
        new_message("builtin_interfaces/msg/Duration", 0, 0),
        False,
        [new_message(point, *place) for place in points],
        [new_message(rgba, *colour, 1.0) for colour in colours],
        "",
        new_message("sensor_msgs/msg/CompressedImage", new_header(0, 0), "", nowhere),
        [],
        text,
        "",
        new_message("visualization_msgs/msg/MeshFile", "", nowhere),
        False,
    )
