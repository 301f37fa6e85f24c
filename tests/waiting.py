"""Waiting for what another thread or process does: for the event itself, however slow the machine is."""

from __future__ import annotations

import time
from collections.abc import Callable

WAIT = 300.0
"""Longest wait [s] for anything; only a failing test waits for so long."""


def wait_until(condition: Callable[[], bool], what: str) -> None:
    """Look again and again until the condition holds."""
    end = time.monotonic() + WAIT
    while not condition():
        assert time.monotonic() < end, f"waited {WAIT:g} s in vain for {what}"
        time.sleep(0.005)
