"""Calls of the kernel short enough to be interrupted between them."""

from __future__ import annotations

LONGEST = 0.1
"""Wall time [s] that a call is to take at most: twice as long if steps become costlier at once."""
_FIRST = 256


class Slices:
    """How many time steps to do in one call, from how long the calls so far have taken."""

    def __init__(self) -> None:
        self.steps = _FIRST

    def took(self, steps: int, seconds: float) -> None:
        """Learn from a call of so many steps."""
        if seconds > LONGEST:
            self.steps = max(1, int(steps * LONGEST / seconds))
        elif steps == self.steps and seconds < LONGEST / 4.0:
            self.steps *= 2
