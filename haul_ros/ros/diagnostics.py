"""State of the node as diagnostic statuses: what is worth a warning, and the figures behind it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from haul_ros.messages.encoder import DiagnosticStatus
from haul_ros.recording.writer import RecorderStatus
from haul_ros.ros.timing import LoopTiming
from haul_ros.simulation.session import SessionStatus

OK, WARN, ERROR = 0, 1, 2


@dataclass(frozen=True, slots=True)
class RunReport:
    """What the diagnostics are made of; counts are since the start of the run, ``recorder`` None: no recording.

    ``node`` is its full name, ``scenario`` the name of what it runs. ``replaced`` requests, since the start of the
    node, were replaced by newer ones before they took effect.
    """

    node: str
    scenario: str
    time: float
    paused: bool
    timing: LoopTiming
    session: SessionStatus
    accepted: int
    rejected: int
    replaced: int
    recorder: RecorderStatus | None


def starting(node: str, scenario: str, what: str) -> DiagnosticStatus:
    """The status of pacing of a node that does not simulate yet, and what it does instead."""
    return DiagnosticStatus(OK, _name(node, "pacing"), f"starting: {what}", scenario, {})


def statuses(report: RunReport) -> tuple[DiagnosticStatus, ...]:
    """One status each for pacing, solver, radio, commands and recorder, named as diagnostic_updater names them."""
    parts = (_pacing(report), _solver(report), _radio(report), _commands(report), _recorder(report.recorder))
    return tuple(replace(part, name=_name(report.node, part.name), hardware_id=report.scenario) for part in parts)


def _name(node: str, part: str) -> str:
    return f"{node.lstrip('/')}: {part}"


def _status(level: int, part: str, message: str, values: Mapping[str, object]) -> DiagnosticStatus:
    return DiagnosticStatus(level, part, message, "", {key: str(value) for key, value in values.items()})


def _pacing(report: RunReport) -> DiagnosticStatus:
    timing = report.timing
    values = {
        "simulation time [s]": f"{report.time:.3f}",
        "real-time factor": f"{timing.real_time_factor:.3f}",
        "step time mean [us]": f"{timing.step_time_mean * 1e6:.2f}",
        "step time max [us]": f"{timing.step_time_max * 1e6:.2f}",
        "lateness max [ms]": f"{timing.lateness_max * 1e3:.3f}",
        "overruns": timing.overruns,
        "missed periods": timing.missed_periods,
    }
    if timing.missed_now:
        return _status(WARN, "pacing", f"too slow: {timing.missed_now} periods missed", values)
    return _status(OK, "pacing", "paused" if report.paused else "running", values)


def _solver(report: RunReport) -> DiagnosticStatus:
    solver = report.session.solver
    values = {
        "steps": solver.steps,
        "Newton iterations mean": f"{solver.newton_iterations_mean:.3f}",
        "Newton iterations max": solver.newton_iterations_max,
        "divided steps": solver.divided_steps,
        "fallback steps": solver.fallback_steps,
        "unconverged steps": solver.unconverged_steps,
    }
    if solver.unconverged_steps:
        return _status(ERROR, "solver", f"{solver.unconverged_steps} steps did not converge", values)
    return _status(OK, "solver", "every step converged", values)


def _radio(report: RunReport) -> DiagnosticStatus:
    values: dict[str, object] = {}
    links = report.session.radio
    for slave, link in links.items():
        values |= {
            f"{slave} connected": link.connected,
            f"{slave} delay [s]": link.delay,
            f"{slave} sent": link.sent,
            f"{slave} lost": link.lost,
            f"{slave} retried": link.retried,
            f"{slave} given up": link.given_up,
            f"{slave} duplicates": link.duplicates,
            f"{slave} out of order": link.out_of_order,
        }
    cut = [slave for slave, link in links.items() if not link.connected]
    return _status(WARN if cut else OK, "radio", f"no link to {', '.join(cut)}" if cut else "all links up", values)


def _commands(report: RunReport) -> DiagnosticStatus:
    values = {"accepted": report.accepted, "rejected": report.rejected, "replaced by newer ones": report.replaced}
    if report.rejected:
        return _status(WARN, "commands", f"{report.rejected} commands rejected", values)
    return _status(OK, "commands", "every command accepted", values)


def _recorder(status: RecorderStatus | None) -> DiagnosticStatus:
    if status is None:
        return _status(OK, "recorder", "no recording", {})
    values = {"written": status.written, "dropped": status.dropped, "bytes": status.bytes}
    if status.failure is not None:
        return _status(ERROR, "recorder", status.failure, values)
    if status.dropped:
        return _status(WARN, "recorder", f"{status.dropped} messages dropped", values)
    return _status(OK, "recorder", "recording", values)
