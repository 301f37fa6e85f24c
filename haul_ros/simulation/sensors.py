"""Measurements of instrumented couplers: the truth with noise, steps and limits of the sensors."""

from __future__ import annotations

import math

import numpy as np

from haul_ros.model.sample import FloatArray, Sample
from haul_ros.model.scenario import Scenario
from haul_ros.model.sensor import CouplerMeasurement, Transducer

_PURPOSE = 1_000_000
"""Keeps these numbers apart from the radio's, whose generators have the number of a slave here."""
_STEP_ROUNDING = 1e-9


class SensorBench:
    """The sensors of a scenario; without any it measures nothing.

    What a sensor shows depends on nothing but the truth, the seed, the coupler and the number of the measurement, which
    counts those from the start of the run at the sensors' rate: not on what other couplers are measured, how often
    samples are published, or what else is drawn.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._sensors = scenario.sensors
        if self._sensors is not None:
            self._steps = scenario.steps_per_sample * self._sensors.every
            self._couplers = np.array(self._sensors.couplers)

    def measure(self, sample: Sample) -> CouplerMeasurement | None:
        """What the sensors make of a sample; None if none is due at its time."""
        if self._sensors is None or sample.step % self._steps:
            return None
        noise = self._noise(self._sensors.seed, sample.step // self._steps)
        force, stroke = self._sensors.force, self._sensors.stroke
        return CouplerMeasurement(
            sample.time_ns,
            shown(force, sample.coupler_force[self._couplers], noise[:, 0]),
            None if stroke is None else shown(stroke, sample.stroke[self._couplers], noise[:, 1]),
        )

    def _noise(self, seed: int, number: int) -> FloatArray:
        """Standard normal numbers of force and stroke at each coupler (k, 2)."""
        # All couplers up to the last one measured have theirs drawn, in order, so that which are measured is no matter
        generator = np.random.default_rng([seed, _PURPOSE, number])
        every: FloatArray = generator.standard_normal((int(self._couplers.max()) + 1, 2))
        chosen: FloatArray = every[self._couplers]
        return chosen


def shown(transducer: Transducer, truth: FloatArray, noise: FloatArray) -> FloatArray:
    """What a transducer shows of true values with standard normal noise."""
    values, step, span = truth + transducer.noise * noise, transducer.quantisation, transducer.span
    if step == 0.0:
        return np.clip(values, -span, span)
    most = math.floor(span / step * (1.0 + _STEP_ROUNDING)) if span < math.inf else math.inf
    return np.clip(np.rint(values / step), -most, most) * step + 0.0
