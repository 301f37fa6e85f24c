"""Names that are nearly those of something known: a slip of the user's, or a name of something else."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

MOST_SLIPS = 2
"""Letters that are wrong in a misspelt name; in one of less than six letters fewer: a third of them."""


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name that is most like this one; None: none is."""
    return next(iter(difflib.get_close_matches(name, list(known), n=1)), None)


def is_slip(name: str, known: Iterable[str]) -> bool:
    """Whether a name that is not known is one of the known ones misspelt."""
    return any(_slips(name.lower(), other.lower(), min(MOST_SLIPS, len(other) // 3)) for other in known)


def _slips(name: str, other: str, most: int) -> bool:
    return abs(len(name) - len(other)) <= most and edit_distance(name, other) <= most


def edit_distance(one: str, other: str) -> int:
    """Least number of letters to insert, delete, replace or swap with a neighbour (optimal string alignment)."""
    before: list[int] = []
    row = list(range(len(other) + 1))
    for i, a in enumerate(one, 1):
        older, before, row = before, row, [i]
        for j, b in enumerate(other, 1):
            least = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (a != b))
            if i > 1 and j > 1 and (a, b) == (other[j - 2], one[i - 2]):
                least = min(least, older[j - 2] + 1)
            row.append(least)
    return row[-1]
