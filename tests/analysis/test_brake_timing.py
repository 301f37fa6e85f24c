"""Filling of cylinders that rise in straight lines."""

import numpy as np
import pytest

from haul_ros.analysis.brake_timing import FillingRecorder, filling

TIME = np.arange(0.0, 31.0)
# Applied at 2.5 s: the first cylinder rises from 3 s on by 40 kPa a second to 400 kPa at 13 s, the second from 5 s on
# by 20 kPa a second to 300 kPa at 20 s, the third not at all.
PRESSURE = np.column_stack(
    (np.clip(40e3 * (TIME - 3.0), 0.0, 400e3), np.clip(20e3 * (TIME - 5.0), 0.0, 300e3), np.full(31, 9e3))
)


def test_a_filling_by_hand() -> None:
    found = filling(TIME, PRESSURE, 2.5)

    assert found.pressure.tolist() == [400e3, 300e3, 9e3]
    # 40 kPa at 4 s, 360 kPa at 12 s; 30 kPa at 6.5 s, 270 kPa at 18.5 s
    assert found.times[:, :2] == pytest.approx(np.array([[1.5, 4.0], [9.5, 16.0]]))
    assert np.isnan(found.times[:, 2]).all()


@pytest.mark.parametrize("size", [1, 3, 7, 31])
def test_pieces_give_the_fillings_of_the_whole_one_after_another(size: int) -> None:
    time = np.arange(62.0)
    pressure = np.concatenate((PRESSURE, PRESSURE))
    recorder = FillingRecorder([(2.5, 28.0), (33.5, 61.0), (70.0, 80.0)])
    for start in range(0, 62, size):
        recorder.add(time[start : start + size], pressure[start : start + size])

    first, second = recorder.fillings()
    for found, begin in ((first, 2.5), (second, 33.5)):
        assert found.begin == begin
        assert found.pressure[:2].tolist() == [400e3, 300e3]
        assert found.times[:, :2] == pytest.approx(np.array([[1.5, 4.0], [9.5, 16.0]]))
