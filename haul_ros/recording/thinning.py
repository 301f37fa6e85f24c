"""Which of the published samples a recording gets."""

from __future__ import annotations

from collections.abc import Sequence

from haul_ros.messages.channels import ChannelTable
from haul_ros.messages.encoder import Message
from haul_ros.model.scenario import Scenario
from haul_ros.units import NS_PER_S


class Thinning:
    """Takes every n-th sample, as the scenario says, and the last one of all.

    The first is that at the start of the run; whatever is no sample is taken.
    """

    def __init__(self, scenario: Scenario, channels: ChannelTable) -> None:
        self._every = scenario.recording.every
        self._time_step = scenario.time_step
        self._steps = scenario.steps_per_sample * scenario.recording.every
        self._topics = {channel.topic for channel in channels.samples}
        self._last: list[Message] = []

    def taken(self, messages: Sequence[Message]) -> Sequence[Message]:
        """Those of the messages of one instant that are recorded."""
        if self._every == 1:
            return messages
        sample = [message for message in messages if message.channel.topic in self._topics]
        if not sample:
            return messages
        due = self._is_due(sample[0].time_ns)
        self._last = [] if due else sample
        return messages if due else [message for message in messages if message.channel.topic not in self._topics]

    def rest(self) -> Sequence[Message]:
        """The last sample, if it was not taken; to be asked for at the end of the run."""
        return self._last

    def _is_due(self, time_ns: int) -> bool:
        return round(time_ns / NS_PER_S / self._time_step) % self._steps == 0
