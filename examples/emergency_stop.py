"""A 1+2+1 train of 20 000 t, live: started, braked over its topics, watched, recorded and analysed.

Three programs run, as they would on three machines: the node (``haul node``), this subscriber, and the
driver, who brakes with ``haul brake master --emergency``. The radio tells the slave locomotives late.
Afterwards the recording is analysed. Takes about 55 s, for the train brakes in real time.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

RADIO_DELAY_S = {"slave_1": 0.5, "slave_2": 0.5, "slave_3": 1.0}
COAST_S = 2.0
"""Simulation time at which the driver brakes."""
PATIENCE_S = 120.0
"""Longest time without any telemetry; the first start compiles the model."""


class Telemetry:
    """What a dashboard would know: the last couplers and vehicles, and who brakes since when."""

    def __init__(self, node: Node) -> None:
        self.couplers: JointState | None = None
        self.vehicles: JointState | None = None
        self.count = 0
        node.create_subscription(JointState, "/haul/couplers", self._on_couplers, 50)
        node.create_subscription(JointState, "/haul/vehicles", self._on_vehicles, 50)
        for locomotive in ("master", *RADIO_DELAY_S):
            topic = f"/haul/{locomotive}/applied_brake"
            node.create_subscription(Float64, topic, partial(self._on_brake, locomotive), 10)

    def _on_couplers(self, message: JointState) -> None:
        self.couplers = message
        self.count += 1

    def _on_vehicles(self, message: JointState) -> None:
        self.vehicles = message

    def _on_brake(self, locomotive: str, message: Float64) -> None:
        if message.data > 0.0:
            print(f"  {self.time:6.2f} s   {locomotive} applies its brake")

    @property
    def time(self) -> float:
        """Simulation time [s]."""
        if self.couplers is None:
            return 0.0
        stamp = self.couplers.header.stamp
        return float(stamp.sec + stamp.nanosec * 1e-9)

    @property
    def at_standstill(self) -> bool:
        """Every vehicle stands."""
        return self.vehicles is not None and not any(self.vehicles.velocity)

    def line(self) -> str | None:
        """One line on the train as it is now; None: nothing is known of it yet."""
        if self.couplers is None or self.vehicles is None:
            return None
        names, forces = self.couplers.name, self.couplers.effort
        buff, draft = max(forces), min(forces)
        return (
            f"  {self.time:6.2f} s   {self.vehicles.velocity[0] * 3.6:5.1f} km/h"
            f"   largest buff {buff / 1e3:6.1f} kN in {names[forces.index(buff)]}"
            f"   largest draft {abs(draft) / 1e3:6.1f} kN in {names[forces.index(draft)]}"
        )


def watch(
    telemetry: Telemetry, executor: SingleThreadedExecutor, node_process: subprocess.Popen[bytes], log: Path
) -> None:
    """Print a line every two seconds until the train stands; brake when it has coasted long enough."""
    driver: subprocess.Popen[bytes] | None = None
    next_line = 0.0
    last_news, seen = time.monotonic(), 0
    while not telemetry.at_standstill:
        executor.spin_once(timeout_sec=0.1)
        if telemetry.count != seen:
            last_news, seen = time.monotonic(), telemetry.count
        if node_process.poll() is not None or time.monotonic() - last_news > PATIENCE_S:
            sys.exit(f"emergency_stop: no telemetry from the node; its log is {log}")
        line = telemetry.line()
        if line is None:
            continue
        if driver is None and telemetry.time >= COAST_S:
            print("> haul brake master --emergency")
            driver = subprocess.Popen(["haul", "brake", "master", "--emergency"])
        if telemetry.time >= next_line:
            print(line, flush=True)
            next_line += 2.0
    print(f"  {telemetry.time:6.2f} s   the train stands; {telemetry.count} coupler messages received")
    if driver is not None and driver.wait(timeout=30.0) != 0:
        sys.exit("emergency_stop: the brake command failed")


def main() -> None:
    """Run the demonstration and leave recording and pictures in a new folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, help="new folder for the results (default: demo/<time>)")
    folder = parser.parse_args().output or Path("demo") / time.strftime("%Y-%m-%d_%H-%M-%S")
    try:
        folder.mkdir(parents=True)
    except OSError as error:
        print(f"emergency_stop: {folder}: {error.strerror}, expected a folder that can be made", file=sys.stderr)
        sys.exit(2)
    recording, log = folder / "emergency_stop.mcap", folder / "node.log"
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")

    command = ["haul", "node", "--scenario", "daqin_1_2_1", "--record", str(recording)]
    for slave, delay in RADIO_DELAY_S.items():
        command += ["--param", f"radio.{slave}.delay:={delay}"]
    print(">", " ".join(command))
    print("  (the first start compiles the model, half a minute or more)", flush=True)
    with log.open("w") as output:
        node_process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
    rclpy.init()
    listener = rclpy.create_node("dashboard")
    executor = SingleThreadedExecutor()
    executor.add_node(listener)
    try:
        watch(Telemetry(listener), executor, node_process, log)
    finally:
        node_process.send_signal(signal.SIGINT)
        status = node_process.wait(timeout=30.0)
        executor.shutdown()
        rclpy.shutdown()
    if status != 0:
        sys.exit(f"emergency_stop: the node ended with status {status}; its log is {log}")

    for command in (
        ["haul", "info", str(recording)],
        ["haul", "analyze", str(recording), "-o", str(folder / "analysis")],
    ):
        print("\n>", " ".join(command), flush=True)
        subprocess.run(command, check=True)
    print(f"\nLook at the pictures in {folder / 'analysis'}")


if __name__ == "__main__":
    main()
