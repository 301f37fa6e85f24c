"""Sensors against the laws that they are to follow; every bound is passed by chance once in some 10 000 tries."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.sample import Sample
from haul_ros.model.scenario import Scenario
from haul_ros.model.sensor import CouplerMeasurement, Transducer
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.sensors import SensorBench, shown
from haul_ros.simulation.session import Session

CONFIDENT = 3.89
"""Standard deviations within which a normal variable is in 9999 of 10 000 cases."""
SENSORS = {"couplers": [1, 7, 21], "force": {"noise_kN": 2}, "stroke": {"noise_mm": 0.5}}

Floats = NDArray[np.float64]


def scenario_of(short_train: str, sensors: dict[str, Any], **overrides: Any) -> Scenario:
    values = {key.replace("__", "."): value for key, value in overrides.items()}
    return load_scenario_text(short_train, "short", {"sensors": sensors, **values})


def sample_at(step: int, force: float = 0.0, stroke: float = 0.0) -> Sample:
    couplers, vehicles = np.zeros(21), np.zeros(22)
    return Sample(
        step, step * 10**6, couplers + stroke, couplers, couplers + force, vehicles, vehicles, vehicles, vehicles
    )


def measured(scenario: Scenario, count: int, every: int = 20, force: float = 0.0) -> tuple[Floats, Floats]:
    """Force and stroke (count, k) of so many measurements in succession."""
    bench = SensorBench(scenario)
    found = [bench.measure(sample_at(n * every, force)) for n in range(count)]
    forces, strokes = zip(*((m.force, m.stroke) for m in found if m is not None), strict=True)
    return np.array(forces), np.array(strokes)


def test_the_noise_is_normal_and_white(short_train: str) -> None:
    """Mean, variance, skewness and kurtosis of a normal sample of size n have standard errors sigma/sqrt(n),
    sigma^2 sqrt(2/n), sqrt(6/n) and sqrt(24/n); a correlation of independent ones has 1/sqrt(n)."""
    force, stroke = measured(scenario_of(short_train, SENSORS), 4000)
    for values, sigma in ((force, 2e3), (stroke, 0.5e-3)):
        x, n = values / sigma, values.size
        assert abs(x.mean()) < CONFIDENT / math.sqrt(n)
        assert abs(x.var() - 1.0) < CONFIDENT * math.sqrt(2.0 / n)
        assert abs((x**3).mean()) < CONFIDENT * math.sqrt(15.0 / n)
        assert abs((x**4).mean() - 3.0) < CONFIDENT * math.sqrt(96.0 / n)
        for limit, share in ((1.0, 0.682689), (2.0, 0.954500), (3.0, 0.997300)):
            inside = (np.abs(x) < limit).mean()
            assert abs(inside - share) < CONFIDENT * math.sqrt(share * (1.0 - share) / n)
    n = len(force)
    for one, other in (
        (force[:, 0], force[:, 1]),
        (force[:, 0], force[:, 2]),
        (force[:, 0], stroke[:, 0]),
        (force[:-1, 1], force[1:, 1]),
        (force[:-1, 1], stroke[1:, 1]),
    ):
        assert abs(np.corrcoef(one, other)[0, 1]) < CONFIDENT / math.sqrt(n - 1)


def test_steps_add_a_twelfth_of_their_square_to_the_variance(short_train: str) -> None:
    """Sheppard's correction, for a step of one standard deviation exact to 1e-8 (Widrow's quantisation theorem)."""
    sensors = {"couplers": [3], "force": {"noise_kN": 2, "quantisation_kN": 2}, "stroke": {}}
    force, stroke = measured(scenario_of(short_train, sensors), 20_000, force=700.0)
    variance = 4e6 * (1.0 + 1.0 / 12.0)
    assert abs(force.var() / variance - 1.0) < CONFIDENT * math.sqrt(2.0 / force.size)
    assert abs(force.mean() - 700.0) < CONFIDENT * math.sqrt(variance / force.size)
    assert (force % 2000.0 == 0.0).all()
    assert (stroke == 0.0).all()


@pytest.mark.parametrize(
    ("transducer", "truth", "expected"),
    [
        (Transducer(), [1.25, -0.1], [1.25, -0.1]),
        (Transducer(quantisation=500.0), [749.9, 750.1, -250.0, -750.0, 1e6 + 1.0], [500.0, 1000.0, 0.0, -1000.0, 1e6]),
        (Transducer(span=100.0), [99.0, 101.0, -1e9], [99.0, 100.0, -100.0]),
        (Transducer(quantisation=30.0, span=100.0), [80.0, 99.0, -200.0], [90.0, 90.0, -90.0]),  # no step beyond
        (Transducer(quantisation=0.1, span=0.3), [0.26, 0.5], [3 * 0.1, 3 * 0.1]),  # 0.3 / 0.1 < 3 in doubles
        (Transducer(noise=2.0), [10.0], [13.0]),
        (Transducer(noise=2.0, quantisation=4.0, span=11.0), [10.0], [8.0]),  # noise, then steps, then the range
    ],
)
def test_a_transducer_shows_exactly(transducer: Transducer, truth: list[float], expected: list[float]) -> None:
    found = shown(transducer, np.array(truth), np.full(len(truth), 1.5))
    assert found.tolist() == expected
    assert not np.signbit(found[found == 0.0]).any()


def one_noise(scenario: Scenario, step: int) -> CouplerMeasurement:
    found = SensorBench(scenario).measure(sample_at(step))
    assert found is not None
    assert found.stroke is not None
    return found


def test_the_noise_depends_on_seed_coupler_and_number_and_on_nothing_else(short_train: str) -> None:
    base = one_noise(scenario_of(short_train, SENSORS | {"rate_hz": 10}), 1000)
    others = SENSORS | {"couplers": [12, 7, 3], "rate_hz": 10}
    found = one_noise(scenario_of(short_train, others), 1000)
    assert (found.force[1], found.stroke[1]) == (base.force[1], base.stroke[1])  # type: ignore[index]
    assert found.force[0] not in base.force
    published = one_noise(scenario_of(short_train, SENSORS | {"rate_hz": 10}, sample_rate_hz=100), 1000)
    assert published.force.tolist() == base.force.tolist()  # number 10 at 1 s, however many samples lie between
    assert one_noise(scenario_of(short_train, SENSORS | {"rate_hz": 10}), 1100).force[0] != base.force[0]
    unmeasured = SENSORS | {"rate_hz": 10, "stroke": {"noise_mm": 0}}
    assert one_noise(scenario_of(short_train, unmeasured), 1000).force.tolist() == base.force.tolist()
    for seeded in (
        scenario_of(short_train, SENSORS | {"rate_hz": 10, "seed": 1}),
        scenario_of(short_train, SENSORS | {"rate_hz": 10}, radio__seed=1),
    ):
        assert one_noise(seeded, 1000).force.tolist() != base.force.tolist()
    own = scenario_of(short_train, SENSORS | {"rate_hz": 10, "seed": 0}, radio__seed=1)
    assert one_noise(own, 1000).force.tolist() == base.force.tolist()


def test_what_else_is_drawn_changes_no_measurement_and_measuring_changes_no_run(short_train: str) -> None:
    """A lossy radio draws its own numbers; a train that rolls freely meanwhile is the same train."""
    free = {"commands": [], "initial_speed_kmh": 0}
    quiet = Session(scenario_of(short_train, SENSORS, **free))
    noisy = Session(scenario_of(short_train, SENSORS, **free, radio__default__loss_probability=1.0))
    for _ in range(5):
        noisy.request(Command("slave_1", CommandKind.BRAKE, 0.5))
        for session in (quiet, noisy):
            session.advance()
        one, other = quiet.take_log().measurement, noisy.take_log().measurement
        assert one is not None
        assert other is not None
        assert one.force.tolist() == other.force.tolist()
    plain = Session(load_scenario_text(short_train, "short"), play_commands=True)
    with_sensors = Session(scenario_of(short_train, SENSORS), play_commands=True)
    for session in (plain, with_sensors):
        session.advance(4000)
    assert plain.take_log().measurement is None
    assert plain.sample().coupler_force.tobytes() == with_sensors.sample().coupler_force.tobytes()


def test_a_session_measures_at_the_rate_of_its_sensors_the_couplers_chosen(short_train: str) -> None:
    sensors = {"couplers": [21, 2], "rate_hz": 10, "stroke": {}}
    session = Session(scenario_of(short_train, sensors), play_commands=True)
    times = []
    for _ in range(100):
        log = session.take_log()
        assert log.sample is not None
        if (found := log.measurement) is not None:
            times.append(found.time_ns)
            assert found.time_ns == log.time_ns
            assert found.force.tolist() == log.sample.coupler_force[[20, 1]].tolist()  # without noise the truth
            assert found.stroke is not None
            assert found.stroke.tolist() == log.sample.stroke[[20, 1]].tolist()
        session.advance()
    assert times == [n * 100_000_000 for n in range(20)]
    session.advance(7)  # a sample between two: none is measured there
    assert session.take_log().measurement is None
