from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from haul_ros.cli.interrupt import interruption
from haul_ros.recording.reader import Recording
from tests.waiting import WAIT, wait_until


def test_the_first_ctrl_c_is_noted_and_the_second_interrupts() -> None:
    with pytest.raises(KeyboardInterrupt), interruption() as interrupted:
        assert not interrupted()
        os.kill(os.getpid(), signal.SIGINT)
        assert interrupted()
        os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
@pytest.mark.slow
def test_a_signal_ends_a_run_whole_and_is_its_exit_status(
    short_train: str, tmp_path: Path, number: signal.Signals, status: int
) -> None:
    (tmp_path / "short.yaml").write_text(short_train, "utf-8")
    endless = ("--set", "commands=[]", "--set", "max_duration_s=80000")
    command = [sys.executable, "-m", "haul_ros", "run", "short.yaml", *endless, "-o", "run.mcap"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    active = tmp_path / "run.mcap.active"
    wait_until(lambda: active.exists() and active.stat().st_size > 2_000_000, "two megabytes of the recording")
    process.send_signal(number)
    out, err = process.communicate(timeout=WAIT)
    assert process.returncode == status, err
    assert "still moving" in out
    assert "interrupted at" in err
    with Recording(tmp_path / "run.mcap") as recording:
        assert recording.info().complete


def test_a_signal_that_is_ignored_stays_so() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interruption() as interrupted:
            os.kill(os.getpid(), signal.SIGHUP)
            assert not interrupted()
    finally:
        signal.signal(signal.SIGHUP, before)


def test_afterwards_ctrl_c_interrupts_as_before() -> None:
    before = signal.getsignal(signal.SIGINT)
    with interruption() as interrupted:
        pass
    assert not interrupted()
    assert signal.getsignal(signal.SIGINT) is before
