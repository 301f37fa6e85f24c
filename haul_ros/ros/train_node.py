"""The node ``haul``: topics, parameters and services wired to the loop that simulates the train."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from datetime import UTC, datetime
from functools import partial
from math import inf
from pathlib import Path
from time import monotonic, sleep
from typing import Any, cast

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.utilities import ok, remove_ros_args
from std_srvs.srv import SetBool, Trigger

from haul_ros.errors import CommandError, HaulError
from haul_ros.messages.cdr import encode_string
from haul_ros.messages.channels import ChannelTable
from haul_ros.messages.encoder import Message, TelemetryEncoder
from haul_ros.messages.requests import fault_of
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.fault import Fault, FaultKind
from haul_ros.model.request import Request
from haul_ros.model.scenario import Scenario
from haul_ros.physics.train_model import COMPILING, kernel_is_cached
from haul_ros.recording.writer import McapRecorder
from haul_ros.ros.context import ros_node_context, shut_down
from haul_ros.ros.diagnostics import starting
from haul_ros.ros.errors import RosError
from haul_ros.ros.loop import SimulationLoop
from haul_ros.ros.parameters import NO_RECORDING, ParameterError
from haul_ros.ros.publishers import Publishers, endpoint
from haul_ros.ros.recordings import recording_path
from haul_ros.ros.repeating import repeated
from haul_ros.ros.run import TrainRun
from haul_ros.ros.settings import NodeSettings
from haul_ros.ros.signals import EndingSignals
from haul_ros.ros.unrecorded import Unrecorded, UnrecordedRates, state_channel
from haul_ros.simulation.session import Session
from haul_ros.units import NS_PER_S, mps_to_kmh

NODE_NAME = "haul"

_LONGEST_SPIN = 0.5
"""Longest wait [s] of the executor: rclpy may shut down on a signal without waking it."""
_ANSWER_TIMEOUT = 10.0
"""Longest time [s] that a service waits for the loop."""
_FLOOD = 20
"""Commands within `_FLOOD_WINDOW` after which each further one lets the simulation's thread run for a while."""
_FLOOD_WINDOW = 0.02
_BREATH = 0.001
"""Wall time [s] of that."""
_NAMESAKES_PERIOD = 5.0
"""Wall time [s] between two looks for another node of the same name."""
_TOLD_AGAIN = 1.0
"""Wall time [s] after which it is told again that the model is being compiled."""
_WARNING_PERIOD = 1.0
"""Shortest time [s] between two warnings about the requests of one source."""


def run_node(argv: Sequence[str], signals: EndingSignals) -> int:
    """Run the node with the ROS arguments in ``argv`` until it is to end; returns the exit status.

    Raises
    ------
    HaulError
        Arguments, parameters, scenario or recording cannot be used; nothing was started.
    KeyboardInterrupt
        A signal has come while the node started.
    """
    with ros_node_context(argv):
        if surplus := remove_ros_args(list(argv))[1:]:
            raise RosError(f"unexpected argument {surplus[0]!r}; parameters are given as --ros-args -p name:=value")
        try:
            node = TrainNode(on_end=shut_down)
            signals.started(shut_down)
            try:
                return node.run() if ok() and not signals.taken else 0
            finally:
                cast(Any, node).destroy_node()
        except RuntimeError:  # RCLError, if ROS was shut down while the node started
            if ok():
                raise
            return 0


class TrainNode(Node):
    """A live train: the executor's thread receives requests, the loop's thread simulates, publishes and records.

    `run` does all; or `start` it, put it into an executor of one's own, and `stop` it in the end. ``on_end`` is called
    when the simulation has ended, on its thread; ``options`` are those of `rclpy.node.Node`, such as ``namespace`` and
    ``parameter_overrides``. Several nodes in one process share its Python interpreter.

    Raises
    ------
    HaulError
        Parameters or scenario cannot be used.
    """

    def __init__(
        self, node_name: str = NODE_NAME, *, on_end: Callable[[], None] = lambda: None, **options: Any
    ) -> None:
        self._on_end = on_end
        try:
            super().__init__(node_name, automatically_declare_parameters_from_overrides=True, **options)
        except ValueError as error:  # of a parameter such as [], which has no type
            raise ParameterError(f"a parameter has no value: {error}") from error
        except RuntimeError as error:  # RCLError: no such enclave, a DDS without its security, or a shutdown
            if not ok(context=options.get("context")):
                raise
            raise RosError(f"the node cannot be made: {str(error).partition(', at ')[0]}") from error
        self._log: RcutilsLogger = cast(Any, self).get_logger()
        self._settings = NodeSettings(self)
        scenario = self._settings.scenario
        self._encoder = self._new_encoder(scenario)
        self._state = state_channel(self.get_fully_qualified_name())
        self._outlet = self._create_publishers()
        self._warned: dict[str, float] = {}
        self._last_reset = -inf
        self._recordings = 1
        self._window_began, self._in_window = 0.0, 0
        self._look_at = 0.0
        self._subscribe()
        self.create_service(SetBool, "~/pause", self._pause)
        self.create_service(Trigger, "~/step", self._step)
        self.create_service(Trigger, "~/reset", self._reset)
        self.add_post_set_parameters_callback(self._apply_parameters)
        self._compile(scenario)

    def run(self) -> int:
        """Simulate until ROS is shut down or the simulation fails; returns the exit status.

        Raises
        ------
        RecordingError
            There can be no such recording; nothing was started.
        """
        self.start()
        try:
            self._spin()
        finally:
            status = self.stop()
        return status

    def start(self) -> None:
        """Begin to simulate, before the node is put into an executor.

        Raises
        ------
        RecordingError
            There can be no such recording; nothing was started.
        """
        scenario = self._settings.scenario
        self._loop = SimulationLoop(
            self._new_run(scenario),
            round(NS_PER_S / scenario.sample_rate),
            self._settings.number("real_time_factor"),
            on_rejected=self._warn_rejected,
            on_end=self._on_end,
            on_state=self._tell_state,
        )
        self._loop.start()

    def stop(self) -> int:
        """End the simulation and finish its recording; 0, or 1 and on standard error what has failed."""
        self._loop.stop()
        return 0 if self._loop.failure is None else _print_failure(self._loop.failure)

    def _spin(self) -> None:
        try:
            executor = _Executor()
            executor.add_node(self)
            while self.context.ok():
                executor.spin_once(timeout_sec=_LONGEST_SPIN)
                self._warn_of_namesakes()
        except ExternalShutdownException:
            pass
        except (
            RuntimeError,
            TypeError,
        ):  # if the shutdown came between two waits: RCLError; at once: no handle any more
            if self.context.ok():
                raise

    def _compile(self, scenario: Scenario) -> None:
        """Compile where needed, while nothing is open yet and a signal can still interrupt."""
        if kernel_is_cached():
            return
        self._log.info(COMPILING)
        self._tell_state("compiling")
        status = starting(self.get_fully_qualified_name(), scenario.name, COMPILING)
        with repeated(lambda: self._outlet.publish([self._encoder.diagnostics(0, [status])]), _TOLD_AGAIN):
            Session(scenario)

    def _new_encoder(self, scenario: Scenario) -> TelemetryEncoder:
        def adapted(table: ChannelTable) -> ChannelTable:
            return self._settings.with_qos_overrides(table.resolved(self.resolve_topic_name))

        try:
            return TelemetryEncoder.of(scenario, self.get_fully_qualified_name(), adapted)
        except ValueError as error:
            raise RosError(f"{error}: a recording could not tell them apart") from error

    def _create_publishers(self) -> Publishers:
        telemetry = (channel for channel in self._encoder.channels if not channel.received)
        return Publishers(self, [*telemetry, *self._new_unrecorded().channels, self._state])

    def _new_unrecorded(self) -> Unrecorded:
        number, every_sample = self._settings.number, inf
        rates = UnrecordedRates(
            clock=(number("clock_rate") or every_sample) if self._settings.flag("publish_clock") else 0.0,
            force_image=number("force_image_rate"),
            train_markers=number("train_markers_rate"),
        )
        scenario, name = self._settings.scenario, self.get_fully_qualified_name()
        return Unrecorded(scenario.consist, name, rates, lambda: number("picture_force"))

    def _tell_state(self, state: str) -> None:
        self._outlet.publish([Message(self._state, 0, encode_string(state))])

    def _subscribe(self) -> None:
        for kind, by_locomotive in self._encoder.channels.commands.items():
            for locomotive, channel in by_locomotive.items():
                message_type, topic, qos = endpoint(channel)
                self.create_subscription(message_type, topic, partial(self._on_command, locomotive, kind), qos)
        for fault, channel in self._encoder.channels.faults.items():
            message_type, topic, qos = endpoint(channel)
            self.create_subscription(message_type, topic, partial(self._on_fault, fault), qos)

    def _new_run(self, scenario: Scenario, *, again: bool = False) -> TrainRun:
        session = Session(scenario, play_commands=self._settings.flag("scenario_commands"))
        recording = recording_path(self._settings.text("record_path"), scenario.name, datetime.now(UTC), again=again)
        recorder = self._new_recorder(scenario, recording) if recording else None
        train = f"{len(scenario.consist.vehicles)} vehicles at {mps_to_kmh(scenario.initial_speed):.1f} km/h"
        output = f"recording to {recording}" if recording else "not recording"
        self._log.info(f"{'reset: ' if again else ''}{scenario.name}: {train}, {output}")
        return TrainRun(
            session,
            self._encoder,
            self._outlet.publish,
            recorder,
            unrecorded=self._new_unrecorded(),
            tell=self._tell_of_end,
        )

    def _tell_of_end(self, what: str) -> None:
        if ok(context=self.context):
            self._log.info(what)
        else:  # the node's own logger would publish on /rosout, and complain that it cannot any more
            get_logger(f"{self._log.name}.recorder").info(what)

    def _new_recorder(self, scenario: Scenario, path: Path) -> McapRecorder:
        # As fast as possible there is no time to lose by waiting for the disk, in real time there is
        wait = self._settings.number("real_time_factor") == 0.0
        return McapRecorder(
            path,
            scenario,
            self._encoder.channels,
            compression=self._settings.text("record_compression"),
            when_full="block" if wait else "drop",
        )

    def _on_command(self, locomotive: str, kind: CommandKind, message: Any) -> None:
        self._loop.request(Command(locomotive, kind, float(message.data)))
        self._breathe()

    def _on_fault(self, kind: FaultKind, message: Any) -> None:
        self._loop.request(fault_of(kind, message.data))
        self._breathe()

    def _breathe(self) -> None:
        """In a flood of commands this thread would leave the simulation's too little of the interpreter."""
        now = monotonic()
        if now > self._window_began + _FLOOD_WINDOW:
            self._window_began, self._in_window = now, 0
        self._in_window += 1
        if self._in_window > _FLOOD:
            sleep(_BREATH)

    def _warn_of_namesakes(self) -> None:
        if (now := monotonic()) < self._look_at:
            return
        self._look_at = now + _NAMESAKES_PERIOD
        own = (self.get_name(), self.get_namespace())
        if self.get_node_names_and_namespaces().count(own) > 1:
            name = self.get_fully_qualified_name()
            self._log.warning(f"another node {name} is running: both take the same commands; give one a namespace")
            self._look_at = inf

    def _warn_rejected(self, request: Request, error: CommandError) -> None:
        if isinstance(request, Command):
            source = self._encoder.channels.commands[request.kind][request.locomotive].topic
            what = f"{source}: {request.value}"
        elif isinstance(request, Fault):
            source = what = self._encoder.channels.faults[request.kind].topic
        else:
            source = what = f"radio link to {request.slave}"
        if monotonic() >= self._warned.get(source, -inf) + _WARNING_PERIOD:
            self._warned[source] = monotonic()
            self._log.warning(f"{what} rejected: {error}")

    def _apply_parameters(self, parameters: Sequence[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == "real_time_factor":
                self._loop.set_real_time_factor(parameter.value)
            elif change := self._settings.link_change(parameter):
                self._loop.request(change)

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        return _answer(response, self._loop.pause(request.data))

    def _step(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return _answer(response, self._loop.step())

    def _reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if refusal := self._refuse_reset():
            response.success, response.message = False, refusal
            return response
        try:
            run = self._new_run(self._settings.scenario_again(), again=True)
        except HaulError as error:
            response.success, response.message = False, str(error)
            return response
        self._last_reset = monotonic()
        self._recordings += 1
        return _answer(response, self._loop.reset(run))

    def _refuse_reset(self) -> str:
        """Why there can be no reset now, empty: there can."""
        interval, most = self._settings.number("reset_interval"), int(self._settings.number("max_recordings"))
        if monotonic() < self._last_reset + interval:
            return f"refused: at most one reset in {interval:g} s (parameter reset_interval)"
        if self._settings.text("record_path") != NO_RECORDING and self._recordings >= most:
            return f"refused: {self._recordings} recordings were begun, which is all (parameter max_recordings)"
        return ""


class _Executor(SingleThreadedExecutor):
    """Can be thrown away half made, when ROS is shut down meanwhile: rclpy's own then says so with a traceback."""

    _sigint_gc = None  # type: ignore[assignment]


def _answer(response: Any, result: Future[str]) -> Any:
    try:
        response.success, response.message = True, result.result(timeout=_ANSWER_TIMEOUT)
    except TimeoutError:
        response.success, response.message = False, f"no answer from the simulation within {_ANSWER_TIMEOUT:g} s"
    except Exception as error:  # whatever it is, the loop ends the node for it where it must
        response.success, response.message = False, str(error)
    return response


def _print_failure(error: Exception) -> int:
    if isinstance(error, HaulError):
        print(f"train_node: {error}", file=sys.stderr)
    else:
        traceback.print_exception(error)
    return 1
