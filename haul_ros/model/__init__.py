"""The train as data: frozen dataclasses in SI units, without files, clocks or ROS."""
