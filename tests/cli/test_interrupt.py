from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import pytest

from haul_ros.cli.interrupt import interruption


@pytest.fixture(autouse=True)
def python_handles_ctrl_c() -> Iterator[None]:
    """Even where the tests run in the background of a shell, with SIGINT ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_the_first_ctrl_c_is_noted_and_the_second_interrupts() -> None:
    with pytest.raises(KeyboardInterrupt), interruption() as interrupted:
        assert not interrupted()
        os.kill(os.getpid(), signal.SIGINT)
        assert interrupted()
        os.kill(os.getpid(), signal.SIGINT)


def test_afterwards_ctrl_c_interrupts_as_before() -> None:
    before = signal.getsignal(signal.SIGINT)
    with interruption() as interrupted:
        pass
    assert not interrupted()
    assert signal.getsignal(signal.SIGINT) is before
