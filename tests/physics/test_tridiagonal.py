"""The kernel's linear solver against numpy."""

from __future__ import annotations

import numpy as np
import pytest

from haul_ros.physics.kernel.tridiagonal import solve_tridiagonal


@pytest.mark.interpreted
@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 6, 7, 8, 9, 207, 208])
def test_the_solution_is_that_of_a_dense_solver(n: int) -> None:
    random = np.random.default_rng(n)
    off_diagonal = -random.uniform(0.1, 1.0, n)  # the last entry joins no row and must not matter
    diagonal = random.uniform(0.01, 1.0, n) + 2.0
    right = random.normal(size=n)
    inner = off_diagonal[:-1]
    matrix = np.diag(diagonal) + np.diag(inner, 1) + np.diag(inner, -1)
    expected = np.linalg.solve(matrix, right)
    solution = right.copy()
    solve_tridiagonal(diagonal.copy(), off_diagonal, solution)
    np.testing.assert_allclose(solution, expected, rtol=1e-12, atol=1e-14)


@pytest.mark.interpreted
def test_rows_that_are_cut_off_from_their_neighbours_are_solved_alone() -> None:
    diagonal = np.array([2.0, 1.0, 4.0, 1.0, 5.0])
    solution = np.array([2.0, 0.0, 8.0, 0.0, 10.0])
    solve_tridiagonal(diagonal, np.zeros(5), solution)
    np.testing.assert_array_equal(solution, [1.0, 0.0, 2.0, 0.0, 2.0])
