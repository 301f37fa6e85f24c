"""``haul view``: the live page, from topics to browsers, on one thread."""

from __future__ import annotations

import asyncio
import json
import signal
from collections.abc import Callable
from os import getpid
from typing import Any

import rclpy

from haul_ros.errors import CommandError
from haul_ros.page.server import PageServer
from haul_ros.ros.context import ros_client_context
from haul_ros.ros.view.desk import Desk
from haul_ros.ros.view.watcher import TrainWatcher

FRAME_PERIOD = 0.1
"""Wall time [s] from one frame to the next."""
_ANSWER_PERIOD = 0.02
"""Between two looks for answers of services."""


def serve(name: str | None, port: int, *, drive: bool, tell: Callable[[str], None]) -> None:
    """Serve the live page of the node ``name``, None: of any, until SIGINT, SIGTERM or SIGHUP; ``tell`` its address.

    Raises
    ------
    ServerError
        The port cannot be had.
    RosError
        ROS cannot be started.
    """
    with ros_client_context(["haul_view"]):
        asyncio.run(_View(name, drive=drive).serve(port, tell))


class _View:
    def __init__(self, name: str | None, *, drive: bool) -> None:
        # Without services of their own: nobody shall set parameters of a page
        made: dict[str, Any] = {"enable_rosout": False, "start_parameter_services": False}
        self._node = rclpy.create_node(f"haul_view_{getpid()}", **made)
        self._watcher = TrainWatcher(self._node, name, self._tell_browsers, drive=drive)
        self._desk = None
        if drive:
            self._desk_node = rclpy.create_node(f"haul_desk_{getpid()}", **made)
            self._desk = Desk(self._desk_node)
        self._server: PageServer | None = None

    async def serve(self, port: int, tell: Callable[[str], None]) -> None:
        ended = asyncio.Event()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            asyncio.get_running_loop().add_signal_handler(number, ended.set)
        contents: dict[str, object] = {"live": True, "title": "haul view", "description": ""}
        self._server = PageServer(port, contents, self._watcher.greeting, self._answer)
        tell(self._server.address)
        tasks = [asyncio.create_task(_repeat(self._poll, FRAME_PERIOD))]
        if self._desk:
            tasks.append(asyncio.create_task(_repeat(self._desk.spin, _ANSWER_PERIOD)))
        end = asyncio.create_task(ended.wait())
        done, _ = await asyncio.wait([*tasks, end], return_when=asyncio.FIRST_COMPLETED)
        self._server.close()
        for task in [*tasks, end]:
            task.cancel()
        self._watcher.close()
        if self._desk:
            self._desk.close()
        for task in done:
            task.result()  # an error of a task is one of the program

    def _poll(self) -> None:
        self._watcher.poll()
        if self._desk:
            self._desk.face(self._watcher.train)

    def _tell_browsers(self, message: str | bytes) -> None:
        if self._server:
            self._server.send(message)

    async def _answer(self, asked: dict[str, Any]) -> str | None:
        if asked.get("do") == "watch":
            self._watcher.choose(str(asked.get("node")))
            return None
        try:
            if self._desk is None:
                raise CommandError("this page only looks: haul view --drive gives a desk")
            done, text = True, await self._desk.carry_out(asked)
        except CommandError as error:
            done, text = False, str(error)
        return json.dumps({"is": "answer", "done": done, "text": text})


async def _repeat(action: Callable[[], None], period: float) -> None:
    loop = asyncio.get_running_loop()
    due = loop.time()
    while True:
        action()
        due = max(due + period, loop.time())
        await asyncio.sleep(due - loop.time())
