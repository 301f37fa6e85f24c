"""The vibration study: natural frequencies of differently coupled trains; nothing is simulated."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from haul_ros.analysis.tables import Table
from haul_ros.physics.modal import Modes, natural_modes
from haul_ros.studies.claims import Claim
from haul_ros.studies.sweep import Sweep

SHOWN = "30 kN/mm"
"""The train whose modes are drawn, and which the others are compared with: paper set B."""


def solve(sweep: Sweep) -> dict[str, Modes]:
    """Modes of every case by name."""
    return {case.name: natural_modes(case.load().consist) for case in sweep.cases()}


def frequency_table(modes: Mapping[str, Modes]) -> Table:
    """A row per mode, a column of frequencies per train; a train of fewer masses has fewer modes (None)."""
    longest = max(len(found.frequencies) for found in modes.values())
    return {
        "mode": list(range(longest)),
        **{
            f"{name} [Hz]": [*found.frequencies.tolist(), *[None] * (longest - len(found.frequencies))]
            for name, found in modes.items()
        },
    }


def shape_table(modes: Modes, count: int = 5) -> Table:
    """A row per vehicle, a column per mode after the first (the whole train), largest displacement 1."""
    n = modes.shapes.shape[1]
    columns = {
        f"mode_{number}": (modes.shapes[number] / np.abs(modes.shapes[number]).max()).tolist()
        for number in range(1, min(count + 1, len(modes.frequencies)))
    }
    return {"vehicle": list(range(1, n + 1)), **columns}


def judge(modes: Mapping[str, Modes]) -> list[Claim]:
    """Lower stiffness, or larger vibrating masses, lower the frequencies."""
    return [
        _all("lower stiffness lowers", modes, "20 kN/mm", -1.0),
        _all("higher stiffness raises", modes, "40 kN/mm", 1.0),
        _all("heavier wagons lower", modes, "30 kN/mm, wagons of 120 t", -1.0),
        *(_larger_masses(modes, name) for name in ("30 kN/mm, pairs", "30 kN/mm, threes")),
    ]


def _all(text: str, modes: Mapping[str, Modes], name: str, sign: float) -> Claim:
    """All frequencies go the way of the sign, compared with the train shown."""
    ratios = modes[name].frequencies[1:] / modes[SHOWN].frequencies[1:]
    found = f"by a factor of {ratios.min():.4f} to {ratios.max():.4f}"
    return Claim(f"{text} all frequencies ({SHOWN} to {name})", bool((sign * (ratios - 1.0) > 0.0).all()), found)


def _larger_masses(modes: Mapping[str, Modes], name: str) -> Claim:
    """The highest mode, masses against one another, and the lowest, the train as a bar: they go different ways."""
    joined, single = modes[name].frequencies, modes[SHOWN].frequencies
    highest, lowest = joined[-1] / single[-1], joined[1] / single[1]
    found = (
        f"highest {single[-1]:.3f} to {joined[-1]:.3f} Hz (factor {highest:.3f}); but there are fewer springs, and the "
        f"lowest goes from {single[1]:.4f} to {joined[1]:.4f} Hz (factor {lowest:.3f})"
    )
    group = name.rpartition(", ")[2]
    return Claim(
        f"larger masses by rigid arms (wagons in {group}) lower the highest frequency", bool(highest < 1.0), found
    )
