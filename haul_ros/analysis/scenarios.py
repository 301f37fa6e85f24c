"""The scenario of a train in a recording of any kind."""

from __future__ import annotations

from haul_ros.analysis.recorded import recorded_scenario
from haul_ros.errors import RecordingError
from haul_ros.model.scenario import Scenario
from haul_ros.recording.train_source import TrainSource
from haul_ros.recording.trains import RecordedTrain
from haul_ros.scenario import load_scenario_text


def scenario_of(source: TrainSource) -> Scenario | None:
    """The scenario that a recording carries; None: it carries none, as bags by other recorders.

    Raises
    ------
    HaulError
        Its scenario is not one that this version understands, or of another train.
    """
    if isinstance(source, RecordedTrain):
        return recorded_scenario(source.recording)
    if source.scenario_document is None:
        return None
    scenario = load_scenario_text(source.scenario_document, source.path.stem, None)
    vehicles = scenario.consist.vehicle_names
    if source.couplers != scenario.consist.coupler_names or source.vehicles not in ((), vehicles):
        raise RecordingError(f"{source.path}: its scenario is of another train than its samples")
    return scenario
