"""Instrumented couplers, from a checked document."""

from __future__ import annotations

import math

from haul_ros.model.consist import Consist
from haul_ros.model.sensor import CouplerSensors, Transducer
from haul_ros.scenario.document import Document, KeyPath
from haul_ros.scenario.recording import samples_per


def coupler_sensors(document: Document, train: Consist) -> CouplerSensors | None:
    """The sensors of a scenario; None if it has none.

    Raises
    ------
    ScenarioError
        A coupler that the train does not have, or twice; a measurement that takes no whole number of samples; a range
        below the quantisation.
    """
    entry = document.data.get("sensors")
    if entry is None:
        return None
    seen: set[int] = set()
    for index, number in enumerate(entry["couplers"]):
        if number > len(train.couplers):
            expected = f"must be at most {len(train.couplers)}, the last coupler" if train.couplers else "there is none"
            raise document.refusal(("sensors", "couplers", index), expected)
        if number in seen:
            raise document.refusal(("sensors", "couplers", index), "must not stand there twice")
        seen.add(number)
    return CouplerSensors(
        couplers=tuple(number - 1 for number in entry["couplers"]),
        every=samples_per(document, ("sensors", "rate_hz"), "a measurement"),
        seed=int(entry.get("seed", document.data["radio"]["seed"])),
        force=_transducer(document, ("sensors", "force"), "kN", 1e3),
        stroke=_transducer(document, ("sensors", "stroke"), "mm", 1e-3) if "stroke" in entry else None,
    )


def _transducer(document: Document, path: KeyPath, unit: str, factor: float) -> Transducer:
    entry = document.at(path)
    span, step = entry.get(f"range_{unit}", math.inf), entry[f"quantisation_{unit}"]
    if span < step:
        raise document.refusal((*path, f"range_{unit}"), f"must be at least quantisation_{unit}, {step:g}")
    return Transducer(noise=entry[f"noise_{unit}"] * factor, quantisation=step * factor, span=span * factor)
