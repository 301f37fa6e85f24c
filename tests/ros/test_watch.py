"""``haul watch`` beside a real node, into a pipe and into a terminal."""

from __future__ import annotations

import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("rich")

from tests.waiting import WAIT

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode

COMMAND = [sys.executable, "-m", "haul_ros", "watch"]
ENVIRONMENT = {"PYTHONPATH": os.pathsep.join(sys.path), "TERM": "xterm-256color", "COLUMNS": "150"}


@pytest.mark.slow
def test_a_pipe_gets_a_line_a_second_and_a_terminal_the_picture(start_node: Callable[..., LiveNode]) -> None:
    node = start_node(record_path="none", scenario_commands=True)
    environment = {**os.environ, **ENVIRONMENT}
    master, slave = pty.openpty()
    piped = subprocess.Popen(COMMAND, stdout=subprocess.PIPE, text=True, env=environment)
    drawn = subprocess.Popen([*COMMAND, "--node", "/haul"], stdout=slave, env=environment)
    try:
        assert piped.stdout is not None
        lines = iter(piped.stdout.readline, "")
        found = next(line for line in lines if "compression" in line)
        assert re.search(r"^/haul .* [\d.]+ s  [\d.]+ km/h  compression \d+ kN, tension \d+ kN", found)
        shown, end = "", time.monotonic() + WAIT
        while not ("▲" in shown and "km/h" in shown and "█" in shown):
            assert time.monotonic() < end
            if select.select([master], [], [], 1.0)[0]:
                shown += os.read(master, 65536).decode(errors="replace")
        for process, number in ((piped, signal.SIGINT), (drawn, signal.SIGTERM)):
            process.send_signal(number)
            assert process.wait(WAIT) == 0
    finally:
        for process in (piped, drawn):
            process.kill()
            process.wait()
        os.close(master)
        os.close(slave)
    assert node.end() == 0
