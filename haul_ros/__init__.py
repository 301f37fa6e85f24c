"""Longitudinal dynamics of heavy-haul trains in real time, for ROS 2."""

__version__ = "0.1.0"
