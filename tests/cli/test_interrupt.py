from __future__ import annotations

import os
import signal

import pytest

from haul_ros.cli.interrupt import interruption


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
