"""The thread that owns the simulation: served actions and paced periods, one after the other."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from queue import Empty, SimpleQueue
from time import monotonic_ns, sleep

from haul_ros.errors import CommandError, HaulError
from haul_ros.model.request import Request
from haul_ros.ros.inbox import Inbox
from haul_ros.ros.run import TrainRun
from haul_ros.ros.timing import TimingWindow
from haul_ros.simulation.pacing import next_deadline, wall_period
from haul_ros.units import NS_PER_S

REPORT_PERIOD_NS = NS_PER_S
"""Wall time between two reports."""


class LoopError(HaulError):
    """An action that the loop cannot take in its present state."""


class SimulationLoop:
    """Advances a run by a sample period at absolute deadlines of the monotonic clock.

    Its methods may be called from any thread: each puts an action into a queue, which the loop
    serves between two periods, so that it takes effect at the present simulation time. Requests go
    through an `Inbox`, so that a flood of them costs no more than one of each in a period.

    Parameters
    ----------
    run
        The run to begin with; the loop closes it.
    sample_period_ns
        Simulation time of one period [ns].
    real_time_factor
        Simulated over wall time; 0: as fast as possible.
    on_rejected
        Called with every request that could not be carried out, in the loop's thread, or that means nothing, in the
        thread of the request.
    on_end
        Called last in the loop's thread, however it ends.
    on_state
        Called in the loop's thread with ``running``, ``paused`` and ``ended`` as it becomes so.
    """

    def __init__(
        self,
        run: TrainRun,
        sample_period_ns: int,
        real_time_factor: float,
        *,
        on_rejected: Callable[[Request, CommandError], None],
        on_end: Callable[[], None],
        on_state: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.failure: Exception | None = None
        """What ended the loop, if not ``stop``."""
        self._run = run
        self._sample_period_ns = sample_period_ns
        self._real_time_factor = real_time_factor
        self._on_rejected = on_rejected
        self._on_end = on_end
        self._on_state = on_state
        self._inbox = Inbox(sample_period_ns)
        self._actions: SimpleQueue[tuple[Callable[[], str], Future[str]]] = SimpleQueue()
        self._timing = TimingWindow(monotonic_ns(), run.time_ns)
        self._deadline_ns = 0
        self._report_due_ns = 0
        self._paused = False
        self._stopping = False
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._main, name="simulation")

    def start(self) -> None:
        """Begin to simulate."""
        self._thread.start()

    def stop(self) -> None:
        """End the run, finish its recording, and wait for that; harmless when it has ended already."""
        self._ending.set()
        self._submit(self._stop)
        self._thread.join()

    def request(self, request: Request) -> Future[str]:
        """Hand over a command or a change of a radio link."""
        try:
            result, announce = self._inbox.put(request)
        except CommandError as error:
            self._on_rejected(request, error)
            result = Future()
            result.set_exception(error)
            return result
        if announce:
            self._submit(self._serve_requests)
        return result

    def set_real_time_factor(self, real_time_factor: float) -> Future[str]:
        """Change the pace."""
        return self._submit(partial(self._set_real_time_factor, real_time_factor))

    def pause(self, paused: bool) -> Future[str]:
        """Pause or go on; the result says so with the simulation time."""
        return self._submit(partial(self._pause, paused))

    def step(self) -> Future[str]:
        """Advance one sample period; LoopError unless paused. The result says so with the simulation time."""
        return self._submit(self._step)

    def reset(self, run: TrainRun) -> Future[str]:
        """Close the present run and begin another, paused if the present one is.

        The future raises RecordingError if the present recording could not be finished; the new run has begun then.
        """
        return self._submit(partial(self._reset, run))

    def _submit(self, action: Callable[[], str]) -> Future[str]:
        future: Future[str] = Future()
        self._actions.put((action, future))
        return future

    def _main(self) -> None:
        try:
            self._simulate()
        except Exception as error:
            self.failure = error
        try:
            self._run.close()
        except Exception as error:
            self.failure = self.failure or error
        self._refuse_what_is_left()
        self._on_state("ended")
        self._on_end()

    def _refuse_what_is_left(self) -> None:
        for _ in range(self._actions.qsize()):
            self._actions.get_nowait()[1].set_exception(LoopError("the simulation has ended"))
        for waiting in self._inbox.take_all():
            waiting.result.set_exception(LoopError("the simulation has ended"))

    def _simulate(self) -> None:
        self._begin()
        self._tell_state()
        self._report_due_ns = monotonic_ns() + REPORT_PERIOD_NS
        while not self._stopping:
            self._serve_until_due()
            now = monotonic_ns()
            if not self._paused and now >= self._deadline_ns and not self._stopping:
                self._advance(now)
            if now >= self._report_due_ns:
                self._report(now)

    def _serve_until_due(self) -> None:
        while (wait := self._due_ns() - monotonic_ns()) > 0 and not self._stopping:
            try:
                self._serve(*self._actions.get(timeout=wait / NS_PER_S))
            except Empty:
                return
        # Late or as fast as possible: no waiting, but what has come is served, and other threads get their turn.
        sleep(0)
        for _ in range(self._actions.qsize()):
            self._serve(*self._actions.get_nowait())
        self._serve_requests()

    def _serve_requests(self) -> str:
        for waiting in self._inbox.take(monotonic_ns()):
            self._serve(partial(self._request, waiting.request), waiting.result)
        return self._with_time("served")

    def _due_ns(self) -> int:
        due = [self._report_due_ns, self._inbox.due_ns(monotonic_ns()), None if self._paused else self._deadline_ns]
        return min(time_ns for time_ns in due if time_ns is not None)

    def _serve(self, action: Callable[[], str], future: Future[str]) -> None:
        try:
            future.set_result(action())
        except HaulError as error:
            future.set_exception(error)
        except Exception as error:
            future.set_exception(error)
            raise

    def _advance(self, now_ns: int) -> None:
        period_ns = wall_period(self._sample_period_ns, self._real_time_factor)
        lateness_ns = now_ns - self._deadline_ns if period_ns else 0
        busy_ns = self._run.advance(self._ending.is_set)
        self._inbox.next_period()
        pace = next_deadline(self._deadline_ns, monotonic_ns(), period_ns)
        self._deadline_ns = pace.deadline_ns
        self._timing.period(self._run.steps_per_sample, busy_ns, lateness_ns, pace.missed)

    def _report(self, now_ns: int) -> None:
        timing = self._timing.report(now_ns, self._run.time_ns)
        self._run.report(timing, paused=self._paused, replaced=self._inbox.replaced, refused=self._inbox.refused)
        self._report_due_ns = next_deadline(self._report_due_ns, now_ns, REPORT_PERIOD_NS, max_behind=0).deadline_ns

    def _begin(self) -> None:
        self._run.start()
        self._restart_pace()
        self._timing.restart(monotonic_ns(), self._run.time_ns)

    def _restart_pace(self) -> None:
        self._deadline_ns = monotonic_ns() + wall_period(self._sample_period_ns, self._real_time_factor)

    def _with_time(self, what: str) -> str:
        return f"{what} at {self._run.time_ns / NS_PER_S:.3f} s"

    def _stop(self) -> str:
        self._stopping = True
        return self._with_time("stopped")

    def _request(self, request: Request) -> str:
        try:
            self._run.request(request)
        except CommandError as error:
            self._on_rejected(request, error)
            raise
        return self._with_time("accepted")

    def _set_real_time_factor(self, real_time_factor: float) -> str:
        self._real_time_factor = real_time_factor
        self._restart_pace()
        return self._with_time("set")

    def _pause(self, paused: bool) -> str:
        if self._paused and not paused:
            self._restart_pace()
        self._paused = paused
        return self._with_time(self._tell_state())

    def _tell_state(self) -> str:
        state = "paused" if self._paused else "running"
        self._on_state(state)
        return state

    def _step(self) -> str:
        if not self._paused:
            raise LoopError("step is possible only while paused")
        self._run.advance(self._ending.is_set)
        self._inbox.next_period()
        return self._with_time("stepped")

    def _reset(self, run: TrainRun) -> str:
        ended, self._run = self._run, run
        try:
            ended.close()
        finally:
            self._begin()
        return self._with_time("started again")
