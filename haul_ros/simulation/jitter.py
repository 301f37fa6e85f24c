"""How late a telegram is: the random addition to the delay of a link, by its law."""

from __future__ import annotations

import math
from collections.abc import Callable
from statistics import NormalDist

import numpy as np

from haul_ros.model.radio import RadioLink

_NORMAL = NormalDist()
_LEAST = 2.0**-53


def arrival_time(link: RadioLink, time: float, luck: float, generator: Callable[[], np.random.Generator]) -> float:
    """When what is sent at ``time`` arrives [s], for ``luck`` from 0 to below 1.

    Only the gamma law draws more, from a generator.
    """
    if link.jitter_law == "normal" and link.jitter > 0.0:
        return time + _truncated_normal(link.delay, link.jitter, luck)
    return time + link.delay + link.jitter * _addition(link, luck, generator)


def _addition(link: RadioLink, luck: float, generator: Callable[[], np.random.Generator]) -> float:
    """The addition over ``jitter``."""
    match link.jitter_law:
        case "exponential":
            return -math.log1p(-luck)
        case "gamma":
            return float(generator().standard_gamma(link.jitter_shape)) / link.jitter_shape
        case "empirical":
            quantiles = link.jitter_quantiles
            return float(np.interp(luck * (len(quantiles) - 1), range(len(quantiles)), quantiles))
    return luck


def _truncated_normal(mean: float, deviation: float, luck: float) -> float:
    below = _NORMAL.cdf(-mean / deviation)
    part = min(max(below + luck * (1.0 - below), _LEAST), 1.0 - _LEAST)  # the quantiles of 0 and 1 are infinite
    return max(0.0, mean + deviation * _NORMAL.inv_cdf(part))
