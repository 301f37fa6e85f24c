"""One case of a study: which scenario with which changes, and what its run gave."""

from __future__ import annotations

import hashlib
import io
import math
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from haul_ros.analysis.envelopes import largest_force
from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.sample import CouplerExtremes, FloatArray
from haul_ros.model.scenario import Scenario
from haul_ros.scenario import load_scenario
from haul_ros.simulation.session import Session
from haul_ros.studies.sources import results_digest
from haul_ros.version import __version__

_SOURCES = results_digest()
"""Of the sources as they were when this process loaded them."""
MOST_BYTES = 1024 * 1024
"""Longest result, decompressed too: that of a train of 2000 vehicles takes 150 kB."""
_NOT_A_RESULT = (
    zipfile.BadZipFile, zlib.error, KeyError, TypeError, AttributeError, EOFError, MemoryError, RuntimeError
)  # fmt: skip
"""What numpy and zipfile raise on other bytes, besides ValueError."""
_CHECK_EVERY = 1.0
"""Simulation time [s] between two checks whether the train stands: extremes are kept by every time step anyway."""
_HARDEST_STOP = 2.0
"""Deceleration [m/s^2] that trains do not reach: checks before a stop is possible would only cost time."""


@dataclass(frozen=True, slots=True)
class Case:
    """A run to be made.

    ``name`` is for people. ``overrides`` are those of `load_scenario`; ``values`` is what tells this
    case from the others of its study, by column name.
    """

    name: str
    scenario: str
    overrides: Mapping[str, object]
    values: Mapping[str, object]

    @property
    def scenario_name(self) -> str:
        """The name of a shipped scenario, or of a file without its ending."""
        return Path(self.scenario).stem

    def load(self) -> Scenario:
        """The scenario of this case.

        Raises
        ------
        ScenarioError
            As for `load_scenario`.
        """
        return load_scenario(self.scenario, self.overrides)


@dataclass(frozen=True, slots=True, eq=False)
class CaseResult:
    """What a run gave, in SI units.

    ``geared`` (n_couplers,) is false for rigid drawbars; ``locomotives`` are vehicle indices;
    ``stop_time`` [s] is NaN if the train did not stop; ``distance`` [m] is how far the head went;
    ``energy_fault`` is that of the energy balance, in words, empty if it holds. ``top_speed`` [m/s] is the largest of
    all states looked at, with a pneumatic brake the samples; ``released`` is how many vehicles have released their
    pneumatic brake, however often, that no locomotive had asked to, ``unbraked`` how many do not brake at the end
    though no locomotive charges the pipe.
    """

    extremes: CouplerExtremes
    geared: NDArray[np.bool_]
    locomotives: NDArray[np.int64]
    stop_time: float
    distance: float
    relative_imbalance: float
    unconverged_steps: int
    energy_fault: str = ""
    top_speed: float = 0.0
    released: int = 0
    unbraked: int = 0

    @property
    def force(self) -> FloatArray:
        """Envelope of the force's magnitude (n_couplers,) [N], rigid drawbars included."""
        return largest_force(self.extremes)

    @property
    def stroke(self) -> FloatArray:
        """Envelope of the stroke's magnitude (n_couplers,) [m]."""
        return np.maximum(self.extremes.compression_stroke, self.extremes.tension_stroke)

    @property
    def position(self) -> FloatArray:
        """Position of each coupler along the train (n_couplers,): j/N for the j-th of N vehicles."""
        n = len(self.geared) + 1
        return np.arange(1, n) / n

    @property
    def gear_force(self) -> float:
        """Largest force in a coupler with a draft gear [N]."""
        return float(self.force.max(where=self.geared, initial=0.0))

    @property
    def largest_stroke(self) -> float:
        """Largest stroke [m]."""
        return float(self.stroke.max())

    @property
    def complete(self) -> bool:
        """Every number is there but times of what did not happen: a stop, a gear that closed."""
        arrays = [value for name, value in asdict(self.extremes).items() if name != "bottomed_time"]
        numbers = [self.distance, self.relative_imbalance, self.top_speed]
        return all(np.isfinite(array).all() for array in [*arrays, *numbers])

    def check_form(self) -> None:
        """See that arrays are of numbers and fit each other; ValueError: they do not."""
        n = len(np.atleast_1d(self.geared))
        arrays = [(name, value, np.float64) for name, value in asdict(self.extremes).items()]
        for name, array, kind in [*arrays, ("geared", self.geared, np.bool_)]:
            if array.dtype != kind or array.shape != (n,):
                raise ValueError(f"not a result: {name} is of {array.dtype}, {array.shape}")
        locomotives = self.locomotives
        if (
            locomotives.dtype != np.int64
            or locomotives.ndim != 1
            or not ((locomotives >= 0) & (locomotives <= n)).all()
        ):
            raise ValueError("not a result: locomotives are no vehicles of the train")

    def to_bytes(self) -> bytes:
        """All numbers, in full."""
        numbers = {name: value for name, value in asdict(self).items() if name != "extremes"}
        buffer = io.BytesIO()
        np.savez(buffer, **numbers, **{f"extremes.{name}": value for name, value in asdict(self.extremes).items()})
        return buffer.getvalue()

    @classmethod
    def from_bytes(cls, data: bytes) -> CaseResult:
        """The result that `to_bytes` wrote.

        Raises
        ------
        ValueError
            It did not write this.
        """
        try:
            _check_size(data)
            with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
                named = {name: arrays[name] for name in arrays.files}
            extremes = {name.partition(".")[2]: value for name, value in named.items() if name.startswith("extremes.")}
            result = cls(
                extremes=CouplerExtremes(**extremes),
                geared=named["geared"],
                locomotives=named["locomotives"],
                stop_time=float(named["stop_time"]),
                distance=float(named["distance"]),
                relative_imbalance=float(named["relative_imbalance"]),
                unconverged_steps=int(named["unconverged_steps"]),
                energy_fault=str(named["energy_fault"]),
                top_speed=float(named["top_speed"]),
                released=int(named["released"]),
                unbraked=int(named["unbraked"]),
            )
            result.check_form()
            return result
        except _NOT_A_RESULT as error:
            raise ValueError(f"not a result: {error}") from error


def _check_size(data: bytes) -> None:
    """See that what is packed does not become larger than a result may be."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        size = sum(entry.file_size for entry in archive.infolist())
    if size > MOST_BYTES:
        raise ValueError(f"not a result: {size} bytes, expected at most {MOST_BYTES}")


Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Finished(Generic[Result]):
    """A case and what it gave: a `CaseResult` if it was simulated."""

    case: Case
    result: Result


def key(scenario: Scenario) -> str:
    """What a run depends on, as a digest: the complete scenario, the version of this package and its sources."""
    return hashlib.sha256(f"{__version__}\n{_SOURCES}\n{scenario.document}".encode()).hexdigest()


class Answer(NamedTuple):
    """A result, and the `key` of what it was made from as the process that made it knows it."""

    key: str
    result: CaseResult


class CaseStoppedError(Exception):
    """A run was given up before its end."""


def answer(scenario: Scenario, stop: Callable[[], bool] = lambda: False) -> Answer:
    """`simulate`, and say from which sources: those of another process may be others than one's own."""
    return Answer(key(scenario), simulate(scenario, stop))


def simulate(scenario: Scenario, stop: Callable[[], bool] = lambda: False) -> CaseResult:
    """Run a scenario with its own commands to its end; the GIL is released for a fraction of a second at a time.

    Raises
    ------
    CommandError
        A command of the scenario cannot be carried out at its time.
    CaseStoppedError
        ``stop`` has become true, a fraction of a second before.
    """
    session = Session(scenario, play_commands=True)
    speed = top_speed = scenario.initial_speed
    pneumatic = isinstance(scenario.brakes, PneumaticBrake)
    while not session.finished:
        if stop():
            raise CaseStoppedError
        if pneumatic:  # whose valves are to be looked at often
            ahead = session.steps_per_sample
        else:
            ahead = math.ceil(max(_CHECK_EVERY, speed / _HARDEST_STOP) / scenario.time_step)
        speed = float(session.advance(min(ahead, session.steps_left), stop=stop).speed.max())
        top_speed = max(speed, top_speed)
        session.take_log()
    stop_time, energy = session.stop_time, session.energy()
    return CaseResult(
        extremes=session.extremes(),
        geared=np.array([gear is not None for gear in scenario.consist.couplers], dtype=np.bool_),
        locomotives=np.array([locomotive.vehicle for locomotive in scenario.consist.locomotives], dtype=np.int64),
        stop_time=math.nan if stop_time is None else stop_time,
        distance=session.travelled,
        relative_imbalance=energy.relative_imbalance,
        unconverged_steps=session.status().solver.unconverged_steps,
        energy_fault=energy.fault or "",
        top_speed=top_speed,
        released=session.unintended_releases,
        unbraked=session.unbraked,
    )
