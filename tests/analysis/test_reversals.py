"""Reversals between buff and draft, counted by hand."""

import numpy as np
import pytest

from haul_ros.analysis.reversals import ReversalCounter, force_reversals

# Beyond 10 kN: buff, draft, (0, +5: neither), draft, buff: one to draft, one to buff. The second coupler goes to and
# fro within the dead band, then comes into buff, from nowhere: none. The third comes from draft over 0 into buff.
FORCE = np.array(
    [[20e3, 9e3, -50e3], [-20e3, -9e3, 0.0], [0.0, 9e3, 9e3], [5e3, -9e3, 0.0], [-11e3, 0.0, 11e3], [50e3, 20e3, 0.0]]
)


def test_reversals_are_changes_of_side_whatever_lies_between() -> None:
    assert force_reversals(FORCE).tolist() == [2, 0, 1]


@pytest.mark.parametrize("cut", range(7))
def test_pieces_give_what_the_whole_gives(cut: int) -> None:
    counter = ReversalCounter(3)
    counter.add(FORCE[:cut])
    counter.add(FORCE[cut:])

    assert counter.to_buff.tolist() == [1, 0, 1]
    assert counter.to_draft.tolist() == [1, 0, 0]
