"""Waiting for one who may never answer, on a clock of its own."""

from __future__ import annotations

import logging
from concurrent.futures import Future

import pytest

from haul_ros.studies.errors import StudyError
from haul_ros.studies.heartbeat import ASK_AGAIN, GIVEN_UP_AFTER, TOLD_AFTER, Heartbeat


class Far:
    """Somebody who answers or not, and the clock of the one who waits."""

    def __init__(self) -> None:
        self.time = 0.0
        self.answer: str | Exception | None = ""
        self.asked: list[Future[str]] = []
        self.heartbeat = Heartbeat("the far one", self.ask, lambda: self.time)

    def ask(self) -> Future[str]:
        question: Future[str] = Future()
        if isinstance(self.answer, Exception):
            question.set_exception(self.answer)
        elif self.answer is not None:
            question.set_result(self.answer)
        self.asked.append(question)
        return question

    def wait(self, seconds: float) -> None:
        until = self.time + seconds
        while self.time < until:
            self.time += 0.5
            self.heartbeat.check()


def test_one_who_answers_is_asked_again_and_again() -> None:
    far = Far()
    far.wait(10 * GIVEN_UP_AFTER)
    assert len(far.asked) == 10 * GIVEN_UP_AFTER / ASK_AGAIN


@pytest.mark.parametrize(
    ("answer", "problem"),
    [(None, "does not answer"), ("has no workers", "has no workers"), (OSError("x"), "cannot be asked: OSError")],
)
def test_one_who_does_not_is_told_of_and_given_up(
    caplog: pytest.LogCaptureFixture, answer: str | Exception | None, problem: str
) -> None:
    far = Far()
    far.answer = answer
    far.wait(TOLD_AFTER)
    assert [record.getMessage() for record in caplog.records] == [
        f"the far one: {problem}, trying on for {GIVEN_UP_AFTER - TOLD_AFTER:g} s"
    ]
    with pytest.raises(StudyError, match=f"the far one: {problem}, given up after {GIVEN_UP_AFTER:g} s"):
        far.wait(GIVEN_UP_AFTER)
    assert far.time == GIVEN_UP_AFTER


def test_one_who_comes_back_is_told_of(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING)
    far = Far()
    far.answer = None
    far.wait(2 * TOLD_AFTER)
    assert all(question.cancelled() for question in far.asked[:-1])
    far.answer = ""
    far.wait(2 * GIVEN_UP_AFTER)
    assert caplog.records[-1].getMessage() == "the far one: is there again"


def test_time_in_which_nobody_looked_is_no_silence(caplog: pytest.LogCaptureFixture) -> None:
    far = Far()
    far.time = 10 * GIVEN_UP_AFTER
    far.heartbeat.check()
    far.wait(TOLD_AFTER)
    assert not caplog.records
