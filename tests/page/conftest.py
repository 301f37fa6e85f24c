"""A stop of the 20 000 t train, its report, and a browser."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from haul_ros.cli.main import main
from tests.browser import headless_browser


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with headless_browser() as found:
        yield found


@pytest.fixture(scope="module")
def stop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recording of 60 s at 50 Hz, in which the slaves hear late of an emergency; the train stands after 45 s."""
    path = tmp_path_factory.mktemp("stop") / "stop.mcap"
    overrides = [
        "radio.slave_1.delay_s=0.5",
        "radio.slave_2.delay_s=0.5",
        "radio.slave_3.delay_s=1",
        "sample_rate_hz=50",
    ]
    arguments = [part for override in overrides for part in ("--set", override)]
    assert main(["run", "daqin_1_2_1", *arguments, "-o", str(path), "--quiet"]) == 0
    return path
