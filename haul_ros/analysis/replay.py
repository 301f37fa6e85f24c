"""Recorded runs simulated again: the same to compare bit for bit, or another with the same driver."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from haul_ros.analysis.recorded import recorded_scenario
from haul_ros.errors import CommandError, RecordingError
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.model.consist import Consist
from haul_ros.model.fault import Fault
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.sample import Sample
from haul_ros.recording.info import RecordingInfo
from haul_ros.recording.reader import Recording
from haul_ros.simulation.batch import RunError
from haul_ros.simulation.session import Session
from haul_ros.units import NS_PER_S, seconds_to_ns

LONGEST_GAP = 600.0
"""Simulation time [s] without a message that a recorder may have dropped; behind a longer one times are damaged."""


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

    ``missing`` has how many messages by topic should be there and are not; the key "" stands for those of any topic
    that the recorder wrote and the file no longer has. ``dropped`` is what the recorder says (None: it did not end):
    without a recorded command a replay may differ. What is compared was rounded before, to the resolutions in
    ``rounding`` by quantity, but for the extremes.
    """

    messages: int
    differing: int
    first: Difference | None
    missing: Mapping[str, int]
    dropped: int | None
    rounding: Mapping[str, float] = field(default_factory=dict)

    @property
    def identical(self) -> bool:
        """Every message is there and the same."""
        return self.first is None and not self.missing


def replay_and_compare(recording: Recording, show: Callable[[Sample], None] = lambda _: None) -> Comparison:
    """Simulate a recorded run again and compare couplers, vehicles, cylinder pressure and extremes byte for byte.

    Raises
    ------
    HaulError
        The recording is damaged, of another train than its scenario's, or holds a command that cannot be carried out.
    """
    scenario = recorded_scenario(recording)
    session = Session(scenario, requests=recording.requests(), play_faults=False)
    encoder = TelemetryEncoder.like(recording.channels, scenario)
    older = recording.has_times_in_velocity()
    messages, differing = 0, 0
    first: Difference | None = None
    counted = (*recording.channels.samples, *recording.channels.measured)
    times: dict[str, list[int]] = {channel.topic: [] for channel in counted}
    replayed = _replayed(encoder, session, session.sample())
    for recorded in recording.state_messages():
        if steps := round((recorded.time_ns - session.time_ns) / NS_PER_S / scenario.time_step):
            if not 0 < steps * scenario.time_step <= LONGEST_GAP:
                problem = f"a message of {recorded.time_ns / NS_PER_S:.3f} s follows that of {session.time:.3f} s"
                raise RecordingError(f"{recording.path}: {problem}: not replayed, its times cannot be right")
            sample = _advance(session, steps)
            replayed = _replayed(encoder, session, sample)
            show(sample)
        messages += 1
        topic = recorded.channel.topic
        if topic in times:
            times[topic].append(recorded.time_ns)
            if topic not in replayed:
                raise RecordingError(f"{recording.path}: {topic} at {session.time:.3f} s, when no sensor measures")
        elif topic not in replayed:  # once a second, not with every sample
            extremes = encoder.extremes(session.time_ns, session.extremes(), time_in_velocity=older)
            replayed |= _by_topic(extremes)
        if recorded.data != replayed[topic].data:
            differing += 1
            again = replayed[topic]
            first = first or _difference(recording, scenario.consist, encoder, recorded, again)
    if not messages:
        raise RecordingError(f"{recording.path}: holds no {recording.channels.couplers.topic}: nothing was run")
    facts = recording.info()
    missing, rounding = _missing(recording, times, session), scenario.recording.rounding.resolutions()
    return Comparison(messages, differing, first, missing, facts.dropped, rounding)


def _by_topic(messages: Iterable[Message]) -> dict[str, Message]:
    return {message.channel.topic: message for message in messages}


def _replayed(encoder: TelemetryEncoder, session: Session, sample: Sample) -> dict[str, Message]:
    measurement = session.measurement(sample)
    measured = [] if measurement is None else [encoder.measurement(measurement)]
    return _by_topic([*encoder.sample(sample), *measured])


def _missing(recording: Recording, times: Mapping[str, list[int]], session: Session) -> dict[str, int]:
    """How many messages by topic are not there that the others, their rate or the recorder tell of."""
    facts, scenario = recording.info(), session.scenario
    begin = min(set().union(*times.values()), default=0)
    measured = {channel.topic: times[channel.topic] for channel in recording.channels.measured}
    sampled = {topic: there for topic, there in times.items() if topic not in measured}
    missing = _missing_of_rate(sampled, begin, scenario.recording.every, facts, session)
    if scenario.sensors is not None:
        missing |= _missing_of_rate(measured, begin, scenario.sensors.every, facts, session)
    if facts.written is not None and facts.written > facts.messages + sum(missing.values()):
        missing[""] = facts.written - facts.messages - sum(missing.values())
    return {topic: count for topic, count in missing.items() if count}


def _missing_of_rate(
    times: Mapping[str, list[int]], begin: int, every: int, facts: RecordingInfo, session: Session
) -> dict[str, int]:
    """How many of each topic are not there, of which every ``every``-th sample and those of the others have one."""
    found, period = set().union(*times.values()), session.steps_per_sample * every
    time_step = session.scenario.time_step
    first, last = (round(time_ns / NS_PER_S / time_step) for time_ns in (begin, facts.end_ns))
    steps = range(-(-first // period) * period, last + 1, period)  # no set of them: a time may be years away

    def regular(time_ns: int) -> bool:
        step = round(time_ns / NS_PER_S / time_step)
        return step in steps and seconds_to_ns(step * time_step) == time_ns

    expected = len(steps) + sum(not regular(time_ns) for time_ns in found)
    latest = max([*found, *(seconds_to_ns(step * time_step) for step in steps[-1:])], default=0)
    missing = {}
    for topic, there in times.items():
        missing[topic] = expected - len(set(there))
        if facts.dropped is None and latest not in there:  # it ended anywhere, between two messages of a sample too
            missing[topic] -= 1
    return missing


def session_with_changes(recording: Recording, overrides: Mapping[str, object]) -> Session:
    """The recorded commands for the recorded scenario with values replaced; at least as long as the recorded run.

    Recorded changes of radio links are part of it unless a value of ``radio`` is replaced, recorded faults unless one
    of ``faults`` is: then those of the scenario happen.

    Raises
    ------
    HaulError
        The recording is damaged, or there can be no such scenario.
    """
    scenario = recorded_scenario(recording, overrides)
    end = recording.info().end_ns / NS_PER_S
    room = (recording.count(recording.channels.couplers) + 1) / scenario.record_rate + LONGEST_GAP
    if end > max(room, scenario.max_duration):
        raise RecordingError(f"{recording.path}: has too few couplers for {end:.3f} s, its times cannot be right")
    sections = {key.split(".")[0] for key in overrides}
    left_out: tuple[type, ...] = (RadioLinkChange,) if "radio" in sections else ()
    left_out += (Fault,) if "faults" in sections else ()
    requests = tuple(timed for timed in recording.requests() if not isinstance(timed.request, left_out))
    longest = replace(scenario, max_duration=max(scenario.max_duration, end))
    return Session(longest, requests=requests, play_faults="faults" in sections)


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
        before, after = encoder.decode_state(recorded), encoder.decode_state(replayed)
    except ValueError as error:
        at = f"{recorded.time_ns / NS_PER_S:.3f} s"
        raise RecordingError(f"{recording.path}: {topic} at {at} is not of the recorded train: {error}") from error
    names = consist.coupler_names
    if recorded.channel in (recording.channels.vehicles, *recording.channels.pressures):
        names = consist.vehicle_names
    elif recorded.channel in recording.channels.measured:
        names = encoder.measured_names
    for quantity, values in before.items():
        others = after[quantity]
        if len(at_index := np.flatnonzero(values.view(np.int64) != others.view(np.int64))):
            i = int(at_index[0])
            return Difference(recorded.time_ns, topic, names[i], quantity, float(values[i]), float(others[i]))
    return Difference(recorded.time_ns, topic, "", "stamp", recorded.time_ns / NS_PER_S, replayed.time_ns / NS_PER_S)
