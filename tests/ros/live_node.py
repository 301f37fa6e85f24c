"""A node in a process of its own, and what a test needs to talk to it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import rclpy
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import SetBool, Trigger

import haul_ros
from haul_ros.messages.channels import Channel, ChannelTable, channel_table
from haul_ros.model.command import Command, CommandKind
from haul_ros.ros.publishers import endpoint
from tests.waiting import WAIT

LOCOMOTIVES = ("master", "slave_1", "slave_2", "slave_3")
TABLE = channel_table(LOCOMOTIVES)


class LiveNode:
    """The node as users start it, in a folder of its own."""

    def __init__(
        self,
        folder: Path,
        log: Path,
        parameters: Mapping[str, object],
        *,
        ros_arguments: Sequence[str] = (),
        file_size_limit: int = 0,
        prelude: str = "",
    ) -> None:
        self.folder = folder
        self._log = log
        assignments = [f"{name}:={_yaml(value)}" for name, value in parameters.items()]
        given = (part for assignment in assignments for part in ("-p", assignment))
        arguments = ["--ros-args", *given, *ros_arguments]
        code = "import sys; from haul_ros.ros.node import main; sys.exit(main())"
        if file_size_limit:
            limits = (file_size_limit, file_size_limit)
            code = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, {limits}); {code}"
        code = f"{prelude}\n{code}"
        sources = str(Path(haul_ros.__path__[0]).parent)
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(filter(None, [sources, os.getenv("PYTHONPATH")])),
            "PYTHONFAULTHANDLER": "1",  # a crash of compiled code tells in the log where it was
        }
        with log.open("w") as stderr:
            self.process = subprocess.Popen(
                [sys.executable, "-c", code, *arguments], cwd=folder, env=environment, stderr=stderr
            )

    @property
    def log(self) -> str:
        """What the node has written to its standard error."""
        return self._log.read_text()

    def wait_for_end(self) -> int:
        """Exit status."""
        return self.process.wait(WAIT)

    def end(self, signal_number: int = signal.SIGTERM) -> int:
        """Tell the node to end; returns its exit status."""
        self.process.send_signal(signal_number)
        return self.wait_for_end()

    def leave_nothing_running(self) -> None:
        """End the process, whatever happened."""
        self.process.terminate()
        try:
            self.process.wait(WAIT)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def _yaml(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


class Observer:
    """Another participant: subscribes, commands, calls services."""

    def __init__(self) -> None:
        self._context = Context()
        self._context.init()
        self._node = rclpy.create_node("observer", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._publishers: dict[str, Any] = {}

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    def wait_until(self, condition: Callable[[], bool], what: str) -> None:
        """Receive until the condition holds."""
        end = time.monotonic() + WAIT
        while not condition():
            assert time.monotonic() < end, f"waited {WAIT:g} s in vain for {what}"
            self._executor.spin_once(timeout_sec=0.05)

    def watch(self, channel: Channel) -> list[bytes]:
        """Subscribe; what is received goes into the returned list, serialised as it came."""
        received: list[bytes] = []
        self.listen(channel, received.append)
        return received

    def listen(self, channel: Channel, take: Callable[[bytes], None]) -> None:
        """Subscribe; ``take`` is called with what is received, serialised as it came."""
        self._node.create_subscription(*endpoint(channel)[:2], take, endpoint(channel)[2], raw=True)

    def receive_for(self, seconds: float) -> None:
        """Receive for so long [s]."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=min(left, 0.05))

    def watch_typed(self, channel: Channel) -> list[Any]:
        """Subscribe; what is received goes into the returned list, as messages."""
        received: list[Any] = []
        self._node.create_subscription(*endpoint(channel)[:2], received.append, endpoint(channel)[2])
        return received

    def watch_on(self, topic: str, channel: Channel) -> list[Any]:
        """The same of a channel on a topic of another name."""
        received: list[Any] = []
        message_type, _, qos = endpoint(channel)
        self._node.create_subscription(message_type, topic, received.append, qos)
        return received

    def publish_on(self, topic: str, channel: Channel, value: float, latched: Channel) -> None:
        """Publish a number on a topic of another name than its channel's, once the node knows this publisher.

        Which it does before a subscription of something ``latched`` that is made later.
        """
        message_type, _, qos = endpoint(channel)
        publisher = self._node.create_publisher(message_type, topic, qos)
        heard = self.watch(latched)
        self.wait_until(lambda: bool(heard), f"a message from the node of {topic}")
        self.wait_until(lambda: publisher.get_subscription_count() > 0, f"a subscriber of {topic}")
        message = message_type()
        message.data = value
        publisher.publish(message)

    def offered(self, channel: Channel) -> list[str]:
        """The reliability that each publisher of a topic offers."""
        found = self._node.get_publishers_info_by_topic(channel.topic)
        return [info.qos_profile.reliability.name for info in found]

    def subscribers_of(self, channel: Channel) -> int:
        """How many subscriptions of a topic have been found."""
        return int(self._node.count_subscribers(channel.topic))

    def graph_of(self, node: str) -> dict[str, list[str]]:
        """Full names of what a node publishes, subscribes and replies to."""
        found = {
            "publish": self._node.get_publisher_names_and_types_by_node(node, "/"),
            "subscribe": self._node.get_subscriber_names_and_types_by_node(node, "/"),
            "reply": self._node.get_service_names_and_types_by_node(node, "/"),
        }
        return {act: [name for name, _ in names] for act, names in found.items()}

    def get_ready_to_send(self, locomotive: str, kind: CommandKind, table: ChannelTable = TABLE) -> Any:
        """The publisher of a command, once the node knows it (which it does before a subscription made later)."""
        message_type, topic, qos = endpoint(table.commands[kind][locomotive])
        if topic not in self._publishers:
            self._publishers[topic] = self._node.create_publisher(message_type, topic, qos)
            heard = self.watch(table.applied_brake[locomotive])
            self.wait_until(lambda: bool(heard), f"a message from the node of {topic}")
        publisher = self._publishers[topic]
        self.wait_until(lambda: publisher.get_subscription_count() > 0, f"a subscriber of {topic}")
        return publisher

    def send(self, locomotive: str, kind: CommandKind, value: float | bool, table: ChannelTable = TABLE) -> None:
        """Publish a command, once the node knows its publisher."""
        publisher = self.get_ready_to_send(locomotive, kind, table)
        message = endpoint(table.commands[kind][locomotive])[0]()
        message.data = value
        publisher.publish(message)

    def send_fault(self, channel: Channel, value: int | list[float]) -> None:
        """Publish a fault, once a subscriber of it is there."""
        message_type, topic, qos = endpoint(channel)
        if topic not in self._publishers:
            self._publishers[topic] = self._node.create_publisher(message_type, topic, qos)
        publisher = self._publishers[topic]
        self.wait_until(lambda: publisher.get_subscription_count() > 0, f"a subscriber of {topic}")
        publisher.publish(message_type(data=value))

    def call(self, service_type: Any, name: str, request: Any) -> Any:
        """Call a service of the node."""
        client = self._node.create_client(service_type, f"{TABLE.prefix}/{name}")
        self.wait_until(client.service_is_ready, f"service {name}")
        future = client.call_async(request)
        self.wait_until(future.done, f"the answer of {name}")
        self._node.destroy_client(client)
        return future.result()

    def pause(self, paused: bool = True) -> Any:
        """Pause, or go on."""
        return self.call(SetBool, "pause", SetBool.Request(data=paused))

    def step(self) -> Any:
        """One period."""
        return self.call(Trigger, "step", Trigger.Request())

    def reset(self) -> Any:
        """From the start."""
        return self.call(Trigger, "reset", Trigger.Request())

    def set_parameter(self, name: str, value: float | bool | str) -> Any:
        """The result of setting one parameter."""
        if isinstance(value, bool):
            typed = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=value)
        elif isinstance(value, int):
            typed = ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=value)
        elif isinstance(value, str):
            typed = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=value)
        else:
            typed = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
        request = SetParameters.Request(parameters=[ParameterMessage(name=name, value=typed)])
        return self.call(SetParameters, "set_parameters", request).results[0]

    def parameter(self, name: str) -> Any:
        """A parameter's value as the message has it."""
        return self.call(GetParameters, "get_parameters", GetParameters.Request(names=[name])).values[0]


class Couplers:
    """The couplers' topic, decoded as far as the simulation time of the newest message."""

    def __init__(self, observer: Observer) -> None:
        self.received = observer.watch_typed(TABLE.couplers)
        self._observer = observer

    @property
    def time_ns(self) -> int:
        """Simulation time [ns] of the newest sample; -1: none yet."""
        if not self.received:
            return -1
        stamp = self.received[-1].header.stamp
        return int(stamp.sec * 10**9 + stamp.nanosec)

    def wait_for_time(self, time_ns: int) -> None:
        """Receive until the simulation is there."""
        self._observer.wait_until(lambda: self.time_ns >= time_ns, f"simulation time {time_ns} ns")


def brake(locomotive: str, demand: float) -> Command:
    """A service brake command."""
    return Command(locomotive, CommandKind.BRAKE, demand)
