"""How short the parts of a time step have to be for the contacts that it meets.

Newmark's method is stable at any step, and draft gears create no energy at any step; but a contact that swings, or a
hysteresis that turns round, faster than the step comes out wrong. Where two masses meet as on a spring of angular
frequency omega, and where the transition between loading and unloading damps their motion at a rate lambda, the step
is done in omega / STIFF_CONTACT (omega / PRELOADED_CONTACT if the gear has a preload) and lambda / FAST_TRANSITION
parts: a number that does not depend on the step, so that errors fall with its square. Steps longer than usual get more
parts, so that no part is longer than what LARGEST_SWING and LARGEST_DECAY allow.
"""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.blocks import Blocks, gear_parameters_of, gear_trial_of, gears_of
from haul_ros.physics.kernel.data import LARGEST_SWING, Floats

STIFF_CONTACT = 100.0
"""Angular frequency [rad/s] above which a contact is stiff: 100 t wagons on 500 kN/mm. At a step of 1 ms peaks of
trains with slack and stops are then within 0.5 % of those at shorter steps (tests/physics/test_contact.py); in long
rows of empty wagons with slack, whose contacts stay just below it, single ones come out wrong by up to 2 %."""

PRELOADED_CONTACT = 8.0
"""The same [rad/s] for gears with a preload. Every change of sign of a force takes such a gear through all of it,
within a step or two of 1 ms, and errors there decide when the next one comes. 100 t wagons get 16 parts while they are
on the usual 250 kN/mm."""

FAST_TRANSITION = 250.0
"""Rate [1/s] above which a transition is fast; chosen as STIFF_CONTACT is."""

LARGEST_DECAY = 0.6
"""Of a stroke rate in a part [-]; chosen as STIFF_CONTACT is."""


@inner
def _stiff_contacts(
    inverse_reduced_mass: Floats, preloaded: Floats, stiffness: Floats, limit: float, preloaded_limit: float
) -> int:
    """Number of contacts whose angular frequency is above a limit, or another one for gears with a preload.

    Where stiffness does not change on the way, its mean has half of it as slope by the stroke at the end.
    """
    count = 0
    most, most_preloaded = 0.5 * limit * limit, 0.5 * preloaded_limit * preloaded_limit
    for k in range(stiffness.shape[0]):
        allowed = most_preloaded if preloaded[k] != 0.0 else most
        count += 1 if stiffness[k] * inverse_reduced_mass[k] > allowed else 0
    return count


@inner
def _fast_transitions(
    inverse_speed: Floats,
    inverse_reduced_mass: Floats,
    rate: Floats,
    new_rate: Floats,
    hysteresis: Floats,
    limit: float,
) -> int:
    """Number of transitions that are gone through at a rate above a limit.

    They are of no account where the stroke rate hardly changes.
    """
    count = 0
    for k in range(rate.shape[0]):
        start = min(1.0, max(-1.0, rate[k] * inverse_speed[k]))
        end = min(1.0, max(-1.0, new_rate[k] * inverse_speed[k]))
        through = min(1.0, abs(end - start))
        count += 1 if hysteresis[k] * inverse_speed[k] * inverse_reduced_mass[k] * through > limit else 0
    return count


@inner
def too_long(blocks: Blocks, h: float) -> bool:
    """Whether a part of ``h`` [s] of a time step is too long for the contacts that it meets, once it is solved."""
    time_step = blocks.settings[0].time_step
    parameters, gears, trial = (
        gear_parameters_of(blocks.gear_parameters),
        gears_of(blocks.gears),
        gear_trial_of(blocks.gears),
    )
    swing = min(LARGEST_SWING, STIFF_CONTACT * time_step) / h
    decay = min(LARGEST_DECAY, FAST_TRANSITION * time_step) / h
    preloaded_swing = min(LARGEST_SWING, PRELOADED_CONTACT * time_step) / h
    stiff = _stiff_contacts(
        parameters.inverse_reduced_mass, parameters.preloaded, trial.stiffness, swing, preloaded_swing
    )
    fast = _fast_transitions(
        parameters.inverse_transition_speed,
        parameters.inverse_reduced_mass,
        gears.stroke_rate,
        trial.stroke_rate,
        trial.hysteresis,
        decay,
    )
    return stiff + fast > 0
