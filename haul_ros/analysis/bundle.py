"""All results of a recording, as files in one folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from haul_ros.analysis.brake_plots import brake_figure
from haul_ros.analysis.history import read_history
from haul_ros.analysis.plots import HISTORY_COLUMNS, brake_events, history_figure, profile_figure
from haul_ros.analysis.plotting import save_png
from haul_ros.analysis.summary import RunSummary, recorded_scenario, summarize_recording
from haul_ros.analysis.tables import peak_table, write_table
from haul_ros.errors import HaulError
from haul_ros.recording.reader import Recording


class AnalysisError(HaulError):
    """Results of an analysis that cannot be written."""


@dataclass(frozen=True, slots=True)
class Analysis:
    """What was found, and the files written."""

    summary: RunSummary
    files: tuple[Path, ...]


def default_folder(recording: Path) -> Path:
    """``<name of the file>_analysis`` in the current folder."""
    return Path(f"{recording.stem}_analysis")


def analyze(path: Path, folder: Path) -> Analysis:
    """Analyse a recording into a folder, made if missing; results of an earlier analysis there are replaced.

    Writes ``peaks.csv``, ``peaks.parquet`` (if pyarrow is installed), ``profile.png``, ``history.png`` and, of a
    pneumatic brake, ``brake.png``. Nothing is written, and no folder made, before all of the recording has been read.

    Raises
    ------
    HaulError
        The recording cannot be used, or the folder or a file cannot be written.
    """
    with Recording(path) as recording:
        scenario = recorded_scenario(recording)
        summary = summarize_recording(recording, scenario)
        extremes = recording.last_extremes().extremes
        history = read_history(recording, HISTORY_COLUMNS)
        pipe, auxiliary = recording.pipe_pressure(), recording.auxiliary_pressure()
        cylinder = recording.pressure() if pipe is not None else None
        events = [
            event
            for locomotive in scenario.consist.locomotives
            for event in brake_events(locomotive.vehicle, recording.scalars(f"{locomotive.name}/applied_brake"))
        ]
    table = peak_table(scenario.consist, extremes)
    title = f"{scenario.name}: {scenario.description}"
    profile = profile_figure(scenario.consist, extremes, title)
    over_time = history_figure(scenario.consist, history, events, title)

    pictures = {folder / "profile.png": profile, folder / "history.png": over_time}
    if pipe is not None and auxiliary is not None and cylinder is not None:
        pictures[folder / "brake.png"] = brake_figure(scenario.consist, pipe, auxiliary, cylinder, title)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        files = write_table(table, folder / "peaks")
        for picture, figure in pictures.items():
            save_png(figure, picture)
    except OSError as error:
        raise AnalysisError(f"{error.filename or folder}: cannot be written: {error.strerror}") from error
    return Analysis(summary, (*files, *pictures))
