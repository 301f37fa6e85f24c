"""Serves the live page to browsers on this machine, and to nobody whom another page in them has sent.

Everything needs the token, compared in constant time, which only the printed address has. Another name for the address
(DNS rebinding) is refused by the Host header, another page by the Origin header, which browsers set themselves. There
are no cookies, no headers that let other origins in, and nothing but the socket changes anything.
"""

from __future__ import annotations

import errno
import hmac
import json
import secrets
from collections.abc import Awaitable, Callable, Iterable
from typing import Any

from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPServerRequest
from tornado.netutil import bind_sockets
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from haul_ros.errors import HaulError
from haul_ros.page.document import page
from haul_ros.page.train import Message

LOOPBACK = "127.0.0.1"
MOST_BROWSERS = 8
_LONGEST_REQUEST = 4096
"""Bytes of what a browser may ask over the socket."""
_MOST_WAITING = 100
"""Messages that a browser may leave untaken before it is let go; it may come again."""
_HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}

Greet = Callable[[], Iterable[Message]]
Answer = Callable[[dict[str, Any]], Awaitable[Message | None]]


class ServerError(HaulError):
    """A page that cannot be served."""


class PageServer:
    """Serves one page and a socket; to be made and used on the thread of a running asyncio loop.

    ``greet`` gives the messages with which a browser that has just come is told what there is; ``answer`` is called
    with what one asks, an object of JSON, and gives what it alone is told. ``port`` 0: any that is free.

    Raises
    ------
    ServerError
        The port cannot be had.
    """

    def __init__(self, port: int, contents: dict[str, object], greet: Greet, answer: Answer) -> None:
        self.token = secrets.token_urlsafe(24)
        try:
            sockets = bind_sockets(port, LOOPBACK)
        except (OSError, OverflowError) as error:
            taken = isinstance(error, OSError) and error.errno == errno.EADDRINUSE
            what = "is in use, expected one that is free" if taken else "cannot be had"
            raise ServerError(f"--port {port}: {what}") from error
        self.port: int = sockets[0].getsockname()[1]
        self.hosts = (f"{LOOPBACK}:{self.port}", f"localhost:{self.port}")
        self._contents, self.greet, self.answer = contents, greet, answer
        self.browsers: set[_Socket] = set()
        shared = {"server": self}
        routes = [("/", _Page, shared), ("/live", _Socket, shared)]
        self._server = HTTPServer(
            Application(
                routes,
                log_function=lambda _: None,  # a log would have the token
                websocket_max_message_size=_LONGEST_REQUEST,
                websocket_ping_interval=20,
                websocket_ping_timeout=20,
            ),
            max_body_size=0,
            max_header_size=16 * 1024,
        )
        self._server.add_sockets(sockets)

    @property
    def address(self) -> str:
        """Of the page, with the token."""
        return f"http://{self.hosts[0]}/?token={self.token}"

    def send(self, message: Message) -> None:
        """Send to every browser."""
        for browser in list(self.browsers):
            browser.send(message)

    def close(self) -> None:
        """Let everybody go."""
        self._server.stop()
        for browser in list(self.browsers):
            browser.close()

    def refusal(self, request: HTTPServerRequest, token: str) -> str | None:
        """Why a request is not answered, None: it is."""
        if request.host not in self.hosts:
            return "the page is asked for by another name"
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return "the address has not the token which haul view has printed"
        return None

    def document(self, host: str) -> str:
        """The page for one of the hosts."""
        return page(self._contents, connect=f"ws://{host}")


class _Guarded(RequestHandler):
    """Answers only who may ask."""

    def initialize(self, server: PageServer) -> None:
        self.server = server

    def set_default_headers(self) -> None:
        for name, value in _HEADERS.items():
            self.set_header(name, value)
        self.clear_header("Server")

    def prepare(self) -> None:
        if refusal := self.server.refusal(self.request, self.get_query_argument("token", "")):
            raise HTTPError(403, reason=refusal)

    def write_error(self, status_code: int, **_: Any) -> None:
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"{status_code}: {self._reason}\n")


class _Page(_Guarded):
    def get(self) -> None:
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.set_header("Content-Security-Policy", "frame-ancestors 'none'")
        self.finish(self.server.document(self.request.host))


class _Socket(_Guarded, WebSocketHandler):
    def prepare(self) -> None:
        super().prepare()
        if self.request.headers.get("Origin") != f"http://{self.request.host}":
            raise HTTPError(403, reason="another page asks")
        if len(self.server.browsers) >= MOST_BROWSERS:
            raise HTTPError(503, reason=f"{MOST_BROWSERS} browsers look already")

    def check_origin(self, origin: str) -> bool:
        return origin == f"http://{self.request.host}"

    def open(self, *_: str, **__: str) -> None:
        self.set_nodelay(True)
        self._waiting = 0
        self.server.browsers.add(self)
        for message in self.server.greet():
            self.send(message, waits=False)

    def on_close(self) -> None:
        self.server.browsers.discard(self)

    async def on_message(self, message: str | bytes) -> None:
        try:
            asked = json.loads(message)
        except (ValueError, RecursionError):
            asked = None
        if not isinstance(asked, dict):
            self.close(1003, "expected an object of JSON")
            return
        if (answer := await self.server.answer(asked)) is not None:
            self.send(answer)

    def send(self, message: Message, *, waits: bool = True) -> None:
        if waits and self._waiting > _MOST_WAITING:
            self.close(1013, "too slow")
            return
        try:
            sent = self.write_message(message, binary=isinstance(message, bytes))
        except WebSocketClosedError:
            return
        self._waiting += 1
        sent.add_done_callback(self._sent)

    def _sent(self, done: Any) -> None:
        self._waiting -= 1
        done.exception()  # the browser has gone
