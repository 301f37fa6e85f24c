"""Bags of a train's topics as other programs write them: by the mcap and rosbags libraries, from numbers given here."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import KW_ONLY, dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
WALL = 1_700_000_000 * 10**9
"""When the recorder began by its own clock [ns]."""


class BagMessage(NamedTuple):
    """What a recorder has of a message."""

    topic: str
    msgtype: str
    log_time: int
    data: bytes


def cdr(msgtype: str, *fields: Any, little_endian: bool = True) -> bytes:
    """Bytes of a message."""
    return bytes(STORE.serialize_cdr(STORE.types[msgtype](*fields), msgtype, little_endian=little_endian))


def _joints(
    stamp_ns: int, names: Sequence[str], arrays: Iterable[np.ndarray], frame: str, *, little_endian: bool
) -> bytes:
    time = STORE.types["builtin_interfaces/msg/Time"](*divmod(stamp_ns, 10**9))
    header = STORE.types["std_msgs/msg/Header"](time, frame)
    rows = (np.array(array, dtype=float) for array in arrays)
    return cdr("sensor_msgs/msg/JointState", header, list(names), *rows, little_endian=little_endian)


@dataclass
class Train:
    """A train over time, as another recorder has it: arrays (n, couplers) and (n, vehicles), times (n,) [s].

    Messages come ``late`` [s] after their stamps, by a clock that began at `WALL`.
    """

    time: np.ndarray
    force: np.ndarray
    stroke: np.ndarray
    stroke_rate: np.ndarray
    chainage: np.ndarray
    speed: np.ndarray
    brake_force: np.ndarray
    pressure: np.ndarray
    _: KW_ONLY
    node: str = "/haul"
    numbers: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    """Float64 topics under the node: times [s] and values."""
    late: float = 0.0
    frame: str = ""
    little_endian: bool = True

    def messages(self) -> list[BagMessage]:
        """All of them in the order in which they were recorded."""
        couplers = [f"coupler_{j:03d}" for j in range(1, self.force.shape[1] + 1)]
        vehicles = [f"vehicle_{j:03d}_C80" for j in range(1, self.speed.shape[1] + 1)]
        joint, floats = "sensor_msgs/msg/JointState", "std_msgs/msg/Float64MultiArray"
        found = []
        endian = self.little_endian
        for i, seconds in enumerate(self.time):
            stamp = round(seconds * 1e9)
            at = WALL + stamp + round(self.late * 1e9)
            of_couplers = (self.stroke[i], self.stroke_rate[i], self.force[i])
            of_vehicles = (self.chainage[i], self.speed[i], self.brake_force[i])
            dimension = STORE.types["std_msgs/msg/MultiArrayDimension"]("vehicle", len(vehicles), len(vehicles))
            layout = STORE.types["std_msgs/msg/MultiArrayLayout"]([dimension], 0)
            pressure = cdr(floats, layout, np.array(self.pressure[i], dtype=float), little_endian=endian)
            found += [
                BagMessage(f"{self.node}/{name}", msgtype, at, data)
                for name, msgtype, data in (
                    ("couplers", joint, _joints(stamp, couplers, of_couplers, self.frame, little_endian=endian)),
                    ("vehicles", joint, _joints(stamp, vehicles, of_vehicles, self.frame, little_endian=endian)),
                    ("brake_cylinder_pressure", floats, pressure),
                )
            ]
        for name, changes in self.numbers.items():
            for seconds, value in changes:
                at = WALL + round((seconds + self.late) * 1e9)
                data = cdr("std_msgs/msg/Float64", value, little_endian=endian)
                found.append(BagMessage(f"{self.node}/{name}", "std_msgs/msg/Float64", at, data))
        return sorted(found, key=lambda message: message.log_time)


def other_messages(count: int, size: int = 100) -> list[BagMessage]:
    """Topics that are no train's, as lie in bags too."""
    return [
        BagMessage("/chatter", "std_msgs/msg/String", WALL + i * 10**7, cdr("std_msgs/msg/String", "x" * size))
        for i in range(count)
    ]


def write_mcap(
    path: Path, messages: Iterable[BagMessage], *, chunked: bool = True, finished: bool = True, chunk_size: int = 2**14
) -> Path:
    """One MCAP file, with or without chunks as ``ros2 bag record`` may write it; ``finished``: with its end."""
    with path.open("wb") as stream:
        writer = McapWriter(stream, chunk_size=chunk_size, use_chunking=chunked)
        writer.start(profile="ros2", library="libmcap 1.1.0")
        ids: dict[str, int] = {}
        for topic, msgtype, log_time, data in messages:
            if topic not in ids:
                text, _ = STORE.generate_msgdef(msgtype, ros_version=2)
                schema = writer.register_schema(msgtype, "ros2msg", text.encode())
                ids[topic] = writer.register_channel(topic, "cdr", schema)
            writer.add_message(ids[topic], log_time, data, log_time)
        if finished:
            writer.finish()
        else:
            writer.flush()
    return path


def write_bag(
    folder: Path, messages: Iterable[BagMessage], storage: str, compressed: CompressionMode = CompressionMode.NONE
) -> Path:
    """A folder with metadata.yaml and one file, ``storage`` mcap or sqlite3, by the library rosbags."""
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    bag = BagWriter(folder, version=9, storage_plugin=plugin)
    bag.set_compression(compressed, CompressionFormat.ZSTD)
    with bag as writer:
        connections: dict[str, Any] = {}
        for topic, msgtype, log_time, data in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msgtype, typestore=STORE)
            writer.write(connections[topic], log_time, data)
    return folder


def write_split_bag(folder: Path, messages: Sequence[BagMessage], files: int) -> Path:
    """A folder of MCAP files, ``bag_0.mcap`` and so on, as ``ros2 bag record`` splits them, without metadata.yaml: it
    was killed."""
    folder.mkdir()
    for number, part in enumerate(np.array_split(np.arange(len(messages)), files)):
        write_mcap(folder / f"bag_{number}.mcap", [messages[i] for i in part])
    return folder


def rebagged(source: str, target: str, *, library: str, topics: str = "/haul/") -> None:
    """The topics of a recording as ``ros2 bag record`` writes them: wall times, no description, no scenario."""
    with Path(source).open("rb") as stream, Path(target).open("wb") as out:
        writer = McapWriter(out)
        writer.start(profile="ros2", library=library)
        ids: dict[str, int] = {}
        for schema, channel, message in make_reader(stream).iter_messages():
            if schema is None or not channel.topic.startswith(topics):
                continue
            if channel.topic not in ids:
                schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
                ids[channel.topic] = writer.register_channel(channel.topic, "cdr", schema_id)
            wall = 1_700_000_000 * 10**9 + message.log_time
            writer.add_message(ids[channel.topic], wall, message.data, wall)
        writer.finish()
