"""A headless browser, and the page in it."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from time import monotonic

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Error, Page, Request, sync_playwright

from tests.waiting import WAIT

PHONE = {"width": 390, "height": 844}
DESKTOP = {"width": 1400, "height": 900}
_NAMES = ("chromium", "chromium-browser", "google-chrome")


_CONTAINER = ["--disable-dev-shm-usage"]
"""In a container /dev/shm may be small."""


@contextmanager
def headless_browser(*arguments: str) -> Iterator[Browser]:
    """Chromium of the system; where there is none the test is skipped, but not where CI says that there has to be."""
    found = next(filter(None, map(shutil.which, _NAMES)), None)
    if found is None:
        assert not os.environ.get("CI"), "no chromium, which .ci/run has to install"
        pytest.skip("needs a browser: apt install chromium")
    # Its sandbox does not work as root
    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=[*sandbox, *_CONTAINER, *arguments])
        yield browser
        browser.close()


class Watched:
    """A page, what it has complained of, and what it has asked for."""

    def __init__(self, browser: Browser, *, scheme: str = "light") -> None:
        self.page: Page = browser.new_page(viewport=DESKTOP, color_scheme=scheme)  # type: ignore[arg-type]
        self.page.set_default_timeout(1e3 * WAIT)
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", self._told)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", self._asked)

    def _told(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning"):
            self.complaints.append(message.text)

    def _asked(self, request: Request) -> None:
        self.requests.append(request.url)

    def open(self, url: str) -> None:
        self.page.goto(url)
        self.page.wait_for_selector("body[data-ready]", timeout=120_000)  # a node may have to compile first

    def wait_for(self, condition: Callable[[], bool], what: str, longest: float = WAIT) -> None:
        """The policy of the page keeps conditions in JavaScript from being waited for."""
        end = monotonic() + longest
        while not condition():
            assert monotonic() < end, f"waited {longest:g} s in vain for {what}"
            self.page.wait_for_timeout(20)

    def text(self, selector: str) -> str:
        """As it stands once what has been asked for is drawn, which the page does before the next frame."""
        with suppress(Error):  # the live page loads itself again for another train
            self.page.evaluate("() => new Promise(drawn => requestAnimationFrame(() => requestAnimationFrame(drawn)))")
        return self.page.inner_text(selector)

    @property
    def time(self) -> float:
        """Of the cursor [s]."""
        return float(self.text("#time").removesuffix(" s"))

    def hover(self, time: float, place: float, ends: tuple[float, float], rows: int) -> tuple[str, float, str]:
        """Row, time [s] and value that are shown where the heat map has this time and place (1 the first row)."""
        x, y = self.point(time, place, ends, rows)
        self.page.mouse.move(x, y)
        name, at, value = re.fullmatch(r"(\S+) at (\S+) s\n(.*)", self.text("#tip")).groups()  # type: ignore[union-attr]
        return name, float(at), value

    def point(self, time: float, place: float, ends: tuple[float, float], rows: int) -> tuple[float, float]:
        """Where on the screen that is; the margins are those of heatmap.js."""
        self.page.locator("#heatmap").scroll_into_view_if_needed()
        box = self.page.locator("#heatmap").bounding_box()
        assert box is not None
        share = (time - ends[0]) / (ends[1] - ends[0])
        x = box["x"] + 62 + share * (box["width"] - 62 - 14)
        return x, box["y"] + 20 + (place - 0.5) / rows * (box["height"] - 20 - 24)
