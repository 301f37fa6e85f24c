"""A ROS domain of one's own, on this machine alone."""

from __future__ import annotations

import os


def own_domain() -> dict[str, str]:
    """Environment of processes that meet each other, and nobody else who runs at the same time."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")  # such as gw1: each has another domain than its neighbours
    run, number = (os.getppid(), int(worker.removeprefix("gw"))) if worker else (os.getpid(), 0)
    return {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(1 + (run + 33 * number) % 100),
        # Loopback alone: shared memory left behind by a process that was killed can swallow messages
        "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
    }
