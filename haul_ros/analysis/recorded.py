"""The scenario and the summary of a recorded run."""

from __future__ import annotations

from collections.abc import Mapping

from haul_ros.analysis.summary import Journey, RunSummary, summarize_journey
from haul_ros.errors import RecordingError
from haul_ros.model.scenario import Scenario
from haul_ros.recording.reader import Recording
from haul_ros.scenario import load_scenario_text
from haul_ros.simulation.overspeed import OverspeedWatch


def recorded_scenario(recording: Recording, overrides: Mapping[str, object] | None = None) -> Scenario:
    """The scenario that a recording carries, with values replaced as for `load_scenario`.

    Raises
    ------
    HaulError
        The file is damaged, its scenario is not one that this version understands, or of another train.
    """
    facts = recording.info()
    scenario = load_scenario_text(recording.scenario_document, facts.scenario, None)
    locomotives = tuple(locomotive.name for locomotive in scenario.consist.locomotives)
    if (len(scenario.consist.vehicles), locomotives) != (facts.vehicles, facts.locomotives):
        raise RecordingError(f"{recording.path}: its scenario is of another train than its description of the run")
    sensors = scenario.sensors.couplers if scenario.sensors else ()
    if tuple(scenario.consist.coupler_names[coupler] for coupler in sensors) != facts.measured:
        raise RecordingError(f"{recording.path}: its scenario has other sensors than its description of the run")
    if scenario.recording != facts.plan:
        raise RecordingError(
            f"{recording.path}: its samples are recorded otherwise than its description of the run says"
        )
    return load_scenario_text(recording.scenario_document, facts.scenario, overrides) if overrides else scenario


def summarize_recording(recording: Recording, scenario: Scenario) -> RunSummary:
    """Summary of the run in a recording, with its `recorded_scenario`.

    Raises
    ------
    RecordingError
        The file is damaged or holds no samples.
    """
    journey = Journey(OverspeedWatch(scenario.consist, scenario.track))
    for block in recording.blocks():
        journey.add(block.vehicles)
    if not journey.times_ns:
        raise RecordingError(f"{recording.path}: holds no {recording.channels.vehicles.topic}: nothing was run")
    return summarize_journey(scenario, journey, recording.last_extremes().extremes)
