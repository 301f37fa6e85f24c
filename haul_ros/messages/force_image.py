"""The last minutes of all coupler forces as a picture that scrolls, for viewers of ROS."""

from __future__ import annotations

import numpy as np

from haul_ros.messages.cdr import new_header, new_message, serialize
from haul_ros.messages.force_colours import force_colours
from haul_ros.model.sample import FloatArray
from haul_ros.units import NS_PER_S

IMAGE = "sensor_msgs/msg/Image"

COLUMNS = 300
"""Of a picture; each is the time between two pictures."""


class ForceImage:
    """A ``sensor_msgs/Image`` (rgb8) with a row for each coupler, head on top, and time to the right, now at the edge.

    A column shows of each coupler the force that was largest, in whichever direction, since the column before.
    """

    def __init__(self, couplers: int) -> None:
        self._forces = np.zeros((couplers, COLUMNS))
        self._largest = np.zeros(couplers)

    def add(self, force: FloatArray) -> None:
        """Take the forces (n_couplers,) [N] of a sample."""
        self._largest = np.where(np.abs(force) > np.abs(self._largest), force, self._largest)

    def scroll(self, time_ns: int, frame: str, limit: float) -> bytes:
        """End a column, and give the CDR bytes of the picture; forces of ``limit`` [N] have the darkest colours."""
        self._forces = np.roll(self._forces, -1, axis=1)
        self._forces[:, -1] = self._largest
        self._largest = np.zeros_like(self._largest)
        header = new_header(*divmod(time_ns, NS_PER_S), frame)
        pixels = force_colours(self._forces, limit)
        rows, columns, channels = pixels.shape
        image = new_message(IMAGE, header, rows, columns, "rgb8", 0, columns * channels, pixels.ravel())
        return serialize(image, IMAGE)
