"""Energy balance of a run.

With gamma = 1/2 and beta = 1/4 the change of kinetic energy in a step equals the work of the mean forces over the
step identically. That of brakes, resistance, traction and gravity is summed up as force times displacement. The
energy of the draft gears comes from their own law instead: what they store is the area under their curves, from the
model of the gear and the present stroke; what they dissipate is the hysteresis over the way. So the balance closes,
to the Newton residual, only if the kernel's coupler forces are those of the law.

One gear that makes energy does not show among many that dissipate, nor a light body's energy beside that of a train.
So the work of the force that acts on the masses is summed up for every gear apart: what a gear has given, and what it
holds by its curves, is never more than what it has taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haul_ros.physics.train_model import TrainModel

_TOLERANCE = 1e-6
"""Imbalance over the energy given to a train that is more than Newton residuals and rounding add up to."""

_LEAST_ENERGY = 1.0
"""Energy [J] below which nothing is told from that."""

_AIR_TOLERANCE = 1e-9
"""Part of the air in the train that rounding does not lose in hours."""

_LEAST_GEAR_ENERGY = 1e-9
"""The same of a single draft gear [J]: rounding of strokes that only touch the end of a slack."""


@dataclass(frozen=True, slots=True)
class EnergyBalance:
    """Energies [J] since the start of a run.

    ``gear_stored`` is what the draft gears would give back if let out slowly, over what they would have at the start;
    ``gear_dissipated`` what they have turned into heat, with what those of couplers that parted in draft held then
    (`haul_ros.physics.parting`); ``gravity_work`` and ``traction_work`` were given to the train,
    ``electric_brake_work`` was taken from it as those of brakes and resistance. ``gear_excess`` is the largest part of
    all work through a single draft gear that it has given, or holds, beyond what it has taken [-]. ``air_error`` is the
    part of the air of a pneumatic brake that has come from nowhere or gone there, infinite if a pressure is none [-].
    """

    kinetic_start: float
    kinetic: float
    brake_work: float
    resistance_work: float
    gravity_work: float
    traction_work: float
    gear_stored: float
    gear_dissipated: float
    electric_brake_work: float = 0.0
    gear_excess: float = 0.0
    air_error: float = 0.0

    @property
    def imbalance(self) -> float:
        """Energy that has appeared from nowhere (or, negative, vanished) [J]."""
        braked = self.brake_work + self.electric_brake_work + self.resistance_work
        spent = braked + self.gear_stored + self.gear_dissipated
        return self.kinetic + spent - self.kinetic_start - self.gravity_work - self.traction_work

    @property
    def _given(self) -> float:
        """Energy that the train had or was given, to measure errors against [J]."""
        from_gears = max(0.0, -self.gear_stored)
        return self.kinetic_start + abs(self.gravity_work) + self.traction_work + from_gears

    @property
    def relative_imbalance(self) -> float:
        """Imbalance over the initial kinetic energy, or over all work given to a train that started at rest."""
        return self.imbalance / self._given if self._given > 0.0 else 0.0

    @property
    def fault(self) -> str | None:
        """What cannot be of a run whose steps have converged, in a few words; None if all is well."""
        if not self.air_error <= _AIR_TOLERANCE:
            return f"the air of the brake does not add up, by {self.air_error:.2g} of it"
        allowed = max(_TOLERANCE * self._given, _LEAST_ENERGY)
        if not abs(self.imbalance) <= allowed:
            return f"{self.imbalance:.3g} J have come from nowhere"
        if not self.gear_dissipated >= -allowed:
            return f"the draft gears have given {-self.gear_dissipated:.3g} J more than they took"
        if not self.gear_excess <= _TOLERANCE:
            return f"a draft gear has given more than it took, by {self.gear_excess:.2g} of all work through it"
        return None


def energy_balance(model: TrainModel) -> EnergyBalance:
    """Energy balance of a train from its start to the present time."""
    train = model.train
    vehicles, gears = train.vehicles, train.gears
    stored = model.stored_energies - model.initial_gear_energy
    excess = np.maximum(gears.given + stored - gears.taken, -gears.dissipated) - _LEAST_GEAR_ENERGY
    through = np.maximum(gears.taken + gears.given, _LEAST_GEAR_ENERGY)
    return EnergyBalance(
        kinetic_start=model.initial_kinetic_energy,
        kinetic=model.kinetic_energy,
        brake_work=float(np.sum(vehicles.brake_work)),
        resistance_work=float(np.sum(vehicles.resistance_work)),
        gravity_work=float(np.sum(vehicles.gravity_work)),
        traction_work=float(np.sum(vehicles.traction_work)),
        gear_stored=float(sum(stored)),
        gear_dissipated=float(np.sum(gears.dissipated)),
        electric_brake_work=float(np.sum(vehicles.electric_work)),
        gear_excess=float(np.max(excess / through, initial=0.0)),
        air_error=model.air_error,
    )
