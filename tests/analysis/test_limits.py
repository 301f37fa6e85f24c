"""Times above a limit, as areas under straight lines."""

import numpy as np
import pytest

from haul_ros.analysis.limits import STRENGTH_LIMIT, LimitWatch, time_above

TIME = np.array([0.0, 1.0, 2.0, 4.0])
# From 0 to 3000 kN in 1 s: above 2250 kN for its last quarter; there for 1 s; down to -3000 kN in 2 s: above for its
# first eighth, 0.25 s, and below -2250 kN for its last, 0.25 s.
FORCE = np.array([[0.0], [3e6], [3e6], [-3e6]])


def test_time_above_is_that_of_straight_lines_between_samples() -> None:
    assert STRENGTH_LIMIT == 2_250_000.0
    assert time_above(TIME, FORCE, 2.25e6) == pytest.approx([0.25 + 1.0 + 0.25])
    assert time_above(TIME, -FORCE, 2.25e6) == pytest.approx([0.25])
    assert time_above(TIME, FORCE, 3e6).tolist() == [0.0]  # at the limit is not above it
    assert time_above(TIME[:1], FORCE[:1], 1.0).tolist() == [0.0]


@pytest.mark.parametrize("cut", range(5))
def test_pieces_give_what_the_whole_gives(cut: int) -> None:
    watch = LimitWatch(1)
    watch.add(TIME[:cut], FORCE[:cut])
    watch.add(TIME[cut:], FORCE[cut:])

    assert watch.compression == pytest.approx([1.5])
    assert watch.tension == pytest.approx([0.25])
