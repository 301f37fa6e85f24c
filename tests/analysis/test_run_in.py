"""Run-ins and run-outs, worked out on paper."""

import numpy as np
import pytest

from haul_ros.analysis.run_in import ContactFinder, Contacts, contacts

TIME = np.arange(8.0)
# Coupler 0: in tension from before the first sample (no contact was seen), in its slack at 1 and 2 s, closing at 0.3
# and 0.4 m/s; it bears compression at 3 s: a run-in at 2 s, at the 0.4 m/s of that sample, 200 kN at 4 s. Between 5 and
# 6 s its force goes from 50 kN to -150 kN: 0 after a quarter, 5.25 s, where a rate from -0.2 to -0.6 m/s is -0.3: a
# run-out at 0.3 m/s, 150 kN at 6 s.
# Coupler 1: comes into compression at 0 s, reaches 40 kN alone: too little to be told of.
FORCE = np.array([[-80, 0, 0, 100, 200, 50, -150, -100], [0, 40, 30, 0, 0, 0, 0, 0]]).T * 1e3
RATE = np.array([[0.2, 0.3, 0.4, 0.1, 0.0, -0.2, -0.6, 0.1], [0.1] * 8]).T


def check(found: Contacts) -> None:
    assert found.coupler.tolist() == [0, 0]
    assert found.time == pytest.approx([2.0, 5.25])
    assert found.run_in.tolist() == [True, False]
    assert found.speed == pytest.approx([0.4, 0.3])
    assert found.peak.tolist() == [200e3, 150e3]
    assert found.peak_time.tolist() == [4.0, 6.0]


def test_the_closing_speed_is_the_stroke_rate_where_the_force_leaves_zero() -> None:
    check(contacts(TIME, FORCE, RATE))


@pytest.mark.parametrize("cut", range(9))
def test_pieces_give_what_the_whole_gives(cut: int) -> None:
    finder = ContactFinder(2)
    finder.add(TIME[:cut], FORCE[:cut], RATE[:cut])
    finder.add(TIME[cut:], FORCE[cut:], RATE[cut:])

    check(finder.contacts())


def test_one_sample_at_a_time_gives_what_the_whole_gives() -> None:
    finder = ContactFinder(2)
    for i in range(8):
        finder.add(TIME[i : i + 1], FORCE[i : i + 1], RATE[i : i + 1])

    check(finder.contacts())


def test_a_lower_floor_tells_of_light_contacts_too() -> None:
    found = contacts(TIME, FORCE, RATE, least_force=40e3)

    assert found.coupler.tolist() == [1, 0, 0]
    assert (found.time[0], found.speed[0], found.peak[0]) == (0.0, 0.1, 40e3)


def test_without_samples_there_are_none() -> None:
    found = contacts(np.empty(0), np.empty((0, 3)), np.empty((0, 3)))

    assert len(found.coupler) == len(found.time) == 0
