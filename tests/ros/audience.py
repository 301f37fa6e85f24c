"""``python -m tests.ros.audience N TOPIC ...``: N reliable subscribers of topics of the node; SIGTERM ends them.

Prints a line when the first message has come, and at the end one as JSON: of each subscription of the couplers how many
samples it received, and how many were not one sample period after the one before.
"""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

from haul_ros.ros.publishers import endpoint
from haul_ros.units import NS_PER_S
from tests.ros.live_node import TABLE


def stamp_of(message: bytes) -> int:
    """Simulation time [ns] in a header: seconds and nanoseconds, behind the 4 bytes of the encapsulation."""
    seconds, nanoseconds = struct.unpack_from("<iI", message, 4)
    return int(seconds) * NS_PER_S + int(nanoseconds)


@dataclass(slots=True)
class Samples:
    """Counts the samples of one subscription; the period is that between its first two."""

    received: int = 0
    misplaced: int = 0
    _last_ns: int = 0
    _period_ns: int = 0

    def take(self, message: bytes) -> None:
        """One sample more."""
        time_ns = stamp_of(message)
        if self.received == 1:
            self._period_ns = time_ns - self._last_ns
        self.misplaced += self.received > 1 and time_ns != self._last_ns + self._period_ns
        self._last_ns = time_ns
        self.received += 1


def main() -> None:
    """Until it is ended or killed."""
    rclpy.init()
    executor = SingleThreadedExecutor()
    counted: list[Samples] = []
    found: list[bool] = []

    def told(take: Callable[[bytes], None]) -> Callable[[bytes], None]:
        def callback(message: bytes) -> None:
            if not found:
                found.append(True)
                print("found", flush=True)
            take(message)

        return callback

    for number in range(int(sys.argv[1])):
        node = rclpy.create_node(f"audience_{number}", start_parameter_services=False)
        for channel in (channel for channel in TABLE if channel.topic in sys.argv[2:]):
            samples = Samples()
            if channel is TABLE.couplers:
                counted.append(samples)
            take = told(samples.take if channel is TABLE.couplers else lambda _: None)
            node.create_subscription(*endpoint(channel)[:2], take, endpoint(channel)[2], raw=True)
        executor.add_node(node)
    try:
        executor.spin()
    except ExternalShutdownException:
        print(json.dumps([asdict(samples) for samples in counted]), flush=True)


if __name__ == "__main__":
    main()
