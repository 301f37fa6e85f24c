"""A driver's desk: what a browser asks for, to the node, over its topics, parameters and services alone."""

from __future__ import annotations

from asyncio import Future as AsyncFuture
from asyncio import get_running_loop, wait_for
from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from haul_ros.errors import CommandError, one_line
from haul_ros.messages.channels import channel_table
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.consist import MASTER
from haul_ros.model.radio import LONGEST_DELAY
from haul_ros.ros.publishers import endpoint
from haul_ros.ros.view.graph import FoundTrain

_PATIENCE = 12.0
"""Longest wait [s] for the answer of a service; the node itself waits for 10 s."""


class Desk:
    """Commands one train; `spin` often, for answers come by it."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        self._publishers: dict[tuple[str, CommandKind], Any] = {}
        self._clients: dict[str, Any] = {}
        self._train: FoundTrain | None = None
        self._pending = 0

    def face(self, train: FoundTrain | None) -> None:
        """Command this train from now on; it needs a moment to know who does."""
        if train is None or train == self._train:
            return
        self._leave()
        self._train = train
        for kind, by_locomotive in channel_table(train.locomotives, train.name).commands.items():
            for locomotive, channel in by_locomotive.items():
                self._publishers[locomotive, kind] = self._node.create_publisher(*endpoint(channel))
        services = {"pause": SetBool, "step": Trigger, "reset": Trigger, "set_parameters": SetParameters}
        for name, service in services.items():
            self._clients[name] = self._node.create_client(service, f"{train.name}/{name}")

    def spin(self) -> None:
        """Take answers that have come."""
        if self._pending:
            self._executor.spin_once(timeout_sec=0.0)

    def close(self) -> None:
        """Command no more."""
        self._leave()
        self._executor.shutdown()

    async def carry_out(self, asked: dict[str, Any]) -> str:
        """Do what was asked; what came of it, in words.

        Raises
        ------
        CommandError
            It is nothing that can be asked, or the node has refused it or does not answer.
        """
        does = asked.get("do")
        if self._train is None:
            raise CommandError("there is no train yet")
        if does == "command":
            return self._command(self._asked_command(asked))
        if does == "link":
            return await self._set_link(asked)
        if does == "pause" and isinstance(asked.get("value"), bool):
            return await self._service("pause", SetBool.Request(data=asked["value"]))
        if does in ("step", "reset"):
            return await self._service(does, Trigger.Request())
        raise CommandError(f"nothing that can be asked: {does!r:.40}")

    def _asked_command(self, asked: dict[str, Any]) -> Command:
        kinds = {kind.value: kind for kind in CommandKind}
        kind, locomotive, value = kinds.get(str(asked.get("kind"))), str(asked.get("locomotive")), asked.get("value")
        if kind is None or (locomotive, kind) not in self._publishers:
            raise CommandError("no such command or locomotive")
        command = Command(locomotive, kind, _number(value))
        command.check()
        return command

    def _command(self, command: Command) -> str:
        publisher = self._publishers[command.locomotive, command.kind]
        if not publisher.get_subscription_count():
            raise CommandError("the node is not there")
        message = publisher.msg_type()
        message.data = command.value != 0.0 if command.kind is CommandKind.EMERGENCY else command.value
        publisher.publish(message)
        return f"{command.locomotive}: {command.kind.value.replace('_', ' ')} {command.value:g} sent"

    async def _set_link(self, asked: dict[str, Any]) -> str:
        train, slave = self._train, asked.get("slave")
        if train is None or slave not in train.locomotives or slave == MASTER:
            raise CommandError("no such slave")
        parameters = []
        if "connected" in asked:
            value = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=asked["connected"] is True)
            parameters.append(ParameterMessage(name=f"radio.{slave}.connected", value=value))
        if "delay" in asked:
            delay = _number(asked["delay"])
            if not 0.0 <= delay <= LONGEST_DELAY:
                raise CommandError(f"delay {delay:g} s, must be 0 to {LONGEST_DELAY:g} s")
            value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=delay)
            parameters.append(ParameterMessage(name=f"radio.{slave}.delay", value=value))
        results = (await self._call("set_parameters", SetParameters.Request(parameters=parameters))).results
        if refused := [result.reason for result in results if not result.successful]:
            raise CommandError(one_line(refused[0]))
        return f"{slave}: link set"

    async def _service(self, name: str, request: Any) -> str:
        response = await self._call(name, request)
        if not response.success:
            raise CommandError(one_line(response.message))
        return one_line(response.message) or f"{name}: done"

    async def _call(self, name: str, request: Any) -> Any:
        client = self._clients[name]
        if not client.service_is_ready():
            raise CommandError("the node is not there")
        loop = get_running_loop()
        answered: AsyncFuture[Any] = loop.create_future()
        future = client.call_async(request)
        future.add_done_callback(_handing_over(answered))
        self._pending += 1
        try:
            return await wait_for(answered, _PATIENCE)
        except TimeoutError as error:
            client.remove_pending_request(future)
            raise CommandError(f"no answer from the node within {_PATIENCE:g} s") from error
        finally:
            self._pending -= 1

    def _leave(self) -> None:
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)
        for client in self._clients.values():
            self._node.destroy_client(client)
        self._publishers, self._clients = {}, {}


def _handing_over(answered: AsyncFuture[Any]) -> Callable[[Any], None]:
    def hand_over(future: Any) -> None:
        if not answered.done():
            answered.set_result(future.result())

    return hand_over


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise CommandError("expected a number")
    try:
        return float(value)
    except OverflowError as error:
        raise CommandError("a number beyond all bounds") from error
