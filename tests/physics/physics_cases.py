"""Small trains with properties that can be calculated by hand, and the laws in plain Python to compare with."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from haul_ros.model.brake_system import BrakeSystem, BuildUp, WaveSpeeds
from haul_ros.model.consist import Consist, Locomotive
from haul_ros.model.draft_gear import Curve, DraftGear, SideCurves
from haul_ros.model.sample import Sample
from haul_ros.model.track import Track
from haul_ros.model.vehicle import RunningResistance, ShoeFriction, VehicleType
from haul_ros.physics.train_model import TrainModel

G = 9.81

FREE_ROLLING = RunningResistance(constant=0.0, linear=0.0, quadratic=0.0, starting=0.0)

# TB/T 1407-1998, loaded wagon on roller bearings: 0.92 + 0.0048 v + 0.000125 v^2 N/kN (v in km/h), 3.5 N/kN to start.
WAGON_RESISTANCE = RunningResistance(
    constant=0.92e-3, linear=0.0048e-3 * 3.6, quadratic=0.000125e-3 * 3.6**2, starting=3.5e-3
)

# A shoe whose friction coefficient is 0.3 whatever the force and the speed.
CONSTANT_SHOE = ShoeFriction(scale=0.3, k_offset=1.0, k_gain=1.0, n_slope=0.0, n_offset=1.0, d_slope=0.0, d_offset=1.0)

# MT-2 gear: 83 mm, 2.27 MN, gives back a fifth (shape of the curves assumed).
MT2 = SideCurves(
    ((0.0, 0.0), (0.02, 140e3), (0.04, 370e3), (0.06, 820e3), (0.075, 1.5e6), (0.083, 2.27e6)),
    ((0.0, 0.0), (0.02, 28e3), (0.04, 74e3), (0.06, 164e3), (0.075, 300e3), (0.083, 454e3)),
)


def wagon_resistance(speed: float) -> float:
    """Specific resistance [N/N] of a loaded wagon at a speed [m/s], from the formula in km/h."""
    kmh = max(abs(speed) * 3.6, 10.0)
    return (0.92 + 0.0048 * kmh + 0.000125 * kmh**2) / 1e3


def linear(stiffness: float, preload: float = 0.0) -> Curve:
    return (0.0, preload), (1.0, preload + stiffness)


def linear_gear(loading: float = 3e7, unloading: float = 3e7, transition_speed: float = 0.01) -> DraftGear:
    """Gear with stiffnesses [N/m] that are the same in buff and draft."""
    side = SideCurves(linear(loading), linear(unloading))
    return DraftGear("linear", side, side, transition_speed)


def slack_gear(gear: DraftGear, slack: float) -> DraftGear:
    """The same gear with free play [m]."""
    return replace(gear, slack=slack)


def vehicle(
    mass: float = 100e3,
    *,
    length: float = 12.0,
    resistance: RunningResistance = FREE_ROLLING,
    shoes: int = 8,
    shoe_force: float = 25e3,
    friction: ShoeFriction = CONSTANT_SHOE,
    tractive_effort: float = 0.0,
) -> VehicleType:
    return VehicleType("V", mass, length, resistance, shoes, shoe_force, friction, 360e3, tractive_effort)


def train_of(vehicles: Sequence[VehicleType], couplers: DraftGear | Iterable[DraftGear | None] | None) -> Consist:
    """Train with one draft gear everywhere, or with the couplers given, and a locomotive at the head."""
    if couplers is None or isinstance(couplers, DraftGear):
        couplers = [couplers] * (len(vehicles) - 1)
    return Consist(tuple(vehicles), tuple(couplers), (Locomotive("master", 0),))


def brake_system(
    *,
    wave: float = 250.0,
    full_time: float = 2.0,
    knee: float = 1.0,
    knee_time: float | None = None,
    service: float = 200.0,
    release: float = 150.0,
    full_service: float = 0.8,
    service_time: float = 8.0,
    release_time: float = 10.0,
    follows_pressure: bool = False,
) -> BrakeSystem:
    build_up = BuildUp(
        knee, full_time if knee_time is None else knee_time, full_time, service_time, release_time, follows_pressure
    )
    return BrakeSystem(WaveSpeeds(wave, service, release), build_up, full_service)


def model(
    consist: Consist,
    initial_speed: ArrayLike = 0.0,
    *,
    brakes: BrakeSystem | None = None,
    track: Track | None = None,
    time_step: float = 1e-3,
) -> TrainModel:
    return TrainModel(consist, brakes or brake_system(), track, initial_speed=initial_speed, time_step=time_step)


def history(train: TrainModel, n_steps: int, every: int = 1) -> list[Sample]:
    """The state now and after every so many steps."""
    samples = [train.sample()]
    for _ in range(n_steps // every):
        train.advance(every)
        samples.append(train.sample())
    return samples


def assert_converged(train: TrainModel) -> None:
    statistics = train.statistics()
    assert statistics.fallback_steps == 0
    assert statistics.unconverged_steps == 0


def curve_force(curve: Curve, stroke: float) -> float:
    """Force [N] of a table at a stroke [m] >= 0, straight between its points and beyond the last."""
    for (x0, f0), (x1, f1) in pairwise(curve):
        if stroke <= x1:
            return f0 + (f1 - f0) * (stroke - x0) / (x1 - x0)
    return f0 + (f1 - f0) * (stroke - x0) / (x1 - x0)


def side_force(gear: DraftGear, curve: Curve, depth: float) -> float:
    """Force [N] of a loading or unloading curve at a magnitude of the stroke [m], by its definition.

    Slack comes off the depth; a preload is taken up on the solid stiffness, so where the table asks for
    more than the solid part can have given, in loading or in unloading, the solid part holds; bottoming adds to both.
    """
    x = depth - gear.slack / 2.0
    if x <= 0.0:
        return 0.0
    sides = (gear.compression, gear.tension)
    force = curve_force(curve, x)
    if any(curve in (side.loading, side.unloading) and side.loading[0][1] > 0.0 for side in sides):
        force = min(force, gear.solid_stiffness * x)
    if x > gear.maximum_stroke:
        force += gear.bottoming_stiffness * (x - gear.maximum_stroke)
    return force


def gear_force(gear: DraftGear, stroke: float, rate: float) -> float:
    """Coupler force [N] by the velocity method as physics.md section 2 writes it (paper eq. 5)."""
    sign = 1.0 if stroke >= 0.0 else -1.0
    side = gear.compression if stroke >= 0.0 else gear.tension
    fu = side_force(gear, side.loading, abs(stroke))
    fl = side_force(gear, side.unloading, abs(stroke))
    w = rate * sign
    if abs(w) >= gear.transition_speed:
        return sign * (fu if w > 0.0 else fl)
    return sign * ((fu + fl) / 2.0 + (fu - fl) / 2.0 * w / gear.transition_speed)


def gear_forces(gear: DraftGear, sample: Sample) -> NDArray[np.float64]:
    """Reference force of every coupler of a sample [N]."""
    pairs = zip(sample.stroke, sample.stroke_rate, strict=True)
    return np.array([gear_force(gear, float(s), float(w)) for s, w in pairs])
