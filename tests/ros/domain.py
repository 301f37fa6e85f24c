"""A ROS domain of one's own, on this machine alone."""

from __future__ import annotations

import os


def own_domain() -> dict[str, str]:
    """Environment of processes that meet each other, and nobody else who runs at the same time."""
    return {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(1 + os.getpid() % 100),
        # Loopback alone: shared memory left behind by a process that was killed can swallow messages
        "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
    }
