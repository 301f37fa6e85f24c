"""Acknowledgements and retries, duplicates and telegrams out of order."""

from __future__ import annotations

import pytest

from haul_ros.model.command import Command, CommandKind
from haul_ros.model.radio import RadioLink
from haul_ros.simulation.radio import Attempt, Counts, Radio
from haul_ros.simulation.telegrams import Telegrams

STEP = 0.01


class Line:
    """One slave at the end of a link, with what it does and hears, and what is told of it."""

    def __init__(self, link: RadioLink, seed: int = 0, radio: Radio | None = None) -> None:
        self.radio = radio or Radio({"slave_1": link}, seed)
        self.acted: list[tuple[float, float]] = []
        self.heard: list[float] = []
        self.told: list[str] = []
        self.telegrams = Telegrams(
            self.radio,
            STEP,
            air_between_steps=True,
            carry_out=lambda time, command: self.acted.append((round(time, 9), command.value)),
            seen=lambda _time, _slave, _answered: None,
            heard=lambda _, time: self.heard.append(time),
            log=lambda _, text: self.told.append(text.removeprefix("slave_1: ")),
        )
        self.step = 0

    @property
    def counts(self) -> Counts:
        return self.radio.counts["slave_1"]

    def send(self, value: float, kind: CommandKind = CommandKind.BRAKE) -> None:
        self.telegrams.send(Command("slave_1", kind, value), self.step, self.step * STEP)

    def run(self, time: float) -> None:
        """On to a time [s], from one step at which something is due to the next."""
        end = round(time / STEP)
        while (due := self.telegrams.next_step) is not None and due <= end:
            self.step = due
            self.telegrams.carry_out_due(self.step, self.step * STEP)
        self.step = end


class Scripted(Radio):
    """A link on which every attempt and every answer fares as it was written down."""

    def __init__(self, link: RadioLink, attempts: list[Attempt], answers: list[float | None]) -> None:
        super().__init__({"slave_1": link}, 0)
        self._attempts, self._answers = attempts, answers

    def first_attempt(self, slave: str, time: float) -> Attempt:
        self.counts[slave].sent += 1
        return self._attempts.pop(0)

    def retry(self, slave: str, number: int, attempt: int, time: float) -> Attempt:
        self.counts[slave].retried += 1
        return self._attempts.pop(0)

    def acknowledge(self, slave: str, number: int, attempt: int, copy: int, time: float) -> float | None:
        return self._answers.pop(0)


def test_a_lost_telegram_is_sent_again_until_it_is_acknowledged() -> None:
    link = RadioLink(retries=4, retry_interval=0.5)
    line = Line(link, radio=Scripted(link, [Attempt(None), Attempt(None), Attempt(1.1)], [1.2]))
    line.send(0.5)
    line.run(10.0)
    assert line.acted == [(1.1, 0.5)]
    assert line.told == [
        "telegram lost: brake 0.5",
        "sent again, 1 of 4: brake 0.5",
        "telegram lost: brake 0.5",
        "sent again, 2 of 4: brake 0.5",
    ]
    assert (line.counts.retried, line.counts.given_up, line.counts.duplicates) == (2, 0, 0)
    assert len(line.telegrams) == 0
    assert line.radio.status()["slave_1"].connected


def test_without_an_acknowledgement_it_arrives_again_and_is_not_acted_on_twice() -> None:
    link = RadioLink(retries=2, retry_interval=0.5)
    line = Line(link, radio=Scripted(link, [Attempt(0.1), Attempt(0.6), Attempt(1.1)], [None, 1.3, 1.4]))
    line.send(0.5)
    line.run(10.0)
    assert line.acted == [(0.1, 0.5)]
    assert line.told == [
        "acknowledgement lost: brake 0.5",
        "sent again, 1 of 2: brake 0.5",
        "duplicate ignored: brake 0.5",
        "sent again, 2 of 2: brake 0.5",  # the answer to the first retry is late
        "duplicate ignored: brake 0.5",
    ]
    assert (line.counts.retried, line.counts.duplicates, line.counts.given_up) == (2, 2, 0)
    assert line.heard == pytest.approx([0.1, 0.6, 1.1])


def test_what_nobody_acknowledges_is_given_up_after_the_last_wait() -> None:
    line = Line(RadioLink(delay=0.1, retries=2, retry_interval=0.5, fails="from_slave"))
    line.send(0.5)
    line.run(1.49)
    assert line.counts.given_up == 0
    line.run(1.5)
    assert line.told[-1] == "given up, not acknowledged: brake 0.5"
    assert line.acted == [(0.1, 0.5)]
    assert (line.counts.retried, line.counts.duplicates, line.counts.given_up) == (2, 2, 1)
    assert not line.radio.status()["slave_1"].connected


def test_a_telegram_older_than_the_newest_of_its_kind_is_ignored() -> None:
    link = RadioLink(in_order=False)
    line = Line(link, radio=Scripted(link, [Attempt(3.0), Attempt(1.0), Attempt(2.0), Attempt(4.0), Attempt(3.5)], []))
    line.send(0.1)
    line.send(0.2)
    line.send(1.0, CommandKind.EMERGENCY)
    line.send(100.0, CommandKind.TRACTION)
    line.send(50.0, CommandKind.ELECTRIC_BRAKE)  # of this and traction the newer counts
    line.run(10.0)
    assert [value for _, value in line.acted] == [0.2, 1.0, 50.0]
    assert line.told == ["out of order, ignored: brake 0.1", "out of order, ignored: traction 100"]
    assert line.counts.out_of_order == 2


@pytest.mark.parametrize(("loss", "retries"), [(0.5, 0), (0.5, 1), (0.5, 3), (0.8, 4)])
def test_the_share_that_arrives_is_that_of_independent_attempts(loss: float, retries: int) -> None:
    count = 1500
    line = Line(RadioLink(loss_probability=loss, retries=retries, retry_interval=0.1), seed=4)
    for n in range(count):
        line.run(float(n))
        line.send(n / count)
    line.run(count + 10.0)
    arrives = 1.0 - loss ** (retries + 1)
    deviation = (arrives * (1.0 - arrives) / count) ** 0.5
    assert len(line.acted) / count == pytest.approx(arrives, abs=4 * deviation)
    assert len({value for _, value in line.acted}) == len(line.acted)
    # An attempt is the last if telegram and answer both get through.
    fails = 1.0 - (1.0 - loss) ** 2
    retried = sum(fails**k for k in range(1, retries + 1))
    assert line.counts.retried / count == pytest.approx(retried, rel=0.08)
    assert line.counts.sent == count
    assert line.counts.lost == pytest.approx(loss * (count + line.counts.retried), rel=0.08)
    if retries:
        assert line.counts.given_up / count == pytest.approx(fails ** (retries + 1), rel=0.15)
        assert line.counts.duplicates > 0


def test_how_often_one_is_sent_again_changes_no_luck_of_later_ones() -> None:
    patient, impatient = (Line(RadioLink(loss_probability=0.5, retries=n, retry_interval=0.1), 9) for n in (1, 6))
    for line in (patient, impatient):
        for n in range(200):
            line.run(10.0 * n)
            line.send(n / 200)
        line.run(5000.0)
    first = [{value for time, value in line.acted if time % 10.0 == 0.0} for line in (patient, impatient)]
    assert first[0] == first[1]
    assert len(impatient.acted) > len(patient.acted)
