"""Stops of a train whose speeds are straight lines."""

import numpy as np
import pytest

from haul_ros.analysis.motion import MotionRecorder, applications, stop

# Two vehicles at 20 m/s; from 10 s on the first slows down by 1 m/s^2 and stands at 30 s, the second by 2 m/s^2 from
# 20 s on and stands at 30 s too. Sampled every half second, the way of the first summed up exactly.
TIME = np.arange(0.0, 40.5, 0.5)
HEAD = np.clip(20.0 - (TIME - 10.0), 0.0, 20.0)
TAIL = np.clip(20.0 - 2.0 * (TIME - 20.0), 0.0, 20.0)
HEAD_CHAINAGE = 100.0 + np.concatenate(([0.0], np.cumsum(0.25 * (HEAD[1:] + HEAD[:-1]))))


def _recorder() -> MotionRecorder:
    recorder = MotionRecorder()
    speed = np.column_stack((HEAD, TAIL))
    chainage = np.column_stack((HEAD_CHAINAGE, HEAD_CHAINAGE - 30.0))
    for rows in (slice(0, 33), slice(33, None)):
        recorder.add(TIME[rows], chainage[rows], speed[rows])
    return recorder


def test_a_stop_by_hand() -> None:
    motion = _recorder().motion()
    found = stop(motion, 9.75, 40.0, 0.6)  # begun between two samples

    assert motion.standing_since == 30.0
    assert motion.distance == pytest.approx(20.0 * 10.0 + 200.0)
    assert found.initial_speed == 20.0
    assert found.stopping_time == 20.25
    # 0.25 s at 20 m/s, then 20^2/2 m
    assert found.stopping_distance == pytest.approx(205.0)
    assert found.mean_deceleration == pytest.approx(400.0 / 410.0)
    # From 20 s on both slow down: the mean of 1 and 2 m/s^2
    assert found.largest_deceleration == pytest.approx(1.5)
    assert found.final_speed == 0.0


def test_a_brake_released_before_the_train_stands_has_no_stop() -> None:
    found = stop(_recorder().motion(), 10.0, 15.0, 0.6)

    assert (found.stopping_time, found.stopping_distance, found.mean_deceleration) == (None, None, None)
    assert found.final_speed == 15.0
    assert found.largest_deceleration == pytest.approx(0.5)  # the mean of 1 and 0


def test_applications_last_while_the_demand_is_above_zero() -> None:
    time, demand = np.array([0.0, 5.0, 9.0, 20.0, 30.0]), np.array([0.0, 0.3, 0.5, 0.0, 1.0])

    assert applications(time, demand, 44.0) == [(5.0, 20.0, 0.5), (30.0, 44.0, 1.0)]
    assert applications(time[:1], demand[:1], 44.0) == []


def test_a_train_that_moves_at_the_end_does_not_stand() -> None:
    recorder = MotionRecorder()
    recorder.add(np.array([0.0, 1.0]), np.zeros((2, 1)), np.array([[0.0], [1.0]]))

    assert recorder.motion().standing_since is None
    assert MotionRecorder().motion().standing_since is None
