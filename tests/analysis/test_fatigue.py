"""Rainflow counting against the example of the standard, and a damage-equivalent range by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from haul_ros.analysis import fatigue
from haul_ros.analysis.fatigue import BIN_WIDTH, FatigueCounter, rainflow_cycles, turning_points

ASTM_E1049 = np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0])
"""Fig. 6 of the standard."""


def test_the_example_of_the_standard() -> None:
    found = rainflow_cycles(ASTM_E1049)

    # Its table: range 3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5
    counted = {size: float(found.counts[found.ranges == size].sum()) for size in set(found.ranges.tolist())}
    assert counted == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    assert found.means[found.counts == 1.0].tolist() == [1.0]  # the cycle from -1 to 3


def test_a_force_that_only_rises_is_half_a_cycle() -> None:
    found = rainflow_cycles(np.array([0.0, 1.0, 2.0, 7.0]))

    assert (found.ranges.tolist(), found.counts.tolist(), found.means.tolist()) == ([7.0], [0.5], [3.5])


def test_of_one_value_there_is_no_cycle() -> None:
    assert not len(rainflow_cycles(np.array([3.0, 3.0, 3.0])).ranges)
    assert not len(rainflow_cycles(np.empty(0)).ranges)


def test_turning_points() -> None:
    assert turning_points(np.array([1.0, 1.0, 2.0, 3.0, 3.0, 0.0, 0.0])).tolist() == [1.0, 3.0, 0.0]


def test_the_damage_equivalent_range_by_hand() -> None:
    counter = FatigueCounter(2, exponent=3.0)
    # 0 - 300 - 0 kN and to and fro between 0 and 100 kN twice: halves of 300 kN twice, of 100 kN four times
    counter.add(np.array([[0.0, 0.0], [300e3, 0.0], [0.0, 0.0], [100e3, 0.0], [0.0, 0.0], [100e3, 0.0], [0.0, 0.0]]))

    spectrum = counter.spectrum()
    assert spectrum.cycles.tolist() == [3.0, 0.0]
    assert spectrum.largest_range.tolist() == [300e3, 0.0]
    # 1 * 300^3 + 2 * 100^3 = 29e6 kN^3
    assert spectrum.equivalent_range() == pytest.approx([29e6 ** (1 / 3) * 1e3, 0.0])
    assert spectrum.equivalent_range(2.0)[0] == pytest.approx(14.5e6 ** (1 / 3) * 1e3)
    assert BIN_WIDTH == 50e3
    assert spectrum.histogram[0].tolist() == [0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0]


@given(
    values=st.lists(st.integers(-9, 9), min_size=1, max_size=60),
    cuts=st.lists(st.integers(0, 60), max_size=6),
)
def test_pieces_give_what_the_whole_gives(values: list[int], cuts: list[int]) -> None:
    force = np.array(values, dtype=float) * 1e4
    whole = rainflow_cycles(force)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fatigue, "_MOST_POINTS", 3)  # counted over and over, as of a file of hours
        counter = FatigueCounter(1)
        for piece in np.split(force, sorted(min(cut, len(force)) for cut in cuts)):
            counter.add(piece[:, None])
        spectrum = counter.spectrum()

    assert spectrum.cycles[0] == whole.counts.sum()
    assert spectrum.damage[0] == pytest.approx(whole.counts @ whole.ranges**5, rel=1e-12)
    bins = np.bincount((whole.ranges // BIN_WIDTH).astype(int), whole.counts, spectrum.histogram.shape[1])
    assert spectrum.histogram[0].tolist() == bins.tolist()
