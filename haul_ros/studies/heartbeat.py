"""Whether somebody far away still answers."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from concurrent.futures import Future

from haul_ros.studies.errors import StudyError

ASK_AGAIN = 5.0
"""Wall time [s] from one question to the next; one without an answer by then is asked anew."""
TOLD_AFTER = 15.0
"""Wall time [s] without an answer after which the user is told."""
GIVEN_UP_AFTER = 120.0
"""Wall time [s] without an answer after which there is no more waiting."""

_LOG = logging.getLogger(__name__)


class Heartbeat:
    """Asks again and again; ``ask`` starts a question, whose answer is what is wrong there, empty: nothing.

    ``whom`` names the one who is asked. For one thread.
    """

    def __init__(self, whom: str, ask: Callable[[], Future[str]], now: Callable[[], float] = time.monotonic) -> None:
        self._whom = whom
        self._ask = ask
        self._now = now
        self._problem = "does not answer"
        self._question: Future[str] | None = None
        self._asked = self._well = self._looked = now()
        self._told = False

    def check(self) -> None:
        """Look for the answer and ask again; never waits.

        Raises
        ------
        StudyError
            For `GIVEN_UP_AFTER` there was no answer, or none that all is well.
        """
        now = self._now()
        if now > self._looked + ASK_AGAIN:  # nobody looked, or this process was stopped: that says nothing of the other
            self._well += now - self._looked
        self._looked = now
        if self._question is not None and self._question.done():
            self._note(self._question, now)
            self._question = None
        if now >= self._asked + ASK_AGAIN:
            if self._question is not None:
                self._question.cancel()
                self._problem = "does not answer"
            self._question, self._asked = self._ask(), now
        self._judge(now - self._well)

    def _note(self, question: Future[str], now: float) -> None:
        try:
            self._problem = question.result()
        except Exception as error:  # whatever the connection raises
            self._problem = f"cannot be asked: {type(error).__name__}"
        if not self._problem:
            if self._told:
                _LOG.warning("%s: is there again", self._whom)
            self._well, self._told = now, False

    def _judge(self, silence: float) -> None:
        if silence >= GIVEN_UP_AFTER:
            raise StudyError(
                f"{self._whom}: {self._problem}, given up after {GIVEN_UP_AFTER:g} s; "
                "finished cases are kept, the same command goes on from there"
            )
        if silence >= TOLD_AFTER and not self._told:
            self._told = True
            _LOG.warning("%s: %s, trying on for %g s", self._whom, self._problem, GIVEN_UP_AFTER - silence)
