"""Brake waves and the build-up of the brake after a wave has arrived."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class WaveSpeeds:
    """Speed of each kind of brake wave along the train [m/s] (paper eq. 4)."""

    emergency: float
    service: float
    release: float


@dataclass(frozen=True, slots=True)
class BuildUp:
    """How the brake cylinder follows its target; levels are fractions of emergency pressure.

    Emergency: linearly to ``knee`` in ``knee_time``, then linearly to 1 at ``full_time`` [s] after
    the wave. Service: at the rate that would reach full service in ``service_time`` [s]; release:
    at the rate that would empty the cylinder from emergency in ``release_time`` [s].
    The paper's linear law has ``knee = 1`` and ``knee_time = full_time``.

    ``friction_follows_pressure``: the friction coefficient is taken at the momentary shoe force
    (True) or, as in the paper's law, at that of the full application (False), so that the brake
    force itself rises linearly.
    """

    knee: float
    knee_time: float
    full_time: float
    service_time: float
    release_time: float
    friction_follows_pressure: bool


@dataclass(frozen=True, slots=True)
class BrakeSystem:
    """Brake pipe and valves of the whole train.

    ``full_service`` is the cylinder pressure of a full service application as a fraction of
    emergency pressure.
    """

    wave_speeds: WaveSpeeds
    build_up: BuildUp
    full_service: float
