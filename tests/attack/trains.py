"""Attacks by commands at random and by trains that nobody builds."""

from __future__ import annotations

import copy
import math
import random
from pathlib import Path
from typing import Any

import numpy as np

from haul_ros.errors import CommandError, ScenarioError
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.radio import RadioLinkChange
from haul_ros.model.request import TimedRequest
from haul_ros.model.sample import Sample
from haul_ros.scenario import load_scenario, load_scenario_text
from haul_ros.scenario.yaml_file import dump_yaml
from haul_ros.simulation.session import Session
from tests.attack import nasty
from tests.attack.harness import Found, Outcome


def _check(session: Session, sample: Sample) -> None:
    for name in ("speed", "chainage", "coupler_force", "stroke", "stroke_rate", "brake_force", "cylinder_pressure"):
        if not np.isfinite(getattr(sample, name)).all():
            raise Found(f"{name} is not finite at {session.time:.3f} s")
    for pressure in (sample.pipe_pressure, sample.auxiliary_pressure):
        if pressure is not None and not ((pressure > -20e3) & (pressure < 1.1e6)).all():
            raise Found(f"a pressure of the brake cannot be at {session.time:.3f} s: {pressure}")
    fault, unconverged = session.energy().fault, session.status().solver.unconverged_steps
    if fault and not unconverged:  # of unconverged steps the user is told
        raise Found(f"energy: {fault}")


def messages(rng: random.Random, folder: Path) -> Outcome:
    """Commands and links at random, good and bad: nothing but refusals, the same again bit for bit."""
    brakes = rng.choice(("paper_set_b", "realistic_120", "pneumatic", "pneumatic_uic", "pneumatic_aar"))
    scenario = load_scenario(
        "daqin_1_1_0", {"commands": [], "consist.1.count": 12, "initial_speed_kmh": 40, "brakes": brakes}
    )
    session = Session(scenario)
    refused = 0
    for _ in range(rng.randint(3, 15)):
        for _ in range(rng.choice((0, 1, 1, 3, 20))):
            try:
                session.request(_request(rng))
            except CommandError:
                refused += 1
        session.advance(rng.choice((1, 20, 77, 500)))
        _check(session, session.sample())
    requests = [entry for entry in session.take_log().entries if isinstance(entry, TimedRequest)]
    again = Session(scenario, requests=requests[len(scenario.radio) :])
    while again.step < session.step:
        again.advance(min(rng.choice((1, 13, 400)), session.step - again.step))
    if again.sample().coupler_force.tobytes() != session.sample().coupler_force.tobytes():
        raise Found("the same requests give other forces")
    return Outcome.REFUSED if refused else Outcome.RAN


def _request(rng: random.Random) -> Command | RadioLinkChange:
    if rng.random() < 0.25:
        fields: list[dict[str, Any]] = [
            {"delay": abs(nasty.number(rng))},
            {"jitter": nasty.number(rng)},
            {"loss_probability": rng.random()},
            {"connected": rng.random() < 0.5},
            {"jitter_law": rng.choice(("uniform", "exponential", "normal", "gamma", "empirical", "cauchy", ""))},
            {"retries": rng.choice((0, 1, 16, 17, -1))},
            {"retry_interval": nasty.number(rng)},
            {"duplicate_probability": rng.random()},
            {"in_order": rng.random() < 0.5},
            {"fails": rng.choice(("none", "to_slave", "from_slave", "both"))},
            {"burst_length": nasty.number(rng)},
            {"burst_spacing": nasty.number(rng)},
        ]
        return RadioLinkChange(rng.choice(("slave_1", "slave_1", "slave_7")), **rng.choice(fields))
    locomotive = rng.choice(("master", "slave_1", "slave_1", "", "slave_7"))
    kind = rng.choice(list(CommandKind))
    value = nasty.number(rng) if rng.random() < 0.3 else rng.choice((0.0, 1.0, rng.random(), rng.random() * 600e3))
    return Command(locomotive, kind, value)


TRAIN: dict[str, Any] = {
    "consist": [{"vehicle": "SS4", "role": "master"}, {"vehicle": "wagon", "count": 10}],
    "coupler": "gear",
    "brakes": "paper_set_b",
    "initial_speed_kmh": 60,
    "max_duration_s": 60,
    "vehicles": {},
    "couplers": {},
}


def extreme_train(rng: random.Random) -> dict[str, Any]:
    """Of 1 to 5000 vehicles, masses and stiffness over six decades, time steps of 0.1 to 20 ms."""
    data = copy.deepcopy(TRAIN)
    most = rng.choice((2, 5, 20, 100)) if rng.random() < 0.97 else 4000
    data["consist"] = [{"vehicle": "SS4", "role": "master"}]
    for name in ("a", "b", "c")[: rng.randint(0, 3)]:
        data["vehicles"][name] = {
            "source": "none", "standing": "assumed", "mass_t": min(1000.0, 10.0 ** rng.uniform(-3, 3)),
            "length_m": rng.uniform(1, 30), "resistance": "wagon_loaded", "shoes": rng.randint(1, 16),
            "shoe_force_kN": rng.choice((0, rng.uniform(1, 40))), "brake_shoe": "high_friction_composite",
            "cylinder_pressure_kPa": rng.uniform(100, 500),
        }  # fmt: skip
        count = min(2000, rng.randint(1, most))
        data["consist"].append({"vehicle": name, "count": count})
        if count % 2 == 0 and rng.random() < 0.2:
            data["consist"][-1]["drawbar_group"] = 2
    stiffness = 10.0 ** rng.uniform(-2, 4)
    data["couplers"]["gear"] = {
        "source": "none", "standing": "assumed", "loading_stiffness_kN_per_mm": stiffness,
        "unloading_stiffness_kN_per_mm": stiffness * rng.uniform(0, 1.0), "maximum_stroke_mm": rng.uniform(1, 200),
        "transition_speed_mps": 10.0 ** rng.uniform(-4, 0),
        "bottoming_stiffness_kN_per_mm": 10.0 ** rng.uniform(-1, 5), "slack_mm": rng.choice((0, rng.uniform(0, 100))),
    }  # fmt: skip
    data["time_step_ms"] = rng.choice((0.1, 0.2, 0.5, 1, 2, 5, 10, 20))
    data["initial_speed_kmh"] = rng.choice((0, 5, 60, 200))
    data["track"] = {"grades": [{"from_m": 0, "grade_permille": rng.uniform(-30, 30)}]}
    data["commands"] = [{"at_s": rng.uniform(0, 0.5), "locomotive": "master", "emergency": True}]
    return data


def numerics(rng: random.Random, folder: Path) -> Outcome:
    """A train that nobody builds runs soundly, or is refused in a line."""
    data = extreme_train(rng)
    try:
        scenario = load_scenario_text(dump_yaml(data), "train")
    except ScenarioError:
        return Outcome.REFUSED
    session = Session(scenario, play_commands=True)
    vehicles = len(scenario.consist.vehicles)
    steps = max(20, min(2000, 60_000 // vehicles))
    fastest = abs(scenario.initial_speed)
    for _ in range(4):
        sample = session.advance(steps // 4)
        _check(session, sample)
    if session.status().solver.unconverged_steps or session.energy().fault:
        return Outcome.REFUSED  # told at the end of a run, in so many words
    # no vehicle is faster than the fall along the line makes the train, but for the swings of its draft gears
    gained = 2.0 * 9.81 * 0.03 * abs(session.travelled) + 1.0
    masses = np.array([vehicle.mass for vehicle in scenario.consist.vehicles])
    mean = math.sqrt(float((masses * sample.speed**2).sum() / masses.sum()))
    if mean**2 > fastest**2 + 2.0 * gained:
        raise Found(f"from {fastest:.3f} m/s to {mean:.3f} m/s: {dump_yaml(data)}")
    return Outcome.RAN
