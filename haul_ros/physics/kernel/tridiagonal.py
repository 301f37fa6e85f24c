"""Symmetric tridiagonal systems."""

from __future__ import annotations

from haul_ros.physics.kernel._jit import inner
from haul_ros.physics.kernel.data import Floats


@inner
def _eliminate(diagonal: Floats, right: Floats, off_diagonal: float, done: int, row: int) -> None:
    """Take equation ``done`` out of its neighbour ``row``; its diagonal is left inverted.

    Two divisions, but only one of them on the way from one diagonal to the next.
    """
    inverse = 1.0 / diagonal[done]
    diagonal[row] -= off_diagonal * off_diagonal / diagonal[done]
    right[row] -= off_diagonal * inverse * right[done]
    diagonal[done] = inverse


@inner
def solve_tridiagonal(diagonal: Floats, off_diagonal: Floats, right: Floats) -> None:
    """Solve in place: the solution replaces ``right`` (n,), ``diagonal`` (n,) is overwritten.

    ``off_diagonal`` (n - 1 or more,) holds the entries (i, i + 1). For diagonally dominant
    matrices, no pivoting. Elimination runs from both ends to the middle and substitution back
    outwards: two independent chains take half the time of one, for each link waits for a division.
    """
    last = diagonal.shape[0] - 1
    middle = diagonal.shape[0] // 2
    for i in range(last - middle):
        _eliminate(diagonal, right, off_diagonal[i], i, i + 1)
        _eliminate(diagonal, right, off_diagonal[last - i - 1], last - i, last - i - 1)
    for i in range(last - middle, middle):  # an even number of rows leaves one more above the middle
        _eliminate(diagonal, right, off_diagonal[i], i, i + 1)
    right[middle] /= diagonal[middle]
    for i in range(middle - 1, -1, -1):
        right[i] = right[i] * diagonal[i] - off_diagonal[i] * diagonal[i] * right[i + 1]
        j = last - i
        if j > middle:
            right[j] = right[j] * diagonal[j] - off_diagonal[j - 1] * diagonal[j] * right[j - 1]
