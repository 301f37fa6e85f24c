"""Natural frequencies against the formula of the uniform free chain, and against the moving train."""

from __future__ import annotations

import numpy as np
import pytest

from haul_ros.model.draft_gear import DraftGear, SideCurves
from haul_ros.physics.modal import natural_modes, stiffness_about_rest, stiffness_matrix
from tests.physics.physics_cases import linear_gear, model, train_of, vehicle

MASS, STIFFNESS = 100e3, 3e7


def chain(n: int, mass: float = MASS, stiffness: float = STIFFNESS) -> np.ndarray:
    """``omega_k = 2 sqrt(k/m) sin(k pi / 2n)`` of n equal masses on a free line, k = 0 .. n-1, in Hz."""
    omega: np.ndarray = 2.0 * np.sqrt(stiffness / mass) * np.sin(np.arange(n) * np.pi / (2 * n))
    return omega / (2.0 * np.pi)


@pytest.mark.parametrize("n", [2, 3, 50, 208])
def test_a_uniform_train_has_the_frequencies_of_the_formula(n: int) -> None:
    modes = natural_modes(train_of([vehicle(MASS)] * n, linear_gear(STIFFNESS, STIFFNESS)))
    np.testing.assert_allclose(modes.frequencies, chain(n), rtol=1e-9, atol=1e-12)


def test_shapes_of_a_uniform_train_are_cosines() -> None:
    n = 40
    modes = natural_modes(train_of([vehicle(MASS)] * n, linear_gear(STIFFNESS, STIFFNESS)))
    for k in (1, 2, n - 1):
        exact = np.cos(k * np.pi * (np.arange(n) + 0.5) / n) * np.sqrt(2.0 / (n * MASS))
        np.testing.assert_allclose(modes.shapes[k], exact, atol=1e-12)


def test_modes_solve_the_eigenvalue_problem_of_unequal_masses_and_are_mass_normalised() -> None:
    masses = np.array([184e3, 100e3, 60e3, 20e3, 100e3])
    modes = natural_modes(train_of([vehicle(mass) for mass in masses], linear_gear(3e7, 9e6)))
    stiffness = stiffness_matrix(np.full(4, (3e7 + 9e6) / 2))
    for frequency, shape in zip(modes.frequencies, modes.shapes, strict=True):
        forces = stiffness @ shape - (2.0 * np.pi * frequency) ** 2 * masses * shape
        assert np.abs(forces).max() < 1e-9 * np.abs(stiffness).max() * np.abs(shape).max()
    np.testing.assert_allclose(modes.shapes @ np.diag(masses) @ modes.shapes.T, np.eye(5), atol=1e-9)


def test_the_first_mode_is_the_train_as_a_whole() -> None:
    modes = natural_modes(train_of([vehicle(mass) for mass in (184e3, 100e3, 20e3)], linear_gear()))
    assert modes.frequencies[0] == 0.0
    np.testing.assert_allclose(modes.shapes[0], 1.0 / np.sqrt(304e3))


def test_rigid_drawbars_make_one_mass_of_several_vehicles() -> None:
    gear = linear_gear(STIFFNESS, STIFFNESS)
    couplers = [None if j % 2 == 0 else gear for j in range(39)]
    modes = natural_modes(train_of([vehicle(MASS)] * 40, couplers))
    np.testing.assert_allclose(modes.frequencies, chain(20, mass=2 * MASS), rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(modes.shapes[:, 0::2], modes.shapes[:, 1::2])


def test_lower_stiffness_and_larger_masses_lower_every_frequency() -> None:
    reference = natural_modes(train_of([vehicle(MASS)] * 30, linear_gear())).frequencies[1:]
    softer = natural_modes(train_of([vehicle(MASS)] * 30, linear_gear(1e7, 1e7))).frequencies[1:]
    heavier = natural_modes(train_of([vehicle(2 * MASS)] * 30, linear_gear())).frequencies[1:]
    np.testing.assert_allclose(softer / reference, np.sqrt(1.0 / 3.0))
    np.testing.assert_allclose(heavier / reference, np.sqrt(0.5))


def test_stiffness_about_rest_is_the_mean_of_the_initial_slopes_of_buff_and_draft() -> None:
    buff = SideCurves(((0.0, 0.0), (0.01, 1e5), (0.02, 9e5)), ((0.0, 0.0), (0.02, 4e4)))
    draft = SideCurves(((0.0, 0.0), (1.0, 3e7)), ((0.0, 0.0), (1.0, 1e7)))
    gear = DraftGear("test", buff, draft, 0.01)
    assert stiffness_about_rest(gear) == pytest.approx((1e7 + 2e6 + 3e7 + 1e7) / 4)


def test_a_train_set_off_in_a_mode_swings_with_its_frequency() -> None:
    consist = train_of([vehicle(MASS)] * 10, linear_gear(STIFFNESS, STIFFNESS))
    modes = natural_modes(consist)
    shape = modes.shapes[1] / np.abs(modes.shapes[1]).max()
    quarter = 1.0 / (4.0 * modes.frequencies[1])
    steps = 2000
    train = model(consist, 0.1 * shape, time_step=quarter / steps)
    train.advance(steps)
    # After a quarter of a period all speed has become displacement.
    assert np.abs(train.speed).max() < 1e-4 * 0.1
    np.testing.assert_allclose(train.displacement, 0.1 * shape / (2.0 * np.pi * modes.frequencies[1]), rtol=1e-3)
