"""Peaks in samples, read off by eye."""

import numpy as np

from haul_ros.analysis.peaks import PeakFinder, sampled_peaks

TIME = np.array([0.0, 0.5, 1.0, 1.5])
# The first coupler: 300 kN of buff at 0.5 s, 100 kN of draft at 1.5 s; the second: draft alone, 50 kN twice
FORCE = np.array([[0.0, -20e3], [300e3, -50e3], [200e3, -50e3], [-100e3, -10e3]])
STROKE = np.array([[0.0, -0.001], [0.010, -0.002], [0.012, -0.003], [-0.004, -0.001]])


def test_peaks_are_the_largest_of_each_side_with_the_first_time_of_equals() -> None:
    peaks = sampled_peaks(TIME, FORCE, STROKE)

    assert peaks.compression.tolist() == [300e3, 0.0]
    assert peaks.compression_time[0] == 0.5
    assert np.isnan(peaks.compression_time[1])  # it never bore any
    assert peaks.tension.tolist() == [100e3, 50e3]
    assert peaks.tension_time.tolist() == [1.5, 0.5]
    assert peaks.compression_stroke.tolist() == [0.012, 0.0]
    assert peaks.compression_stroke_time[0] == 1.0  # not when the force was largest
    assert peaks.tension_stroke.tolist() == [0.004, 0.003]
    assert peaks.tension_stroke_time.tolist() == [1.5, 1.0]
    assert peaks.force.tolist() == [300e3, 50e3]


def test_pieces_give_what_the_whole_gives() -> None:
    finder = PeakFinder(2)
    for rows in (slice(0, 1), slice(1, 1), slice(1, 3), slice(3, 4)):
        finder.add(TIME[rows], FORCE[rows], STROKE[rows])

    np.testing.assert_array_equal(finder.peaks().compression_time, sampled_peaks(TIME, FORCE, STROKE).compression_time)
    np.testing.assert_array_equal(finder.peaks().tension_time, [1.5, 0.5])
