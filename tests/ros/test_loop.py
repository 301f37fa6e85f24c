"""The loop: what it does when, with a run that only keeps a log."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any, cast

import pytest

from haul_ros.errors import CommandError, HaulError, RecordingError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import Request
from haul_ros.ros.loop import LoopError, SimulationLoop
from haul_ros.ros.timing import LoopTiming
from tests.waiting import WAIT

PERIOD_NS = 20_000_000
BRAKE = Command("master", CommandKind.BRAKE, 0.5)
WRONG = Command("master", CommandKind.EMERGENCY, 0.0)
LATE = RadioLinkChange("slave_1", delay=2.0, jitter=0.5)
CUT = RadioLinkChange("slave_1", connected=False)


class LoggingRun:
    """Null physics: a period passes when asked for, and everything is written down with its time."""

    steps_per_sample = 20

    def __init__(self, failing: Exception | None = None, failing_close: Exception | None = None) -> None:
        self.time_ns = 0
        self.log: list[Any] = []
        self._failing = failing
        self._failing_close = failing_close
        self._advanced = threading.Condition()

    def start(self) -> None:
        self.log.append(("start", self.time_ns))

    def advance(self, _stop: Callable[[], bool] = lambda: False) -> int:
        if self._failing is not None:
            raise self._failing
        with self._advanced:
            self.time_ns += PERIOD_NS
            self.log.append(("advance", self.time_ns))
            self._advanced.notify_all()
        return 1000

    def request(self, request: Request) -> None:
        if request == WRONG:
            raise CommandError("out of range")
        self.log.append(("request", self.time_ns, request))

    def report(self, timing: LoopTiming, *, paused: bool, replaced: int, refused: int) -> None:
        self.log.append(("report", self.time_ns, timing, paused, replaced, refused))

    def close(self) -> None:
        self.log.append(("close", self.time_ns))
        if self._failing_close is not None:
            raise self._failing_close

    def wait_for_time(self, time_ns: int) -> None:
        with self._advanced:
            assert self._advanced.wait_for(lambda: self.time_ns >= time_ns, WAIT)


class Ending:
    """Whether the loop has ended, and what it rejected."""

    def __init__(self) -> None:
        self.ended = threading.Event()
        self.rejected: list[tuple[Request, str]] = []

    def reject(self, request: Request, error: CommandError) -> None:
        self.rejected.append((request, str(error)))


StartLoop = Callable[..., tuple[SimulationLoop, Ending]]


@pytest.fixture
def start_loop() -> Iterator[StartLoop]:
    loops = []

    def start(run: Any, real_time_factor: float = 1.0, **more: Any) -> tuple[SimulationLoop, Ending]:
        ending = Ending()
        endings: dict[str, Any] = {"on_rejected": ending.reject, "on_end": ending.ended.set}
        loop = SimulationLoop(run, PERIOD_NS, real_time_factor, **endings, **more)
        loop.start()
        loops.append(loop)
        return loop, ending

    yield start
    for loop in loops:
        loop.stop()


@pytest.mark.parametrize("real_time_factor", [0.0, 1.0, 50.0])
def test_a_run_begins_with_its_start_advances_by_itself_and_is_closed_at_the_end(
    start_loop: StartLoop, real_time_factor: float
) -> None:
    run = LoggingRun()
    loop, ending = start_loop(run, real_time_factor)
    run.wait_for_time(3 * PERIOD_NS)
    loop.stop()
    assert ending.ended.is_set()
    assert loop.failure is None
    assert run.log[0] == ("start", 0)
    assert run.log[-1] == ("close", run.time_ns)
    advanced = [entry[1] for entry in run.log if entry[0] == "advance"]
    assert advanced == [PERIOD_NS * n for n in range(1, len(advanced) + 1)]


def test_while_paused_only_step_advances_and_each_step_by_one_period(start_loop: StartLoop) -> None:
    run = LoggingRun()
    loop, _ = start_loop(run, 0.0)
    run.wait_for_time(PERIOD_NS)
    assert "paused at" in loop.pause(True).result(WAIT)
    paused_at = run.time_ns
    assert loop.step().result(WAIT) == f"stepped at {(paused_at + PERIOD_NS) / 1e9:.3f} s"
    loop.step().result(WAIT)
    assert run.time_ns == paused_at + 2 * PERIOD_NS
    loop.pause(False).result(WAIT)
    run.wait_for_time(paused_at + 4 * PERIOD_NS)


def test_the_state_is_told_as_it_changes(start_loop: StartLoop) -> None:
    run, again = LoggingRun(), cast(Any, LoggingRun())
    states: list[str] = []
    loop, _ = start_loop(run, on_state=states.append)
    run.wait_for_time(PERIOD_NS)
    loop.pause(True).result(WAIT)
    loop.reset(again).result(WAIT)
    loop.pause(False).result(WAIT)
    loop.stop()
    assert states == ["running", "paused", "running", "ended"]


def test_a_step_while_running_is_refused(start_loop: StartLoop) -> None:
    loop, _ = start_loop(LoggingRun())
    with pytest.raises(LoopError, match="only while paused"):
        loop.step().result(WAIT)


def test_requests_act_at_the_present_simulation_time_in_the_order_given(start_loop: StartLoop) -> None:
    run = LoggingRun()
    loop, _ = start_loop(run)
    loop.pause(True).result(WAIT)
    now = run.time_ns
    for request in (BRAKE, LATE, CUT):
        loop.request(request)
    loop.step().result(WAIT)
    assert run.log[-4:] == [
        ("request", now, BRAKE),
        ("request", now, LATE),
        ("request", now, CUT),
        ("advance", now + PERIOD_NS),
    ]


def test_what_means_nothing_is_reported_and_replaces_nothing(start_loop: StartLoop) -> None:
    run = LoggingRun()
    loop, ending = start_loop(run)
    loop.pause(True).result(WAIT)
    nonsense = Command("master", CommandKind.BRAKE, float("nan"))
    good = loop.request(BRAKE)
    for _ in range(3):
        with pytest.raises(CommandError, match="must be a finite number"):
            loop.request(nonsense).result(WAIT)
    assert "accepted" in good.result(WAIT)
    assert [request for request, _ in ending.rejected] == [nonsense] * 3


def test_commands_during_a_slow_period_are_served_before_its_end(start_loop: StartLoop) -> None:
    run = LoggingRun()
    loop, _ = start_loop(run, 0.001)
    assert loop.request(BRAKE).result(WAIT) == "accepted at 0.000 s"
    assert loop.set_real_time_factor(0.0).result(WAIT) == "set at 0.000 s"
    run.wait_for_time(10 * PERIOD_NS)


def test_a_command_that_cannot_be_carried_out_is_reported_and_the_run_goes_on(start_loop: StartLoop) -> None:
    run = LoggingRun()
    loop, ending = start_loop(run)
    with pytest.raises(CommandError, match="out of range"):
        loop.request(WRONG).result(WAIT)
    assert ending.rejected == [(WRONG, "out of range")]
    run.wait_for_time(run.time_ns + PERIOD_NS)


def test_a_reset_closes_the_run_and_starts_the_next_paused_if_it_was(start_loop: StartLoop) -> None:
    first = LoggingRun()
    second: Any = LoggingRun()
    loop, _ = start_loop(first)
    first.wait_for_time(PERIOD_NS)
    loop.pause(True).result(WAIT)
    assert loop.reset(second).result(WAIT) == "started again at 0.000 s"
    assert first.log[-1] == ("close", first.time_ns)
    loop.step().result(WAIT)
    assert second.log == [("start", 0), ("advance", PERIOD_NS)]


def test_a_recording_that_fails_at_a_reset_is_reported_and_the_next_run_has_begun(start_loop: StartLoop) -> None:
    second: Any = LoggingRun()
    loop, _ = start_loop(LoggingRun(failing_close=RecordingError("disk full")))
    with pytest.raises(RecordingError, match="disk full"):
        loop.reset(second).result(WAIT)
    second.wait_for_time(PERIOD_NS)


def test_reports_go_on_while_paused_and_say_so(start_loop: StartLoop) -> None:
    run = LoggingRun()
    reported = threading.Event()
    run.report = lambda timing, *, paused, **_: reported.set() if paused else None  # type: ignore[method-assign]
    loop, _ = start_loop(run)
    loop.pause(True).result(WAIT)
    assert reported.wait(WAIT)


def test_an_error_in_the_physics_ends_the_loop_closes_the_run_and_is_kept(start_loop: StartLoop) -> None:
    run = LoggingRun(failing=FloatingPointError("diverged"))
    loop, ending = start_loop(run, 0.0)
    assert ending.ended.wait(WAIT)
    assert isinstance(loop.failure, FloatingPointError)
    assert run.log[-1] == ("close", 0)


def test_an_error_at_closing_is_kept_too_but_not_instead_of_the_first(start_loop: StartLoop) -> None:
    loop, ending = start_loop(LoggingRun(failing_close=RecordingError("disk full")))
    loop.stop()
    assert isinstance(loop.failure, RecordingError)
    loop, ending = start_loop(LoggingRun(FloatingPointError("diverged"), RecordingError("disk full")))
    assert ending.ended.wait(WAIT)
    assert isinstance(loop.failure, FloatingPointError)


def test_what_was_asked_but_not_served_before_the_end_is_refused(start_loop: StartLoop) -> None:
    closing, go_on = threading.Event(), threading.Event()
    run = LoggingRun()

    def close() -> None:
        closing.set()
        assert go_on.wait(WAIT)

    run.close = close  # type: ignore[method-assign]
    loop, _ = start_loop(run)
    threading.Thread(target=loop.stop).start()
    assert closing.wait(WAIT)
    late = loop.pause(True)
    go_on.set()
    with pytest.raises(HaulError, match="has ended"):
        late.result(WAIT)
