"""The report in a real browser, beside the recording that it is of."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Error

from haul_ros.messages.cdr import serialize, typestore
from haul_ros.messages.channels import LOG
from haul_ros.page.report import write_report
from haul_ros.recording.reader import Recording
from haul_ros.recording.series import Samples
from haul_ros.units import NS_PER_S
from tests.browser import PHONE, Watched
from tests.recorded import forge

pytestmark = pytest.mark.slow

HALF_A_STEP = 0.5 * 900.0 / 32767
"""kN, of how forces up to 900 kN are packed."""


@pytest.fixture(scope="module")
def samples(stop: Path) -> Samples:
    with Recording(stop) as recording:
        return recording.samples()


@pytest.fixture(scope="module")
def report(stop: Path) -> Path:
    path = stop.with_suffix(".html")
    write_report(stop, path)
    return path


@pytest.fixture(scope="module")
def loaded(browser: Browser, report: Path) -> Iterator[Watched]:
    watched = Watched(browser)
    watched.open(report.as_uri())
    yield watched
    watched.page.close()


@pytest.fixture
def opened(loaded: Watched) -> Iterator[Watched]:
    """The page as it came; it must never complain."""
    loaded.page.reload()
    loaded.page.wait_for_selector("body[data-ready]")
    yield loaded
    assert loaded.complaints == []


def ends(samples: Samples) -> tuple[float, float]:
    times = samples.couplers.time_ns / NS_PER_S
    return float(times[0]), float(times[-1])


def force(samples: Samples, time: float, coupler: int) -> float:
    """In kN, of the coupler with this number, at the sample at this time."""
    index = int(np.flatnonzero(np.abs(samples.couplers.time_ns / NS_PER_S - time) < 5e-3)[0])
    return float(samples.couplers.force[index, coupler - 1]) / 1e3


def test_a_stop_is_below_10_mb_shown_within_3_s_and_asks_for_nothing(browser: Browser, report: Path) -> None:
    assert report.stat().st_size < 10e6
    watched = Watched(browser)
    taken = []
    for _ in range(2):  # others may be at work on the same machine
        began = perf_counter()
        watched.open(report.as_uri())
        taken.append(perf_counter() - began)
    assert min(taken) < 3.0
    assert {url for url in watched.requests if not url.startswith("data:")} == {report.as_uri()}
    assert watched.complaints == []
    watched.page.close()


@pytest.mark.parametrize(("time", "coupler"), [(7.4, 93), (20.0, 117), (2.0, 1), (44.0, 207)])
def test_hover_shows_the_force_that_was_recorded(opened: Watched, samples: Samples, time: float, coupler: int) -> None:
    name, at, text = opened.hover(time, coupler, ends(samples), 207)
    assert name == f"coupler_{coupler:03d}"
    assert at == pytest.approx(time, abs=0.05)  # a pixel is 0.05 s
    value, unit, word = text.split()
    expected = force(samples, at, coupler)
    assert float(value) == pytest.approx(expected, abs=HALF_A_STEP + 0.05)
    assert (unit, word) == ("kN", "compression" if expected > 0 else "tension")


def test_a_click_moves_the_cursor_of_every_part_and_chooses_the_coupler(opened: Watched, samples: Samples) -> None:
    opened.page.mouse.click(*opened.point(30.0, 50, ends(samples), 207))
    opened.page.mouse.move(5, 5)
    assert opened.time == pytest.approx(30.0, abs=0.05)
    assert f"at {opened.time:.2f} s" in opened.text("#profile-chart h2")
    assert opened.text("#chips").split()[::2] == ["117", "93", "50"]
    curves = dict(re.findall(r"(coupler_\d+)\s+(-?[\d.]+) kN", opened.text("#chosen-chart .values")))
    assert set(curves) == {"coupler_093", "coupler_117", "coupler_050"}  # the couplers of the largest forces, and this
    nearest = float(samples.couplers.time_ns[np.abs(samples.couplers.time_ns / NS_PER_S - opened.time).argmin()])
    assert float(curves["coupler_050"]) == pytest.approx(force(samples, nearest / NS_PER_S, 50), abs=HALF_A_STEP + 0.05)
    head = re.search(r"head\s+([\d.]+) km/h", opened.text("#speed-chart .values"))
    row = int(np.flatnonzero(samples.vehicles.time_ns == nearest)[0])
    assert head is not None
    assert float(head[1]) == pytest.approx(3.6 * samples.vehicles.speed[row, 0], abs=0.01)


def test_play_runs_through_time_and_keys_move_it(opened: Watched) -> None:
    press, page = opened.page.keyboard.press, opened.page
    press("Home")
    opened.wait_for(lambda: opened.time == 0.0, "the start")
    press("Space")
    opened.wait_for(lambda: opened.time > 0.4, "time to pass")
    press("Space")
    page.wait_for_timeout(100)
    held = opened.time
    assert 0.4 < held < 3.0
    page.wait_for_timeout(200)
    assert opened.time == held
    press("ArrowRight")
    opened.wait_for(lambda: opened.time > held, "a sample")
    assert opened.time - held < 0.035  # the next one
    press("Shift+ArrowRight")
    opened.wait_for(lambda: held + 0.95 < opened.time < held + 1.05, "a second")
    press("End")
    opened.wait_for(lambda: opened.time > 45.0, "the end")
    page.select_option("#rate", "20")
    page.click("#play")  # from the start again, to the end by itself
    opened.wait_for(lambda: opened.time < 30.0, "the start")
    opened.wait_for(lambda: page.get_attribute("#play", "aria-pressed") == "false", "the end")
    assert opened.time > 45.0


def test_a_drag_zooms_and_0_shows_all_again(opened: Watched, samples: Samples) -> None:
    mouse, all_of_it = opened.page.mouse, ends(samples)
    x, y = opened.point(10.0, 100, all_of_it, 207)
    mouse.move(x, y)
    mouse.down()
    mouse.move(opened.point(15.0, 100, all_of_it, 207)[0], y, steps=3)
    mouse.up()
    assert opened.hover(11.0, 100, (10.0, 15.0), 207)[1] == pytest.approx(11.0, abs=0.06)
    opened.page.keyboard.press("0")
    assert opened.hover(30.0, 100, all_of_it, 207)[1] == pytest.approx(30.0, abs=0.05)


def test_events_peaks_and_other_quantities_lead_to_their_places(opened: Watched, samples: Samples) -> None:
    opened.page.click(".event:has-text('slave_3: emergency latched')")
    assert opened.time == 1.0
    arrivals = [opened.text(f"#arrivals-body tr:nth-child({row})").split() for row in (1, 2, 3)]
    delays = [("slave_1", "0.500"), ("slave_2", "0.500"), ("slave_3", "1.000")]
    assert arrivals == [[slave, "0.000", delay, delay] for slave, delay in delays]
    opened.page.select_option("#table-name", "brake_timing")
    opened.page.click("#table-head button:has-text('time to 90 percent')")  # those that fill last: where waves meet
    late = opened.text("#table-body tr:first-child").split()
    assert late[1] == "vehicle_161_C80"
    # Four waves at the speed of an emergency in paper_set_b of the catalogue: from the master, the pair and the tail
    waves = [opened.text(f"#waves-body tr:nth-child({row})").split() for row in (1, 2, 3, 4)]
    assert opened.page.locator("#waves-body tr").count() == 4
    assert [(what, int(vehicle)) for what, vehicle, *_ in waves] == [
        ("applies", number) for number in (1, 104, 104, 208)
    ]
    assert [float(wave[2]) for wave in waves] == pytest.approx([0.0, 0.5, 0.5, 1.0], abs=0.05)
    assert [float(wave[-1]) for wave in waves] == pytest.approx([220.0] * 4, rel=0.01)
    assert opened.text("#peaks-body tr:first-child").split()[:3] == ["93", "877.3", "7.445"]
    assert "877.3 kN" in opened.text("#summary")
    opened.page.select_option("#quantity", "cylinder")
    name, at, text = opened.hover(1.0, 1, ends(samples), 208)
    assert name == "vehicle_001_SS4"
    row = np.abs(samples.pressure.time_ns / NS_PER_S - at).argmin()
    assert float(text.split()[0]) == pytest.approx(samples.pressure.pressure[row, 0] / 1e3, abs=0.1)


def test_light_and_dark_follow_the_system_and_the_switch(opened: Watched) -> None:
    page, background = opened.page, "getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(background)
    page.emulate_media(color_scheme="dark")
    dark = page.evaluate(background)
    assert light == "rgb(244, 245, 247)"
    assert dark == "rgb(15, 19, 23)"
    page.keyboard.press("d")
    assert page.evaluate(background) == light
    page.emulate_media(color_scheme="light")
    assert page.evaluate(background) == light
    page.click("#theme")
    assert page.evaluate(background) == dark


def test_a_phone_needs_no_scrolling_sideways(browser: Browser, report: Path) -> None:
    watched = Watched(browser)
    watched.page.set_viewport_size(PHONE)  # type: ignore[arg-type]
    watched.open(report.as_uri())
    watched.page.wait_for_timeout(200)
    assert watched.page.evaluate("document.documentElement.scrollWidth") == 390
    below = [
        watched.page.evaluate(f"document.getElementById('{name}-chart').offsetTop") for name in ("profile", "speed")
    ]
    assert below[0] < below[1]
    assert watched.complaints == []
    watched.page.close()


def test_text_of_a_recording_is_shown_and_never_becomes_markup(browser: Browser, stop: Path) -> None:
    attack = "<img src=x onerror=window.hit=1></script><script>window.hit=1</script>${1}$title<!--"

    def changed(entries: Any) -> Any:
        for topic, message in entries:
            if topic == "/haul/events":
                entry: Any = typestore().deserialize_cdr(message.data, LOG)
                entry.msg = attack
                message.data = serialize(entry, LOG)
            yield topic, message

    forged = stop.with_name("<img src=x onerror=window.hit=1>.mcap")
    forge(stop, forged, messages=changed, description=lambda found: found | {"scenario": attack})
    page = stop.with_name("forged.html")
    write_report(forged, page)
    watched = Watched(browser)
    watched.open(page.as_uri())
    assert watched.page.evaluate("window.hit") is None
    assert watched.text("#title") == watched.page.title() == attack
    assert forged.name in watched.text("#notes")
    assert attack in watched.text("#events")
    assert watched.complaints == []
    # And if it became markup all the same, the policy would not let it run
    with pytest.raises(Error):
        watched.page.add_script_tag(content="window.hit = 1")
    watched.page.evaluate("document.body.insertAdjacentHTML('beforeend', '<img src=x onerror=\"window.hit=1\">')")
    watched.page.wait_for_timeout(100)
    assert watched.page.evaluate("window.hit") is None
    watched.page.close()
