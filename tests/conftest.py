"""What tests of several folders share."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from hypothesis import settings

from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.brake_system import BrakeSystem, BuildUp, WaveSpeeds
from haul_ros.model.consist import Consist, Locomotive
from haul_ros.model.radio import RadioLink
from haul_ros.model.sample import CouplerExtremes, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.model.track import Track
from haul_ros.model.vehicle import RunningResistance, ShoeFriction, VehicleType

# CI tries the same examples every time; elsewhere each run looks at new ones.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")

DOCUMENT = "name: short train\ndescription: 'größer als nichts'\n"

SHORT_TRAIN = """\
description: short train, emergency from 20 km/h
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 20}
  - {vehicle: SS4, role: slave}
coupler: paper_set_b
brakes: paper_set_b
initial_speed_kmh: 20
max_duration_s: 60
radio: {default: {delay_s: 1.0}}
commands:
  - {at_s: 0.5, locomotive: master, emergency: true}
"""


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What takes long comes first, so that processes which share the tests out end at the same time.

    They do so by file, for tests of one share what they have simulated; live nodes share nothing.
    Lines are measured in quick tests, and in those of the others that reach more.
    """
    files_with_slow_ones = set()
    for number, item in enumerate(items):
        live = "start_node" in getattr(item, "fixturenames", ())
        if live:
            item.add_marker("slow")
        if item.get_closest_marker("slow"):
            files_with_slow_ones.add(item.path)
            if not item.get_closest_marker("measured"):
                item.add_marker("no_cover")
        item.add_marker(pytest.mark.xdist_group(f"live {number}" if live else item.path.name))
    if "PYTEST_XDIST_WORKER" in os.environ:
        items.sort(key=lambda item: ("start_node" not in getattr(item, "fixturenames", ()),
                                     item.path not in files_with_slow_ones))  # fmt: skip


@pytest.fixture(scope="session", autouse=True)
def _signals_that_end() -> Iterator[None]:
    """They end processes of tests, even where a shell ignores them: behind nohup, or in its background."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGHUP)}
    if before[signal.SIGINT] is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if before[signal.SIGHUP] is signal.SIG_IGN:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture(autouse=True)
def _processes_of_untraced_tests(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tracing is slow before Python 3.12: where a test does without it, the processes that it starts do too."""
    if request.node.get_closest_marker("no_cover"):
        for name in ("COVERAGE_PROCESS_START", "COVERAGE_PROCESS_CONFIG"):
            monkeypatch.delenv(name, raising=False)


@pytest.fixture(scope="session")
def short_train() -> str:
    """A scenario of 22 vehicles that stop within seconds."""
    return SHORT_TRAIN


@pytest.fixture
def consist() -> Consist:
    """Locomotive, three wagons, locomotive."""
    resistance = RunningResistance(constant=1e-3, linear=1e-4, quadratic=1e-5, starting=5e-3)
    friction = ShoeFriction(0.4, 100.0, 5.0, 3.6, 100.0, 14.4, 100.0)
    locomotive = VehicleType("SS4", 184e3, 32.8, resistance, 32, 20e3, friction, 450e3, 700e3)
    wagon = VehicleType("C80", 100e3, 12.0, resistance, 16, 20e3, friction, 420e3)
    return Consist(
        vehicles=(locomotive, wagon, wagon, wagon, locomotive),
        couplers=(None, None, None, None),
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
        couplers, vehicles = len(consist.couplers), len(consist.vehicles)
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
