"""Conversions between the units of files, tables and plots and the SI units used inside."""

from __future__ import annotations

GRAVITY = 9.81
"""Acceleration of free fall [m/s^2], the value used with TB/T 1407-1998."""

NS_PER_S = 1_000_000_000


def kmh_to_mps(speed_kmh: float) -> float:
    """Speed [km/h] to [m/s]."""
    return speed_kmh / 3.6


def mps_to_kmh(speed: float) -> float:
    """Speed [m/s] to [km/h]."""
    return speed * 3.6


def seconds_to_ns(seconds: float) -> int:
    """Time [s] to whole nanoseconds, rounded to nearest."""
    return round(seconds * NS_PER_S)
