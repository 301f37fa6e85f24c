"""The live page in a real browser, beside a real node."""

from __future__ import annotations

import asyncio
import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from playwright.sync_api import WebSocket
from tornado.httpclient import HTTPRequest
from tornado.websocket import websocket_connect

from tests.browser import Watched, headless_browser
from tests.ros.live_node import LOCOMOTIVES, TABLE
from tests.waiting import WAIT

if TYPE_CHECKING:
    from tests.ros.live_node import LiveNode, Observer

StartNode = Callable[..., "LiveNode"]


@contextmanager
def viewing(*arguments: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """``haul view``, and the address that it prints; it ends with 0 when it is told to."""
    command = [sys.executable, "-m", "haul_ros", "view", *arguments]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        assert process.stdout is not None
        found = re.fullmatch(
            r"look(?: and drive)?: (http://127\.0\.0\.1:\d+/\?token=\S{32})\n", process.stdout.readline()
        )
        assert found
        yield process, found[1]
        process.terminate()
        assert process.wait(WAIT) == 0
    finally:
        process.kill()
        process.communicate()


def processor_time(process: subprocess.Popen[str]) -> float:
    """Of user and system [s]."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def float64(message: bytes) -> float:
    from haul_ros.messages.cdr import decode_float64

    return decode_float64(message)


def speed(watched: Watched) -> float:
    """Of the head [km/h]."""
    return float(watched.text("#desk-speed").removesuffix(" km/h"))


def test_the_desk_drives_a_node_and_the_page_finds_it_again_after_a_restart(
    start_node: StartNode, observer: Observer
) -> None:
    node = start_node(record_path="none")
    applied = {name: observer.watch(TABLE.applied_brake[name]) for name in LOCOMOTIVES}
    with headless_browser() as browser, viewing("--drive") as (view, address):
        watched, frames = Watched(browser), list[float]()
        watched.page.on("websocket", lambda socket: count_frames(socket, frames))
        watched.open(address)
        watched.wait_for(lambda: watched.time > 0.5, "time to pass")

        # Ten frames a second for less than a tenth of a core, with a browser that looks
        used, before = processor_time(view), len(frames)
        watched.wait_for(lambda: len(frames) > before + 40 and ten_in_a_second(frames[before:]), "frames in their rate")
        passed, came = frames[-1] - frames[before], len(frames) - 1 - before
        assert processor_time(view) - used < 0.1 * passed
        assert came / passed < 10.5
        assert speed(watched) > 78.0

        # A link, by parameters of the node
        watched.page.fill("#slave_3-delay", "0.75")
        watched.page.press("#slave_3-delay", "Enter")
        watched.wait_for(lambda: watched.text("#answer") == "slave_3: link set", "the answer")
        assert observer.parameter("radio.slave_3.delay").double_value == 0.75
        watched.page.uncheck("#slave_1-up")
        watched.wait_for(lambda: not observer.parameter("radio.slave_1.connected").bool_value, "the link to go down")

        # A demand, by topics: slave 1 does not hear of it
        watched.page.focus("#brake")
        for _ in range(20):
            watched.page.keyboard.press("ArrowRight")
        observer.wait_until(lambda: bool(applied["slave_3"]) and float64(applied["slave_3"][-1]) == 0.2, "the demand")
        assert float64(applied["master"][-1]) == 0.2
        assert float64(applied["slave_1"][-1]) == 0.0

        # The emergency: the train brakes
        watched.page.check("#slave_1-up")
        watched.page.click("#emergency")
        observer.wait_until(lambda: all(float64(applied[name][-1]) == 1.0 for name in LOCOMOTIVES), "the emergency")
        fast = speed(watched)
        watched.wait_for(lambda: speed(watched) < fast - 2.0, "the train to brake")
        assert "slave_3: emergency latched" in watched.text("#events")
        watched.wait_for(lambda: watched.text("#arrivals-body tr:last-child").startswith("slave_3"), "its arrival")
        delay = float(watched.text("#arrivals-body tr:last-child td:last-child"))
        assert delay == pytest.approx(0.75, abs=0.15)  # each is known to a frame

        # Services
        watched.page.click("#pause")
        watched.wait_for(lambda: watched.text("#pause") == "go on", "the pause")
        watched.page.wait_for_timeout(300)
        stands_at = watched.time
        watched.page.click("#step")
        watched.wait_for(lambda: abs(watched.time - stands_at - 0.02) < 1e-6, "the step")
        watched.page.click("#reset")
        watched.wait_for(lambda: watched.text("#answer") == "started again at 0.000 s", "the reset")
        watched.wait_for(lambda: watched.time < 0.1, "the start")

        # The node goes and another comes, of another train
        assert node.end() == 0
        watched.wait_for(lambda: "the node has gone" in watched.text("#status"), "the end of the node")
        start_node(record_path="none", scenario="daqin_1_1_0")
        watched.wait_for(lambda: "daqin_1_1_0" in watched.text("#description"), "the other train")
        watched.wait_for(lambda: watched.page.is_hidden("#status") and watched.time > 0.5, "its samples")
        assert watched.page.locator(".slave").count() == 1
        watched.page.click("#emergency")
        watched.wait_for(lambda: speed(watched) < 78.0, "the other train to brake")
        assert watched.complaints == []


def ten_in_a_second(frames: list[float]) -> bool:
    """Or in a quarter more; a busy machine may keep others waiting."""
    return any(after - before < 1.25 for before, after in zip(frames, frames[10:], strict=False))


def count_frames(socket: WebSocket, frames: list[float]) -> None:
    """Note when each comes [s]."""

    def take(payload: str | bytes) -> None:
        if isinstance(payload, bytes):
            frames.append(time.monotonic())

    socket.on("framereceived", take)


def test_without_drive_a_page_chooses_among_nodes_and_does_nothing_more(start_node: StartNode) -> None:
    start_node(record_path="none", scenario="daqin_1_1_0")
    start_node(record_path="none", ros_arguments=["-r", "__ns:=/yard"])
    emergency = {"do": "command", "locomotive": "master", "kind": "emergency", "value": 1}
    with viewing("--node", "/yard/haul") as (_, address):
        yard, answer, haul = asyncio.run(asyncio.wait_for(look(address, emergency), WAIT))
    assert (yard["node"], yard["drive"], len(yard["train"]["couplers"])) == ("/yard/haul", False, 207)
    assert [found["vehicle"] for found in yard["train"]["locomotives"]] == [0, 103, 104, 207]
    assert (answer["done"], answer["text"]) == (False, "this page only looks: haul view --drive gives a desk")
    assert (haul["node"], len(haul["train"]["couplers"])) == ("/haul", 205)


async def look(address: str, asked: dict[str, Any]) -> tuple[dict[str, Any], ...]:
    """What a page is told of the train that it comes to, as answer, and of ``/haul``, which it then chooses."""
    origin, _, query = address.partition("/?")
    request = HTTPRequest(f"ws{origin.removeprefix('http')}/live?{query}", headers={"Origin": origin})
    socket = await websocket_connect(request)

    async def told(what: str, node: str | None = None) -> dict[str, Any]:
        while True:
            message = await socket.read_message()
            assert message is not None
            found: dict[str, Any] = json.loads(message) if isinstance(message, str) else {}
            if found.get("is") == what and (node is None or (found["node"] == node and found["train"])):
                return found

    yard = await told("hello", "/yard/haul")
    await socket.write_message(json.dumps(asked))
    answer = await told("answer")
    await socket.write_message(json.dumps({"do": "watch", "node": "/haul"}))
    return yard, answer, await told("hello", "/haul")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--port", "70000"], "haul: --port 70000: expected 1 to 65535, or 0 for any that is free\n"),
        (["--node", "no name"], "haul: --node 'no name': expected the full name of a node, such as /train_a/haul\n"),
    ],
)
def test_a_mistake_is_told_in_a_line(arguments: list[str], line: str, capsys: pytest.CaptureFixture[str]) -> None:
    from haul_ros.cli.main import main

    assert main(["view", *arguments]) == 2
    assert capsys.readouterr().err == line


def test_a_taken_port_and_a_missing_tornado_are_told_in_a_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import socket

    from haul_ros.cli import view
    from haul_ros.cli.main import main

    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = str(other.getsockname()[1])
        assert main(["view", "--port", port]) == 2
    assert capsys.readouterr() == ("", f"haul: --port {port}: is in use, expected one that is free\n")
    monkeypatch.setattr(view, "find_spec", lambda _: None)
    assert main(["view"]) == 2
    assert capsys.readouterr().err == "haul: needs tornado; install it with: pip install 'haul_ros[view]'\n"
