"""How well the loop keeps time: what is counted per period, and the figures of a report."""

from __future__ import annotations

from dataclasses import dataclass

from haul_ros.units import NS_PER_S


@dataclass(frozen=True, slots=True)
class LoopTiming:
    """Figures of the loop since the previous report; ``overruns`` and ``missed_periods`` since the start.

    ``step_time_mean`` and ``step_time_max`` [s] are wall time per integration step, the maximum as
    the largest mean over one period; ``lateness_max`` [s] is how long after its deadline a period
    began. In an overrun whole periods of wall time are missed: ``missed_now`` of them since the
    previous report.
    """

    real_time_factor: float
    step_time_mean: float
    step_time_max: float
    lateness_max: float
    overruns: int
    missed_periods: int
    missed_now: int


class TimingWindow:
    """Collects the timing of periods between two reports; times in [ns]."""

    def __init__(self, now_ns: int, simulation_time_ns: int) -> None:
        self.overruns = 0
        self.missed_periods = 0
        self.restart(now_ns, simulation_time_ns)

    def restart(self, now_ns: int, simulation_time_ns: int) -> None:
        """Begin a new window here; the counts since the start are kept."""
        self._began_ns = now_ns
        self._began_simulation_ns = simulation_time_ns
        self._steps = 0
        self._busy_ns = 0
        self._step_time_max = 0.0
        self._lateness_max_ns = 0
        self._missed_before = self.missed_periods

    def period(self, steps: int, busy_ns: int, lateness_ns: int, missed: int) -> None:
        """Count one period of ``steps`` integration steps, and the periods missed after it."""
        self._steps += steps
        self._busy_ns += busy_ns
        self._step_time_max = max(self._step_time_max, busy_ns / steps / NS_PER_S)
        self._lateness_max_ns = max(self._lateness_max_ns, lateness_ns)
        self.overruns += missed > 0
        self.missed_periods += missed

    def report(self, now_ns: int, simulation_time_ns: int) -> LoopTiming:
        """Figures of the window that ends here; the next one begins."""
        wall_ns = max(now_ns - self._began_ns, 1)
        timing = LoopTiming(
            real_time_factor=(simulation_time_ns - self._began_simulation_ns) / wall_ns,
            step_time_mean=self._busy_ns / max(self._steps, 1) / NS_PER_S,
            step_time_max=self._step_time_max,
            lateness_max=self._lateness_max_ns / NS_PER_S,
            overruns=self.overruns,
            missed_periods=self.missed_periods,
            missed_now=self.missed_periods - self._missed_before,
        )
        self.restart(now_ns, simulation_time_ns)
        return timing
