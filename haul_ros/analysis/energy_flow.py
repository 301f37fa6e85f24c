"""Energies of a train from samples: what brakes, resistance, grades, traction and draft gears took and gave.

Works are sums of the mean of two samples' forces times the way between them, so they are as exact as samples are
dense; `haul_ros.physics.energy` sums up every time step instead.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haul_ros.model.consist import Consist
from haul_ros.model.sample import FloatArray
from haul_ros.model.track import Track
from haul_ros.physics.assembly import CURVE_RESISTANCE
from haul_ros.physics.hinges import stored_energy
from haul_ros.units import GRAVITY


@dataclass(frozen=True, slots=True)
class SampledEnergy:
    """Energies [J] from the first sample to the last; see `haul_ros.physics.energy.EnergyBalance` for the names."""

    kinetic_start: float
    kinetic: float
    brake_work: float
    resistance_work: float
    gravity_work: float
    traction_work: float
    electric_brake_work: float
    gear_stored: float
    gear_dissipated: float

    @property
    def imbalance(self) -> float:
        """Energy that seems to have appeared [J]: what the samples do not show of the way between them."""
        taken = self.brake_work + self.electric_brake_work + self.resistance_work + self.gear_stored
        return self.kinetic + taken + self.gear_dissipated - self.kinetic_start - self.gravity_work - self.traction_work

    @property
    def relative_imbalance(self) -> float:
        """Over the initial kinetic energy and all work given to the train."""
        given = self.kinetic_start + abs(self.gravity_work) + self.traction_work
        return self.imbalance / given if given > 0.0 else 0.0


def work(force: FloatArray, way: FloatArray) -> FloatArray:
    """Work (k,) [J] of forces (n, k) [N] along ways (n, k) [m]: ``sum of (F0 + F1)/2 (x1 - x0)``."""
    return np.asarray(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(way, axis=0), axis=0))


class GearWork:
    """Work of k draft gears, taken piece by piece.

    ``taken`` (k,) [J] is force times stroke, compression and tension alike: what a gear took up less what it gave back,
    which is what it dissipated if its stroke ends as it began.
    """

    def __init__(self, couplers: int) -> None:
        self.taken = np.zeros(couplers)
        self.first_stroke: FloatArray | None = None
        self._last = np.empty((0, couplers)), np.empty((0, couplers))

    @property
    def last_stroke(self) -> FloatArray:
        """Of the newest sample (k,) [m]."""
        newest: FloatArray = self._last[1][0]
        return newest

    def add(self, force: FloatArray, stroke: FloatArray) -> None:
        """The next samples (m, k) [N], [m]."""
        if not len(force):
            return
        if self.first_stroke is None:
            self.first_stroke = stroke[0].copy()
        pairs = zip(self._last, (force, stroke), strict=True)
        forces, strokes = (np.concatenate(pair) for pair in pairs)
        self.taken += work(forces, strokes)
        self._last = force[-1:].copy(), stroke[-1:].copy()

    def stored(self, consist: Consist) -> FloatArray:
        """What each gear holds at the last sample beyond what it held at the first (k,) [J], by its curves."""
        if self.first_stroke is None:
            return np.zeros(len(self.taken))
        ends = zip(consist.couplers, self.first_stroke, self.last_stroke, strict=True)
        return np.array(
            [stored_energy(gear, float(b)) - stored_energy(gear, float(a)) if gear else 0.0 for gear, a, b in ends]
        )


class TrainWork:
    """Energies of a train on a line, taken piece by piece."""

    def __init__(self, consist: Consist, track: Track) -> None:
        self._consist = consist
        self._height, self._turned = Height(track), track.curves
        self._mass = np.array([vehicle.mass for vehicle in consist.vehicles])
        laws = [vehicle.resistance for vehicle in consist.vehicles]
        self._constant, self._linear, self._quadratic, self._lowest = np.array(
            [(law.constant, law.linear, law.quadratic, law.minimum_speed) for law in laws]
        ).T
        vehicles = len(consist.vehicles)
        self._brakes, self._resistance = np.zeros(vehicles), np.zeros(vehicles)
        self._traction = self._electric = 0.0
        self._first: tuple[FloatArray, FloatArray] | None = None
        self._last = [np.empty((0, vehicles)) for _ in range(4)]

    def add(self, chainage: FloatArray, speed: FloatArray, brake_force: FloatArray, effort: FloatArray) -> None:
        """The next samples (m, n_vehicles) [m], [m/s], [N]; ``effort`` [N] is tractive, negative: electric brake."""
        if not len(speed):
            return
        if self._first is None:
            self._first = chainage[0].copy(), speed[0].copy()
        pairs = zip(self._last, (chainage, speed, brake_force, effort), strict=True)
        chainage, speed, brake_force, effort = (np.concatenate(pair) for pair in pairs)
        self._brakes += work(brake_force, chainage)
        self._resistance += work(self._resistance_force(chainage, speed), chainage)
        if effort.any():
            of_effort = 0.5 * (effort[1:] + effort[:-1]) * np.diff(chainage, axis=0)
            self._traction += float(of_effort[of_effort > 0.0].sum())
            self._electric -= float(of_effort[of_effort < 0.0].sum())
        self._last = [array[-1:].copy() for array in (chainage, speed, brake_force, effort)]

    def energy(self, gears: GearWork) -> SampledEnergy:
        """With the work of the draft gears over the same samples, of which there is at least one.

        Raises
        ------
        ValueError
            There was none.
        """
        if self._first is None:
            raise ValueError("no samples")
        (chainage, speed), (last_chainage, last_speed) = self._first, (self._last[0][0], self._last[1][0])
        lifted = self._height.at(last_chainage) - self._height.at(chainage)
        stored = float(gears.stored(self._consist).sum())
        return SampledEnergy(
            kinetic_start=float(self._mass @ speed**2) / 2.0,
            kinetic=float(self._mass @ last_speed**2) / 2.0,
            brake_work=float(self._brakes.sum()),
            resistance_work=float(self._resistance.sum()),
            gravity_work=0.0 - float(self._mass @ lifted) * GRAVITY,  # not -0 on the level
            traction_work=self._traction,
            electric_brake_work=self._electric,
            gear_stored=stored,
            gear_dissipated=float(gears.taken.sum()) - stored,
        )

    def _resistance_force(self, chainage: FloatArray, speed: FloatArray) -> FloatArray:
        """Against forward motion [N], by the law of moving vehicles: what holds a standing one does no work."""
        v = np.maximum(np.abs(speed), self._lowest)
        specific = self._constant + (self._linear + self._quadratic * v) * v
        if self._turned:
            starts = np.array([start for start, _ in self._turned])
            curvature = np.array([0.0, *(value for _, value in self._turned)])
            specific = specific + CURVE_RESISTANCE * curvature[np.searchsorted(starts, chainage, side="right")]
        return np.asarray(np.sign(speed) * specific * self._mass * GRAVITY)


class Height:
    """Height of a line by chainage, 0 before its first grade; every change of grade is a ramp, as in `Track`."""

    def __init__(self, track: Track) -> None:
        changes = track.grade_changes
        self._at = np.array([chainage for chainage, _ in changes])
        self._change = np.diff([grade for _, grade in changes], prepend=0.0)
        self._ramp = track.grade_ramp

    def at(self, chainage: FloatArray) -> FloatArray:
        """Heights [m] at chainages (k,) [m]."""
        behind = chainage[:, None] - self._at
        if self._ramp > 0.0:
            on = np.clip(behind + self._ramp / 2.0, 0.0, self._ramp)  # parabola on the ramp, straight behind it
            risen = on**2 / (2.0 * self._ramp) + np.maximum(0.0, behind - self._ramp / 2.0)
        else:
            risen = np.maximum(0.0, behind)
        return np.asarray(risen @ self._change)
