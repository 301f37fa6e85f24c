"""``haul node`` and ``haul brake``: handed over to the ROS side."""

from __future__ import annotations

import argparse
import json
import re

from haul_ros.errors import HaulError
from haul_ros.model.command import Command, CommandKind
from haul_ros.ros import node as ros_node
from haul_ros.ros.errors import require_ros

_NODE = re.compile("(/[A-Za-z_][A-Za-z0-9_]*)+")
_LOCOMOTIVE = re.compile("master|slave_[1-9][0-9]{0,3}")


class ArgumentError(HaulError):
    """An argument that the node could not understand."""


def node(arguments: argparse.Namespace) -> int:
    """Run the live node until SIGINT, SIGTERM or SIGHUP, which end it with status 0."""
    return ros_node.main(node_arguments(arguments))


def node_arguments(arguments: argparse.Namespace) -> list[str]:
    """The same request in arguments of ROS.

    Raises
    ------
    ArgumentError
        A parameter is not of the form NAME:=VALUE.
    """
    parameters = []
    # In quotes, a path like 12 stays text
    if arguments.scenario is not None:
        parameters.append(f"scenario:={json.dumps(arguments.scenario)}")
    if arguments.record is not None:
        parameters.append(f"record_path:={json.dumps(arguments.record)}")
    for parameter in arguments.parameters:
        name, assigned, _ = parameter.partition(":=")
        if not (name and assigned):
            raise ArgumentError(f"--param {parameter}: expected NAME:=VALUE, such as radio.slave_1.delay:=0.5")
        parameters.append(parameter)
    given = [item for parameter in parameters for item in ("-p", parameter)]
    return [*(["--ros-args", *given] if given else []), *arguments.ros_arguments]


def brake(arguments: argparse.Namespace) -> int:
    """Send one brake command and wait until the node has it."""
    command = brake_command(arguments)
    command.check()
    name = node_name(arguments)
    require_ros()
    from haul_ros.ros.brake_client import publish_command  # needs rclpy

    publish_command(command, name)
    return 0


def node_name(arguments: argparse.Namespace) -> str:
    """The full name of the node that was asked for, with or without the slash before it.

    Raises
    ------
    ArgumentError
        No node can have that name.
    """
    name = f"/{arguments.node.removeprefix('/')}"
    if not _NODE.fullmatch(name):
        raise ArgumentError(f"--node {arguments.node!r}: expected the full name of a node, such as /train_a/haul")
    return name


def brake_command(arguments: argparse.Namespace) -> Command:
    """The command that was asked for.

    Raises
    ------
    ArgumentError
        The locomotive cannot be one.
    """
    if not _LOCOMOTIVE.fullmatch(arguments.locomotive):
        raise ArgumentError(f"locomotive {arguments.locomotive!r}: expected master, slave_1, slave_2 ...")
    if arguments.demand is not None:
        return Command(arguments.locomotive, CommandKind.BRAKE, arguments.demand)
    return Command(arguments.locomotive, CommandKind.EMERGENCY, 1.0 if arguments.emergency else 0.0)
