"""What is published and recorded, from a checked document."""

from __future__ import annotations

from haul_ros.model.recording_plan import RecordingPlan, Rounding, power_of_two
from haul_ros.scenario.document import Document, KeyPath

_WHOLE = 1e-9
FINEST, COARSEST = 1e-6, 1e6
"""Least resolution above 0 and largest, in the unit of the key."""
ROUNDING_KEYS = {
    "coupler_force": ("coupler_force_N", 1.0),
    "stroke": ("stroke_mm", 1e3),
    "stroke_rate": ("stroke_rate_mm_per_s", 1e3),
    "chainage": ("chainage_mm", 1e3),
    "speed": ("speed_mm_per_s", 1e3),
    "brake_force": ("brake_force_N", 1.0),
    "pressure": ("pressure_Pa", 1.0),
}
"""Key and its units in one of SI, by quantity."""


def samples_per(document: Document, path: KeyPath, what: str) -> int:
    """How many samples go to one of something that has the rate [Hz] at a path; 1 without a rate.

    Raises
    ------
    ScenarioError
        It is no whole number of them.
    """
    sample_rate = float(document.data["sample_rate_hz"])
    entry = document.at(path[:-1])
    if path[-1] not in entry:
        return 1
    ratio = sample_rate / float(entry[path[-1]])
    if round(ratio) < 1 or abs(ratio - round(ratio)) > _WHOLE * ratio:
        problem = f"{what} takes {ratio:.9g} samples of sample_rate_hz = {sample_rate:g}"
        raise document.refusal(path, f"{problem}, must be a whole number of them")
    return round(ratio)


def recording_plan(document: Document) -> RecordingPlan:
    """Which samples are recorded, and to what resolution; the power of two not above each that is given.

    Raises
    ------
    ScenarioError
        A recorded sample does not take a whole number of published ones, or a resolution is too fine.
    """
    entry = document.data["recording"]["rounding"]
    found = {}
    for name, (key, units) in ROUNDING_KEYS.items():
        if 0.0 < entry[key] < FINEST:
            raise document.refusal(("recording", "rounding", key), f"must be 0 or at least {FINEST:g}")
        found[name] = power_of_two(entry[key] / units)
    every = samples_per(document, ("recording", "rate_hz"), "a recorded sample")
    return RecordingPlan(every=every, rounding=Rounding(**found))
