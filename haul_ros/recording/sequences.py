"""The numbers that a recorder gives the messages of each topic: what is missing in a file, and what is there twice."""

from __future__ import annotations

from bisect import bisect_right

from mcap.records import Message

_MOST_HOLES = 10_000
"""Ranges of missing numbers that are remembered of a topic; what comes late into an older one counts as repeated."""


class OutOfOrderError(Exception):
    """A message comes behind one that follows it: chunks have changed their places."""


class _Topic:
    """Numbers of one topic: ``following`` is the next one, ``holes`` are ranges before it that are missing."""

    def __init__(self) -> None:
        self.following = 0
        self.last_ns = 0
        self.holes: list[tuple[int, int]] = []

    def fill(self, number: int) -> bool:
        """Whether a number was missing until now."""
        at = bisect_right(self.holes, (number, 2**63)) - 1
        if at < 0 or number >= self.holes[at][1]:
            return False
        begin, end = self.holes[at]
        self.holes[at : at + 1] = [part for part in ((begin, number), (number + 1, end)) if part[0] < part[1]]
        return True


class Sequences:
    """Takes the messages of a file in its order; numbers of a topic begin at 0.

    ``missing`` numbers lie before one that is there, in ``gaps`` of simulation time [ns]; ``repeated`` were there
    before. Where messages of several topics are missing at a time, the gap is what all of them leave open: that of a
    topic of few messages alone is far wider than what is missing.
    """

    def __init__(self, *, late: bool = False) -> None:
        self._late = late
        self.missing = self.repeated = 0
        self.gaps: list[tuple[int, int]] = []
        self._topics: dict[str, _Topic] = {}

    def take(self, topic: str, message: Message) -> bool:
        """Whether a message is to be kept.

        Raises
        ------
        OutOfOrderError
            It fills a gap, and the messages that are ``late`` are not expected.
        """
        state = self._topics.setdefault(topic, _Topic())
        number = message.sequence
        if number < state.following:
            if not state.fill(number):
                self.repeated += 1
                return False
            if not self._late:
                raise OutOfOrderError
            self.missing -= 1
            return True
        if number > state.following:
            self.missing += number - state.following
            state.holes.append((state.following, number))
            del state.holes[:-_MOST_HOLES]
            self._add_gap(state.last_ns, message.log_time)
        state.following, state.last_ns = number + 1, message.log_time
        return True

    def _add_gap(self, begin: int, end: int) -> None:
        if self.gaps and begin < self.gaps[-1][1] and end > self.gaps[-1][0]:
            begin, end = max(begin, self.gaps[-1][0]), min(end, self.gaps[-1][1])
            self.gaps.pop()
        self.gaps.append((begin, end))
