"""What can be wrong with ROS itself, said in one line; importable where there is no ROS."""

from __future__ import annotations

from importlib import import_module

from haul_ros.errors import HaulError

INSTALL_HINT = "install it with: pip install 'haul_ros[ros]', or source ROS 2 Jazzy"

_PACKAGES = ("rclpy", "std_msgs", "std_srvs", "sensor_msgs", "diagnostic_msgs", "rosgraph_msgs")


class RosError(HaulError):
    """ROS is missing, or cannot be started as asked."""


def require_ros() -> None:
    """Refuse to go on where rclpy or a message package is missing.

    Raises
    ------
    RosError
        Says what is missing and how to get it.
    """
    for package in _PACKAGES:
        try:
            import_module(package)
        except ImportError as error:
            raise RosError(f"ROS 2 is not usable here ({error}); {INSTALL_HINT}") from error
