"""How short the parts of a time step have to be for the contacts that it meets.

Newmark's method is stable at any step, and draft gears create no energy at any step; but a contact that swings, or a
hysteresis that turns round, faster than the step comes out wrong. Where two masses meet as on a spring of angular
frequency omega, and where the transition between loading and unloading damps their motion at a rate lambda, the step
is done in omega / STIFF_CONTACT (SLACK_CONTACT if the gear has slack, PRELOADED_CONTACT if it has a preload) and
lambda / FAST_TRANSITION parts: a number that does not depend on the step, so that errors fall with its square. Steps
longer than usual get more parts, so that no part is longer than what LARGEST_SWING and LARGEST_DECAY allow.
"""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.blocks import Blocks, gear_parameters_of, gear_trial_of, gears_of
from haul_ros.physics.kernel.data import Floats

STIFF_CONTACT = 100.0
"""Angular frequency [rad/s] above which a contact is stiff: 100 t wagons on 500 kN/mm. At a step of 1 ms peaks of
trains with stops are then within 0.5 % of those at shorter steps (tests/physics/test_contact.py)."""

SLACK_CONTACT = 27.0
"""The same [rad/s] for gears with slack. In a row of wagons that runs in or out through it every contact decides when
the next one comes, so errors add up. Chosen: the largest error of a peak of 34 empty wagons whose contacts have 65 and
81 rad/s (tests/physics/test_contact.py) is 1.0 % at 100, 0.15 % at 50 and 0.13 % at 27, that of 26 wagons with gears of
all kinds 1.2, 0.8 and 0.2 %; a time step takes 1.4 and 2 times as long then. Contacts of 100 t wagons on less than
36 kN/mm, and those of validation_ss3_c63, 26.7 rad/s, are left whole."""

PRELOADED_CONTACT = 8.0
"""The same [rad/s] for gears with a preload. Every change of sign of a force takes such a gear through all of it,
within a step or two of 1 ms, and errors there decide when the next one comes. 100 t wagons get 16 parts while they are
on the usual 250 kN/mm."""

FAST_TRANSITION = 250.0
"""Rate [1/s] above which a transition is fast; chosen as STIFF_CONTACT is."""

LARGEST_DECAY = 0.6
"""Of a stroke rate in a part [-]; chosen as STIFF_CONTACT is."""


@inner
def _stiff_contacts(inverse_reduced_mass: Floats, largest_swing: Floats, stiffness: Floats, h: float) -> int:
    """Number of contacts that swing further in ``h`` [s] than they may.

    Where stiffness does not change on the way, its mean has half of it as slope by the stroke at the end.
    """
    count = 0
    for k in range(stiffness.shape[0]):
        limit = largest_swing[k] / h
        count += 1 if stiffness[k] * inverse_reduced_mass[k] > 0.5 * limit * limit else 0
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
    decay = min(LARGEST_DECAY, FAST_TRANSITION * time_step) / h
    stiff = _stiff_contacts(parameters.inverse_reduced_mass, parameters.largest_swing, trial.stiffness, h)
    fast = _fast_transitions(
        parameters.inverse_transition_speed,
        parameters.inverse_reduced_mass,
        gears.stroke_rate,
        trial.stroke_rate,
        trial.hysteresis,
        decay,
    )
    return stiff + fast > 0
