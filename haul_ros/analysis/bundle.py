"""All results of a recording, as files in one folder."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from math import ceil
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from numpy.typing import NDArray

from haul_ros.analysis.brake_plots import BrakeHistory
from haul_ros.analysis.coupler_series import CouplerRecorder
from haul_ros.analysis.history import HistoryBuilder
from haul_ros.analysis.limits import STRENGTH_LIMIT
from haul_ros.analysis.number_tables import arrays_of, number_tables
from haul_ros.analysis.numbers import Numbers, Window, numbers_of, series_within
from haul_ros.analysis.pictures import PictureFormat
from haul_ros.analysis.plots import HISTORY_COLUMNS, BrakeEvent, brake_events, history_figure, profile_figure
from haul_ros.analysis.scenarios import scenario_of
from haul_ros.analysis.summary import Journey, RunSummary, summarize_journey
from haul_ros.analysis.tables import Table, write_arrays, write_table
from haul_ros.analysis.train_layout import TrainLayout
from haul_ros.errors import HaulError
from haul_ros.model.scenario import Scenario
from haul_ros.recording.series import Samples
from haul_ros.recording.train_source import TrainSource
from haul_ros.recording.trains import open_train
from haul_ros.simulation.overspeed import OverspeedWatch
from haul_ros.units import NS_PER_S


class AnalysisError(HaulError):
    """Results of an analysis that cannot be written."""


@dataclass(frozen=True, slots=True)
class AnalysisOptions:
    """What of a recording is analysed: a ``window`` of the train of ``node``, and of its ``run`` where the node was
    reset (None: the only one). ``couplers`` by number (1 is behind the first vehicle; None: all) are those in tables,
    with their series of samples; ``limit`` [N] is the force above which time is counted."""

    window: Window = field(default_factory=Window)
    couplers: tuple[int, ...] | None = None
    node: str | None = None
    run: int | None = None
    limit: float = STRENGTH_LIMIT
    pictures: PictureFormat = field(default_factory=PictureFormat)


@dataclass(frozen=True, slots=True, eq=False)
class Analysis:
    """What was found, and the files written. ``summary`` is that of the whole run as `haul_ros.analysis.summary` has
    it, None without scenario or of a part of the time; ``title`` says what was analysed."""

    title: str
    layout: TrainLayout
    numbers: Numbers
    summary: RunSummary | None
    files: tuple[Path, ...]


def default_folder(recording: Path) -> Path:
    """``<name of the file>_analysis`` in the current folder."""
    return Path(f"{recording.resolve().stem}_analysis")


def analyze(
    path: Path,
    folder: Path,
    options: AnalysisOptions | None = None,
    show: Callable[[int, int], None] = lambda _done, _of: None,
) -> Analysis:
    """Analyse a recording of any kind into a folder, made if missing; results of an earlier analysis are replaced.

    Writes the tables of `haul_ros.analysis.number_tables` as CSV, and Parquet if pyarrow is installed, all of them as
    ``numbers.npz``, and the pictures ``profile``, ``history`` and, of a pneumatic brake, ``brake``. Nothing is written,
    and no folder made, before all of the recording has been read. ``show`` is told how many samples of how many have
    been read.

    Raises
    ------
    HaulError
        The recording cannot be used, or the folder or a file cannot be written.
    """
    options = options or AnalysisOptions()
    with open_train(path, options.node, options.run) as source:
        reading = _Reading(source, options)
        read = 0

        def also(block: Samples, count: int) -> None:
            nonlocal read
            read += count
            show(read, source.samples)
            reading.add(block)

        numbers = numbers_of(source, reading.scenario, options.window, limit=options.limit, also=also)
        reading.add_air()
        tables = number_tables(numbers, reading.layout, reading.couplers, source.events()) | reading.series()
        with options.pictures.style():
            figures, arrays = reading.pictures(numbers), {"numbers": arrays_of(tables, numbers)}
            files = write_files(folder, tables, figures, options.pictures, arrays)
        return Analysis(reading.title, reading.layout, numbers, reading.summary(numbers), tuple(files))


def write_files(
    folder: Path,
    tables: Mapping[str, Table],
    figures: Mapping[str, Figure],
    pictures: PictureFormat,
    arrays: Mapping[str, Mapping[str, NDArray[Any]]] | None = None,
) -> list[Path]:
    """Write tables, arrays and pictures by their names into a folder, made if missing; returns the files.

    Raises
    ------
    AnalysisError
        The folder or a file cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        files = [file for name, table in tables.items() for file in write_table(table, folder / name)]
        files += [write_arrays(of_file, folder / f"{name}.npz") for name, of_file in (arrays or {}).items()]
        for name, figure in figures.items():
            files.append(folder / f"{name}.{pictures.suffix}")
            pictures.save(figure, files[-1])
    except OSError as error:
        raise AnalysisError(f"{error.filename or folder}: cannot be written: {error.strerror}") from error
    return files


class _Reading:
    """What of a recording is gathered for summary and pictures while its numbers are."""

    def __init__(self, source: TrainSource, options: AnalysisOptions) -> None:
        self._source, self._window = source, options.window
        self.scenario: Scenario | None = scenario_of(source)
        self.layout = TrainLayout.for_source(source, self.scenario)
        self.title = source.title
        self.couplers = None if options.couplers is None else _columns(source, options.couplers)
        self._series = None if self.couplers is None else CouplerRecorder(self.couplers)
        samples = _expected_samples(source, options.window)
        self._history = HistoryBuilder(samples, HISTORY_COLUMNS)
        self._brake = BrakeHistory(self.layout, samples)
        self._has_air = False
        self._journey: Journey | None = None
        if self.scenario is not None:
            self.title = f"{self.scenario.name}: {self.scenario.description}"
            self._journey = Journey(OverspeedWatch(self.scenario.consist, self.scenario.track))

    def add(self, block: Samples) -> None:
        """The next samples."""
        self._history.add(block)
        if self._journey is not None:
            self._journey.add(block.vehicles)
        if self._series is not None:
            self._series.add(block.couplers)
        self._brake.add(None, None, block.pressure)

    def add_air(self) -> None:
        """Pressures of a pneumatic brake, which lie beside the samples."""
        for pipe, auxiliary in self._source.air():
            self._has_air = True
            self._brake.add(series_within(pipe, self._window), series_within(auxiliary, self._window), None)

    def series(self) -> dict[str, Table]:
        """The samples of the chosen couplers, if any are chosen."""
        return {} if self._series is None else {"series": self._series.table(self.layout.couplers)}

    def summary(self, numbers: Numbers) -> RunSummary | None:
        """Of the whole run."""
        if self.scenario is None or self._journey is None or not self._journey.times_ns or not self._window.is_whole:
            return None
        return summarize_journey(self.scenario, self._journey, numbers.couplers.best)

    def pictures(self, numbers: Numbers) -> dict[str, Figure]:
        """Figures by the names of their files."""
        figures = {
            "profile": profile_figure(self.layout, numbers.couplers.best, self.title),
            "history": history_figure(self.layout, self._history.history(), self._events(), self.title),
        }
        if self._has_air:
            figures["brake"] = self._brake.figure(self.title)
        if self._series is not None:
            figures["series"] = self._series.figure(self.layout.couplers, self.title)
        return figures

    def _events(self) -> list[BrakeEvent]:
        found = [
            event
            for locomotive in self.layout.locomotives
            for event in brake_events(locomotive.vehicle, self._source.scalars(f"{locomotive.name}/applied_brake"))
        ]
        return [event for event in found if self._window.begin <= event.time <= self._window.end]


def _columns(source: TrainSource, numbers: Iterable[int]) -> list[int]:
    """Columns of couplers by number."""
    count = len(source.couplers)
    for number in numbers:
        if not 1 <= number <= count:
            raise AnalysisError(f"{source.path}: no coupler {number}, it has 1 to {count}")
    return sorted({number - 1 for number in numbers})


def _expected_samples(source: TrainSource, window: Window) -> int:
    """How many samples lie in a window if they are spread evenly."""
    begin, end = source.begin_ns / NS_PER_S, source.end_ns / NS_PER_S
    inside = min(window.end, end) - max(window.begin, begin)
    return max(1, ceil(source.samples * inside / (end - begin))) if end > begin else source.samples
