"""Values of options, checked as they are read."""

from __future__ import annotations

import math
from argparse import ArgumentTypeError

MOST_COUPLERS = 10_000
"""More than any train has."""


def seconds(text: str) -> float:
    """A time [s]."""
    return _number(text, "seconds")


def positive(text: str) -> float:
    """A number above 0."""
    if (value := _number(text, "a number above 0")) <= 0.0:
        raise ArgumentTypeError(f"{value:g}, expected a number above 0")
    return value


def dots(text: str) -> int:
    """Dots an inch that a picture can have."""
    if not (text.isascii() and text.isdecimal() and len(text) <= 4 and 30 <= int(text) <= 1200):
        raise ArgumentTypeError(f"{text[:40]!r}, expected a whole number from 30 to 1200")
    return int(text)


def coupler_numbers(text: str) -> tuple[int, ...]:
    """Numbers of couplers: ``1,50-60``."""
    found: set[int] = set()
    for part in text.split(","):
        first, _, last = part.partition("-")
        ends = [first, last or first]
        if not all(end.isascii() and end.isdecimal() and len(end) <= 5 for end in ends):
            raise ArgumentTypeError(f"{text[:40]!r}, expected numbers and ranges such as 1,50-60")
        begin, end = map(int, ends)
        if not 1 <= begin <= end <= MOST_COUPLERS:
            raise ArgumentTypeError(f"{part[:40]!r}, expected numbers from 1 up, the smaller first")
        found.update(range(begin, end + 1))
    return tuple(sorted(found))


def _number(text: str, expected: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ArgumentTypeError(f"{text[:40]!r}, expected {expected}")
    return value
