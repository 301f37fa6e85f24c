"""A small train, its scenario and samples, shared by the tests of recordings."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from haul_ros.model.brake_system import BrakeSystem, BuildUp, WaveSpeeds
from haul_ros.model.consist import Consist, Locomotive
from haul_ros.model.radio import RadioLink
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.model.track import Track
from haul_ros.model.vehicle import RunningResistance, ShoeFriction, VehicleType
from haul_ros.recording import run_file
from haul_ros.recording.telemetry import TelemetryEncoder

DOCUMENT = "name: short train\ndescription: 'größer als nichts'\n"


@pytest.fixture
def consist() -> Consist:
    """Locomotive, three wagons, locomotive."""
    resistance = RunningResistance(constant=1e-3, linear=1e-4, quadratic=1e-5, starting=5e-3)
    friction = ShoeFriction(0.4, 100.0, 5.0, 3.6, 100.0, 14.4, 100.0)
    locomotive = VehicleType("SS4", 184e3, 32.8, resistance, 32, 20e3, friction, 450e3, 700e3)
    wagon = VehicleType("C80", 100e3, 12.0, resistance, 16, 20e3, friction, 420e3)
    return Consist(
        vehicles=(locomotive, wagon, wagon, wagon, locomotive),
        joints=(None, None, None, None),
        locomotives=(Locomotive("master", 0), Locomotive("slave_1", 4)),
    )


@pytest.fixture
def scenario(consist: Consist) -> Scenario:
    return Scenario(
        name="short_train",
        description="Two locomotives and three wagons",
        consist=consist,
        brakes=BrakeSystem(WaveSpeeds(250.0, 200.0, 150.0), BuildUp(1.0, 10.0, 10.0, 15.0, 40.0, False), 0.8),
        track=Track(),
        radio={"slave_1": RadioLink(delay=2.0)},
        radio_seed=1,
        initial_speed=20.0,
        commands=(),
        time_step=0.001,
        sample_rate=50.0,
        max_duration=100.0,
        document=DOCUMENT,
    )


@pytest.fixture
def encoder(consist: Consist) -> TelemetryEncoder:
    return TelemetryEncoder(consist)


@pytest.fixture
def make_sample(consist: Consist) -> Callable[[int], Sample]:
    """The sample at a step of 20 ms, with numbers that occur only once."""

    def make(step: int) -> Sample:
        random = np.random.default_rng(step)
        couplers, vehicles = len(consist.joints), len(consist.vehicles)
        return Sample(
            step,
            step * 20_000_000,
            *(random.normal(size=couplers) for _ in range(3)),
            *(random.normal(size=vehicles) for _ in range(4)),
        )

    return make


@pytest.fixture
def extremes() -> CouplerExtremes:
    """Four couplers; the last was never in tension and never closed."""
    return CouplerExtremes(
        compression=np.array([4e5, 3e5, 2e5, 1e5]),
        compression_time=np.array([4.0, 3.0, 2.0, 1.0]),
        tension=np.array([3e4, 2e4, 1e4, 0.0]),
        tension_time=np.array([8.0, 7.0, 6.0, 0.0]),
        compression_stroke=np.array([0.04, 0.03, 0.02, 0.01]),
        tension_stroke=np.array([0.003, 0.002, 0.001, 0.0]),
        bottomed_time=np.full(4, np.nan),
    )


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks that the few messages of a test fill several of."""
    monkeypatch.setattr(run_file, "CHUNK_SIZE", 100_000)


@pytest.fixture
def wait_until() -> Callable[[Callable[[], bool]], None]:
    """Wait for a condition that another thread brings about."""

    def wait(condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + 30.0
        while not condition():
            assert time.monotonic() < deadline, "condition not reached"
            time.sleep(0.001)

    return wait


@pytest.fixture
def limited_file_size() -> Iterator[None]:
    """Writing a file beyond 100 kB fails, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
