"""The kernel interpreted, without the compiler: the same bits, so that what is measured of it there holds."""

from __future__ import annotations

import hashlib
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from haul_ros.model.draft_gear import DraftGear, SideCurves
from haul_ros.model.track import Track
from haul_ros.physics.energy import energy_balance
from haul_ros.physics.kernel._jit import is_cached
from haul_ros.physics.kernel.advance import advance
from haul_ros.physics.kernel.data import PARTS
from haul_ros.physics.train_model import TrainModel, WaveKind
from tests.physics.physics_cases import WAGON_RESISTANCE, brake_system, linear, linear_gear, model, train_of, vehicle
from tests.waiting import WAIT

PRELOADED = SideCurves(linear(2e7, preload=60e3), linear(5e6, preload=15e3))
GEARS = (
    DraftGear("everything", PRELOADED, SideCurves(linear(3e7), linear(9e6)), 0.05, 0.01, 0.02, 1e8, 2.5e8),
    None,
    linear_gear(3e7, 9e6),
    None,
)
TRACK = Track(50.0, ((-1e3, 0.004), (45.0, -0.002)), ((20.0, 1 / 400.0), (70.0, 0.0)))


def _train() -> TrainModel:
    """A locomotive and four wagons: a preloaded gear with slack and stop, drawbars, a line."""
    wagon = vehicle(resistance=WAGON_RESISTANCE)
    vehicles = [vehicle(mass=184e3, tractive_effort=600e3, resistance=WAGON_RESISTANCE), *[wagon] * 4]
    brakes = brake_system(knee=0.4, knee_time=0.3, full_time=1.0, service_time=1.0, release_time=0.5)
    return TrainModel(train_of(vehicles, GEARS), brakes, TRACK, initial_speed=[3.0, 4.2, 3.0], time_step=2e-3)


def _digest(train: TrainModel) -> str:
    sample, extremes = train.sample(), train.extremes()
    arrays = [array for name in sample.__slots__[2:] if (array := getattr(sample, name)) is not None]
    arrays += [getattr(extremes, name) for name in extremes.__slots__]
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()


def digests() -> list[str]:
    """What comes of service, release, traction, emergency, a stop, and of steps that cannot converge."""
    train = _train()
    found = []
    train.start_wave(0.0, 0, WaveKind.SERVICE, 0.5)
    train.advance(150)
    train.start_wave(0.3, 0, WaveKind.RELEASE, 0.1)
    train.advance(100)
    train.set_traction(0, 300e3)
    train.advance(100)
    found.append(_digest(train))
    train.start_wave(0.7, 4, WaveKind.EMERGENCY)
    while not train.at_standstill:
        train.advance(50)
    found.append(_digest(train))
    train.start_wave(train.time, 4, WaveKind.EMERGENCY_RELEASE)
    train.advance(400)
    train.set_traction(0, 100e3)
    train.set_traction(0, 500e3)
    train.advance(50)
    assert not train.at_standstill
    found.append(_digest(train))
    hopeless = _train()
    hopeless.set_traction(0, math.nan)
    hopeless.advance(1)
    assert hopeless.statistics().unconverged_steps == PARTS
    return found


@pytest.mark.no_cover
def test_the_interpreted_kernel_gives_the_bits_of_the_compiled_one() -> None:
    code = "from tests.physics.test_interpreted import digests; print(*digests())"
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    interpreted = subprocess.run(
        [sys.executable, "-c", code],
        env=environment,
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        timeout=WAIT,
        check=True,
    )
    assert interpreted.stdout.split() == digests()
    assert len(set(digests())) == 3


@pytest.mark.interpreted
def test_the_train_of_this_comparison_does_what_it_is_there_for() -> None:
    train = _train()
    train.advance(200)
    extremes = train.extremes()
    assert np.isfinite(extremes.bottomed_time[0])  # the stop is met
    assert extremes.compression[1] > 0.0 < extremes.compression[3]  # both drawbars bear something
    assert energy_balance(train).gravity_work != 0.0


@pytest.mark.interpreted
def test_there_is_nothing_to_wait_for_once_the_kernel_has_run() -> None:
    model(train_of([vehicle()] * 2, linear_gear()), 1.0).advance(1)
    assert is_cached(advance)
