"""Recorded runs simulated again: the same to compare bit for bit, or another with the same driver."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from haul_ros.analysis.summary import recorded_scenario
from haul_ros.errors import CommandError, RecordingError
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.consist import Consist
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.sample import Sample
from haul_ros.recording.reader import Recording
from haul_ros.simulation.batch import RunError
from haul_ros.simulation.session import Session
from haul_ros.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class Difference:
    """The first number that came out differently: what of which coupler or vehicle, SI units."""

    time_ns: int
    topic: str
    name: str
    quantity: str
    recorded: float
    replayed: float


@dataclass(frozen=True, slots=True)
class Comparison:
    """Messages compared, how many differ in any bit, and where they begin to.

    ``dropped`` is what the recorder says (None: it did not end): without a recorded command a replay may differ.
    """

    messages: int
    differing: int
    first: Difference | None
    dropped: int | None


def replay_and_compare(recording: Recording, show: Callable[[Sample], None] = lambda _: None) -> Comparison:
    """Simulate a recorded run again and compare couplers, vehicles and cylinder pressure byte for byte.

    Raises
    ------
    HaulError
        The recording is damaged, of another train than its scenario's, or holds a command that cannot be carried out.
    """
    scenario = recorded_scenario(recording)
    session = Session(scenario, requests=recording.requests())
    encoder = TelemetryEncoder(scenario.consist, recording.channels.prefix)
    messages, differing = 0, 0
    first: Difference | None = None
    sample = session.sample()
    replayed = {message.channel.topic: message for message in encoder.sample(sample)}
    for recorded in recording.sample_messages():
        if steps := round((recorded.time_ns - session.time_ns) / NS_PER_S / scenario.time_step):
            sample = _advance(session, steps)
            replayed = {message.channel.topic: message for message in encoder.sample(sample)}
            show(sample)
        messages += 1
        if recorded.data != replayed[recorded.channel.topic].data:
            differing += 1
            again = replayed[recorded.channel.topic]
            first = first or _difference(recording, scenario.consist, encoder, recorded, again)
    if not messages:
        raise RecordingError(f"{recording.path}: holds no {recording.channels.couplers.topic}: nothing was run")
    return Comparison(messages, differing, first, recording.info().dropped)


def session_with_changes(recording: Recording, overrides: Mapping[str, object]) -> Session:
    """The recorded commands for the recorded scenario with values replaced; at least as long as the recorded run.

    Recorded changes of radio links are part of it unless a value of ``radio`` is replaced.

    Raises
    ------
    HaulError
        The recording is damaged, or there can be no such scenario.
    """
    scenario = recorded_scenario(recording, overrides)
    end = recording.info().end_ns / NS_PER_S
    requests = recording.requests()
    if any(key.split(".")[0] == "radio" for key in overrides):
        requests = tuple(timed for timed in requests if not isinstance(timed.request, RadioLinkChange))
    return Session(replace(scenario, max_duration=max(scenario.max_duration, end)), requests=requests)


def _advance(session: Session, steps: int) -> Sample:
    try:
        return session.advance(steps)
    except CommandError as error:
        raise RunError(f"{session.scenario.name}: at {session.time:.3f} s: {error}") from error


def _difference(
    recording: Recording, consist: Consist, encoder: TelemetryEncoder, recorded: Message, replayed: Message
) -> Difference:
    topic = recorded.channel.topic
    try:
        before, after = encoder.decode_sample(recorded), encoder.decode_sample(replayed)
    except ValueError as error:
        at = f"{recorded.time_ns / NS_PER_S:.3f} s"
        raise RecordingError(f"{recording.path}: {topic} at {at} is not of the recorded train: {error}") from error
    names = consist.coupler_names if topic == recording.channels.couplers.topic else consist.vehicle_names
    for quantity, values in before.items():
        others = after[quantity]
        if len(at_index := np.flatnonzero(values.view(np.int64) != others.view(np.int64))):
            i = int(at_index[0])
            return Difference(recorded.time_ns, topic, names[i], quantity, float(values[i]), float(others[i]))
    return Difference(recorded.time_ns, topic, "", "stamp", recorded.time_ns / NS_PER_S, replayed.time_ns / NS_PER_S)
