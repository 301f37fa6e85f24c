"""Interrupts reach who waits for them."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import time

import pytest

from haul_ros.ending import no_interrupt_lost


def interrupted_where_none_gets_out() -> None:
    """SIGINT in a callback of compiled code, as of the compiler."""

    def interrupt() -> None:
        os.kill(os.getpid(), signal.SIGINT)
        for _ in range(1000):
            pass

    ctypes.CFUNCTYPE(None)(interrupt)()


def test_an_interrupt_in_a_callback_arises_again_and_nothing_is_printed(capfd: pytest.CaptureFixture[str]) -> None:
    before = sys.unraisablehook, sys.excepthook, signal.getsignal(signal.SIGALRM)
    with pytest.raises(KeyboardInterrupt), no_interrupt_lost():
        interrupted_where_none_gets_out()
        time.sleep(60.0)
    assert capfd.readouterr().err == ""
    assert (sys.unraisablehook, sys.excepthook, signal.getsignal(signal.SIGALRM)) == before


def test_an_interrupt_that_compiled_code_prints_arises_again_too(capfd: pytest.CaptureFixture[str]) -> None:
    def print_as_c_does() -> None:
        """PyErr_Print."""
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            sys.excepthook(type(error), error, error.__traceback__)

    with pytest.raises(KeyboardInterrupt), no_interrupt_lost():
        print_as_c_does()
        time.sleep(60.0)
    assert capfd.readouterr().err == ""


def test_what_else_cannot_be_raised_is_told_as_ever() -> None:
    told: list[type[BaseException]] = []

    def fail() -> None:
        raise ValueError

    hook, sys.unraisablehook = sys.unraisablehook, lambda lost: told.append(lost.exc_type)
    try:
        with no_interrupt_lost():
            ctypes.CFUNCTYPE(None)(fail)()
    finally:
        sys.unraisablehook = hook
    assert told == [ValueError]
