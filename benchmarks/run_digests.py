"""Digests of every array of whole runs, to show that a change of the code leaves the bits of the results alone.

    python -m benchmarks.run_digests > before.txt      # on one commit
    python -m benchmarks.run_digests | diff before.txt -  # on another: no output, no difference

Runs every shipped scenario and three random trains that use what the model has: draft gears with hysteresis, slack,
preload and stops, drawbars, grades and curves, traction, service and release, emergency, radio with jitter and loss.
A line per run: SHA-256 over all samples (every array of each), the extremes and the energy balance.
"""

from __future__ import annotations

import hashlib
import random
from typing import TYPE_CHECKING

import numpy as np

from haul_ros.resources import shipped_scenarios
from haul_ros.scenario import load_scenario, load_scenario_text
from haul_ros.simulation.session import Session

if TYPE_CHECKING:
    from haul_ros.model.scenario import Scenario

SAMPLE = ("stroke", "stroke_rate", "coupler_force", "chainage", "speed", "brake_force", "cylinder_pressure")
EXTREMES = (
    "compression",
    "compression_time",
    "tension",
    "tension_time",
    "compression_stroke",
    "tension_stroke",
    "bottomed_time",
)
ENERGY = (
    "kinetic_start",
    "kinetic",
    "brake_work",
    "resistance_work",
    "gravity_work",
    "traction_work",
    "gear_stored",
    "gear_dissipated",
)

ENERGY = (
    "kinetic_start",
    "kinetic",
    "brake_work",
    "resistance_work",
    "gravity_work",
    "traction_work",
    "gear_stored",
    "gear_dissipated",
)
"""By name, as the others: what is added to a balance later does not change the digest."""


def digest(scenario: Scenario) -> str:
    """Run a scenario with its own commands to its end and hash all that came out, bit for bit."""
    session = Session(scenario, play_commands=True)
    found = hashlib.sha256()
    sample = session.sample()
    while True:
        found.update(sample.time_ns.to_bytes(8, "little"))
        for name in SAMPLE:
            found.update(np.ascontiguousarray(getattr(sample, name)).tobytes())
        if session.finished:
            break
        sample = session.advance()
    extremes = session.extremes()
    for name in EXTREMES:
        found.update(np.ascontiguousarray(getattr(extremes, name)).tobytes())
    energy = session.energy()
    found.update(np.array([getattr(energy, name) for name in ENERGY]).tobytes())
    return found.hexdigest()


def random_scenario(seed: int) -> Scenario:
    """A train of 20 to 80 vehicles, the same for the same seed."""
    draw = random.Random(seed)
    groups = [draw.randrange(6, 25) for _ in range(3)]
    drawbars = draw.choice([2, 3])
    gears = [
        {"slack_mm": round(draw.uniform(2.0, 20.0), 1)},
        {"slack_mm": 5, "preload_kN": round(draw.uniform(10.0, 80.0), 1)},
        {"maximum_stroke_mm": round(draw.uniform(20.0, 60.0), 1), "bottoming_stiffness_kN_per_mm": 200},
    ]
    lines = [
        f"description: random train {seed}",
        "consist:",
        "  - {vehicle: SS4, role: master}",
        f"  - {{vehicle: C80, count: {groups[0]}, coupler: G0}}",
        f"  - {{vehicle: C63, count: {groups[1]}, coupler: G1}}",
        "  - {vehicle: SS4, role: slave}",
        f"  - {{vehicle: C80, count: {drawbars * groups[2]}, drawbar_group: {drawbars}, coupler: G2}}",
        "  - {vehicle: SS4, role: slave}",
        "coupler: MT-2",
        f"brakes: {draw.choice(['paper_set_a', 'paper_set_b', 'realistic_120'])}",
        f"initial_speed_kmh: {draw.choice([0, 20, 45, 70])}",
        f"time_step_ms: {draw.choice([0.5, 1, 2])}",
        "max_duration_s: 90",
        "track:",
        f"  grades: [{{from_m: -300, grade_permille: {draw.uniform(-8, 8):.2f}}}, {{from_m: 150, grade_permille: -4}}]",
        f"  curves: [{{from_m: 20, to_m: 260, radius_m: {draw.randrange(300, 900)}}}]",
        f"radio: {{seed: {seed}, default: {{delay_s: 0.7, jitter_s: 0.4, loss_probability: 0.1}}}}",
        "commands:",
        "  - {at_s: 0, locomotive: master, traction_kN: 300}",
        f"  - {{at_s: {draw.uniform(5, 15):.3f}, locomotive: master, brake: {draw.uniform(0.2, 0.6):.2f}}}",
        f"  - {{at_s: {draw.uniform(20, 30):.3f}, locomotive: slave_1, brake: 0.9}}",
        "  - {at_s: 35, locomotive: master, brake: 0}",
        "  - {at_s: 45, locomotive: master, brake: 0.4}",
        f"  - {{at_s: {draw.uniform(50, 60):.4f}, locomotive: master, emergency: true}}",
        "couplers:",
    ]
    for number, gear in enumerate(gears):
        loading = round(draw.uniform(8.0, 40.0), 1)
        entry = {
            "loading_stiffness_kN_per_mm": loading,
            "unloading_stiffness_kN_per_mm": round(loading * draw.uniform(0.2, 1.0), 2),
            "transition_speed_mps": round(draw.uniform(0.005, 0.1), 4),
            **gear,
        }
        values = ", ".join(f"{key}: {value}" for key, value in entry.items())
        lines.append(f"  G{number}: {{{values}, source: random, standing: assumed}}")
    return load_scenario_text("\n".join(lines) + "\n", f"random_{seed}")


def main() -> None:
    """Print a line per run."""
    scenarios = [load_scenario(name) for name in shipped_scenarios()] + [random_scenario(seed) for seed in (1, 2, 3)]
    for scenario in scenarios:
        print(f"{scenario.name:32} {digest(scenario)}", flush=True)


if __name__ == "__main__":
    main()
