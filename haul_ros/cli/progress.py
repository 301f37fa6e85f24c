"""The progress bar of a run."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm

from haul_ros.model.sample import Sample
from haul_ros.model.scenario import Scenario
from haul_ros.simulation.batch import share_done
from haul_ros.units import NS_PER_S, mps_to_kmh


class Progress:
    """Shows how near the run is to its end, simulated time, speed of the train and of the simulation."""

    def __init__(self, bar: tqdm, scenario: Scenario) -> None:
        self._bar = bar
        self._scenario = scenario
        self._began: float | None = None

    def show(self, sample: Sample) -> None:
        """Show the state after a sample period."""
        if self._bar.disable:
            return
        if self._began is None:
            self._began = time.perf_counter()
        simulated = sample.time_ns / NS_PER_S
        pace = simulated / max(time.perf_counter() - self._began, 1e-9)
        speed = mps_to_kmh(float(sample.speed[0]))
        self._bar.set_description_str(f"{simulated:7.2f} s  {speed:5.1f} km/h  {pace:4.0f} x real time", refresh=False)
        # A train may gather speed again: the bar does not run backwards
        self._bar.update(max(0.0, share_done(self._scenario, sample) - self._bar.n))


@contextmanager
def reading_progress() -> Iterator[Callable[[int, int], None]]:
    """A bar on stderr, if that is a terminal, of how many samples of how many have been read; gone at the end."""
    hidden = not sys.stderr.isatty()
    form = "{desc}  {percentage:3.0f} %|{bar}| {elapsed}, {remaining} left"
    with tqdm(desc="reading", total=1.0, bar_format=form, leave=False, disable=hidden, file=sys.stderr) as bar:
        yield lambda done, of: bar.update(max(0.0, min(1.0, done / max(of, 1)) - bar.n))


@contextmanager
def progress(scenario: Scenario, *, quiet: bool) -> Iterator[Progress]:
    """A progress bar on stderr, if that is a terminal, gone at the end."""
    hidden = quiet or not sys.stderr.isatty()
    form = "{desc}  {percentage:3.0f} %|{bar}|"
    with tqdm(desc="preparing", total=1.0, bar_format=form, leave=False, disable=hidden, file=sys.stderr) as bar:
        yield Progress(bar, scenario)
