"""Whom the live page is served to: a browser with the token, asked from itself, and nobody else."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from playwright.sync_api import Browser
from tornado.httpclient import AsyncHTTPClient, HTTPClientError, HTTPRequest, HTTPResponse
from tornado.websocket import WebSocketClientConnection, websocket_connect

from haul_ros.page.server import MOST_BROWSERS, PageServer, ServerError
from tests.browser import headless_browser
from tests.waiting import WAIT

CONTENTS: dict[str, object] = {"live": True, "title": "haul view", "description": ""}


class Served:
    """A server, what it was asked, and a client without manners."""

    def __init__(self) -> None:
        self.asked: list[dict[str, Any]] = []
        self.server = PageServer(0, CONTENTS, lambda: ["greeting", b"frame"], self._answer)
        self.origin = f"http://127.0.0.1:{self.server.port}"

    async def _answer(self, asked: dict[str, Any]) -> str:
        self.asked.append(asked)
        return "answer"

    async def get(self, path: str, **headers: str) -> HTTPResponse:
        request = HTTPRequest(f"{self.origin}{path}", headers=headers)
        return await AsyncHTTPClient().fetch(request, raise_error=False)

    async def socket(self, token: str | None = None, **headers: str) -> WebSocketClientConnection:
        query = self.server.token if token is None else token
        return await websocket_connect(
            HTTPRequest(f"ws://127.0.0.1:{self.server.port}/live?token={query}", headers=headers)
        )


def serving(check: Callable[[Served], Awaitable[None]]) -> None:
    async def run() -> None:
        served = Served()
        try:
            await asyncio.wait_for(check(served), WAIT)
        finally:
            served.server.close()

    asyncio.run(run())


def test_the_page_comes_to_who_has_the_token_with_nothing_that_opens_it_to_others() -> None:
    async def check(served: Served) -> None:
        answer = await served.get(served.server.address.removeprefix(served.origin))
        assert answer.code == 200
        assert f"connect-src ws://127.0.0.1:{served.server.port};" in answer.body.decode()
        assert "script-src &#x27;sha256-" in answer.body.decode()
        names = {name.lower() for name in answer.headers}
        assert not {name for name in names if name.startswith("access-control") or name == "set-cookie"}
        expected = {"X-Frame-Options": "DENY", "Referrer-Policy": "no-referrer", "Cache-Control": "no-store"}
        assert {name: answer.headers[name] for name in expected} == expected

    serving(check)


@pytest.mark.parametrize(
    ("token", "host"),
    [
        ("", None),
        ("wrong", None),
        ("%C3%A9", None),
        ("RIGHT", "evil.example"),
        ("RIGHT", "evil.example:PORT"),
        ("RIGHT", "127.0.0.1"),
    ],
)
def test_the_page_does_not_come_without_token_or_under_another_name(token: str, host: str | None) -> None:
    async def check(served: Served) -> None:
        headers = {} if host is None else {"Host": host.replace("PORT", str(served.server.port))}
        answer = await served.get(f"/?token={token.replace('RIGHT', served.server.token)}", **headers)
        assert answer.code == 403
        assert served.server.token not in answer.body.decode()

    serving(check)


@pytest.mark.parametrize(
    ("token", "origin", "host"),
    [
        ("", "OWN", None),
        ("wrong", "OWN", None),
        ("RIGHT", None, None),
        ("RIGHT", "null", None),
        ("RIGHT", "http://evil.example", None),
        ("RIGHT", "https://127.0.0.1:PORT", None),
        ("RIGHT", "http://127.0.0.1:1", None),
        ("RIGHT", "http://evil.example:PORT", "evil.example:PORT"),  # DNS rebinding: both agree
    ],
)
def test_the_socket_is_refused(token: str, origin: str | None, host: str | None) -> None:
    async def check(served: Served) -> None:
        own = {"OWN": served.origin, "PORT": str(served.server.port), "RIGHT": served.server.token}

        def filled(text: str) -> str:
            for name, value in own.items():
                text = text.replace(name, value)
            return text

        given = {"Origin": origin, "Host": host}
        headers = {name: filled(value) for name, value in given.items() if value is not None}
        with pytest.raises(HTTPClientError) as refused:
            await served.socket(filled(token), **headers)
        assert refused.value.code == 403
        assert served.asked == []

    serving(check)


def test_who_may_ask_is_greeted_and_answered_and_told_what_all_are_told() -> None:
    async def check(served: Served) -> None:
        one, other = [await served.socket(Origin=served.origin) for _ in range(2)]
        for socket_ in (one, other):
            assert [await socket_.read_message() for _ in range(2)] == ["greeting", b"frame"]
        await one.write_message(json.dumps({"do": "step"}))
        assert await one.read_message() == "answer"
        assert served.asked == [{"do": "step"}]
        served.server.send("news")
        assert [await one.read_message(), await other.read_message()] == ["news", "news"]

    serving(check)


@pytest.mark.parametrize("message", ["no JSON", "[1]", "[" * 3000, "x" * 5000])
def test_what_is_no_question_ends_the_socket(message: str) -> None:
    async def check(served: Served) -> None:
        socket_ = await served.socket(Origin=served.origin)
        await socket_.write_message(message)
        while await socket_.read_message() is not None:
            pass
        assert served.asked == []
        while served.server.browsers:
            await asyncio.sleep(0.01)

    serving(check)


def test_there_is_an_end_to_how_many_look() -> None:
    async def check(served: Served) -> None:
        for _ in range(MOST_BROWSERS):
            await served.socket(Origin=served.origin)
        with pytest.raises(HTTPClientError, match="503"):
            await served.socket(Origin=served.origin)

    serving(check)


def test_only_this_machine_is_listened_to_and_a_taken_port_is_told_of() -> None:
    async def check(served: Served) -> None:
        with pytest.raises(ServerError, match=f"--port {served.server.port}: is in use"):
            PageServer(served.server.port, CONTENTS, list, served._answer)
        with socket.socket() as other:  # another address of this machine, also of the loopback range
            assert other.connect_ex(("127.0.0.2", served.server.port)) != 0

    serving(check)


@contextmanager
def _rebinding_browser() -> Iterator[Browser]:
    """One that takes evil.example for this machine, as after DNS rebinding."""
    with headless_browser("--host-resolver-rules=MAP evil.example 127.0.0.1") as browser:
        yield browser


@pytest.mark.slow
def test_a_hostile_page_in_the_same_browser_gets_nothing_even_with_the_token() -> None:
    """The page comes from the same server under another name; so nothing but name and origin is wrong."""
    hostile = """async ([address, socket]) => {
        const found = [];
        try { found.push((await fetch(address, { mode: "cors" })).status); } catch (error) { found.push("no answer"); }
        found.push(await new Promise((resolve) => {
            const made = new WebSocket(socket);
            made.onopen = () => { made.send(JSON.stringify({ do: "reset" })); resolve("open"); };
            made.onerror = () => resolve("refused");
        }));
        return found;
    }"""

    async def check(served: Served) -> None:
        token, port = served.server.token, served.server.port

        def attack() -> None:
            with _rebinding_browser() as browser:
                page = browser.new_page()
                response = page.goto(f"http://evil.example:{port}/?token={token}")
                assert response is not None
                assert response.status == 403
                for name in ("127.0.0.1", "evil.example"):
                    asked = [f"http://{name}:{port}/?token={token}", f"ws://{name}:{port}/live?token={token}"]
                    answered = page.evaluate(hostile, asked)
                    assert answered == ["no answer" if name == "127.0.0.1" else 403, "refused"]

        await asyncio.to_thread(attack)
        assert served.asked == []

    serving(check)
