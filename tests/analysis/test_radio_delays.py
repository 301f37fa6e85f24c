"""Delays between what two locomotives applied, read off."""

import numpy as np

from haul_ros.analysis.radio_delays import RadioDelay, radio_delays


def _series(*changes: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    times, values = zip(*changes, strict=True)
    return np.array(times), np.array(values)


def test_each_change_of_the_master_is_answered_by_the_slaves_first_change_to_it() -> None:
    master = _series((0.0, 0.0), (1.0, 0.5), (20.0, 0.0), (40.0, 0.5), (60.0, 1.0))
    slave = _series((0.0, 0.0), (2.25, 0.5), (23.0, 0.0), (61.0, 1.0))  # the telegram of 40 s was lost

    assert radio_delays("slave_1", master, slave) == [
        RadioDelay("slave_1", 1.0, 0.5, 1.25),
        RadioDelay("slave_1", 20.0, 0.0, 3.0),
        RadioDelay("slave_1", 40.0, 0.5, None),
        RadioDelay("slave_1", 60.0, 1.0, 1.0),
    ]


def test_a_late_answer_is_not_that_to_the_same_demand_made_anew() -> None:
    master = _series((0.0, 0.0), (1.0, 0.5), (10.0, 0.0), (20.0, 0.5))
    slave = _series((0.0, 0.0), (21.0, 0.5))

    assert [(found.time, found.delay) for found in radio_delays("slave_1", master, slave)] == [
        (1.0, None),
        (20.0, 1.0),
    ]


def test_what_the_slave_applied_already_needs_no_answer() -> None:
    master, slave = _series((0.0, 0.0), (5.0, 1.0)), _series((0.0, 0.0), (3.0, 1.0))

    assert radio_delays("slave_1", master, slave) == []
