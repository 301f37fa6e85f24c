"""One MCAP file being written: what is in it and how it gets its name."""

from __future__ import annotations

import io
import json
import os
import time
from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

from mcap.writer import CompressionType, Writer

from haul_ros.errors import RecordingError
from haul_ros.messages.cdr import typestore
from haul_ros.messages.channels import Channel, ChannelTable
from haul_ros.messages.encoder import Message
from haul_ros.model.air_brake import PneumaticBrake
from haul_ros.model.recording_plan import RecordingPlan
from haul_ros.model.scenario import Scenario
from haul_ros.recording import rosbag2_metadata
from haul_ros.recording.integrity import CHECKSUM, DROPPED, WRITTEN, checksum_of
from haul_ros.resources import haul_command
from haul_ros.version import __version__

ACTIVE_SUFFIX = ".active"
"""Added to the name of a file as long as it is being written."""
RECORD_NAME = "haul_ros"
"""Name of the metadata record that describes the run; written at the start and, with counts, at the end."""
SCENARIO_NAME = "scenario.yaml"

_COMPRESSION = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}
CHUNK_SIZE = 1024 * 1024
"""Bytes before compression: large enough to be read fast, small enough to be written in a few milliseconds."""


def recovery_hint(path: Path) -> str:
    """The command that makes a whole file of an unfinished or damaged one."""
    target = path.with_suffix("") if path.suffix == ACTIVE_SUFFIX else path.with_stem(f"{path.stem}_recovered")
    return f"to recover it: {haul_command()} recover {path} -o {target}"


def description_of(scenario: Scenario, channels: ChannelTable, compression: str) -> dict[str, str]:
    """What a recording says of its run."""
    plan, how = scenario.recording, {}
    if plan != RecordingPlan():
        how = {"record_rate": repr(scenario.record_rate), "record_every": str(plan.every)}
        how |= {"rounding": json.dumps(plan.rounding.resolutions())}
    if scenario.sensors is not None:
        measured = [scenario.consist.coupler_names[coupler] for coupler in scenario.sensors.couplers]
        how |= {"measured_couplers": json.dumps(measured)}
    return how | {
        "version": __version__,
        "scenario": scenario.name,
        "description": scenario.description,
        "time_step": repr(scenario.time_step),
        "couplers": str(len(scenario.consist.coupler_names)),
        "vehicles": str(len(scenario.consist.vehicles)),
        "brake": "pneumatic" if isinstance(scenario.brakes, PneumaticBrake) else "empirical",
        "locomotives": json.dumps([locomotive.name for locomotive in scenario.consist.locomotives]),
        "topic_prefix": channels.prefix,
        "remapped_topics": json.dumps(channels.remapped),
        "sign_convention": "compression positive",
        "compression": compression,
    }


class RunFile:
    """The file ``path`` of one run, written under another name until it is finished. Not thread-safe.

    ``description`` is that of `description_of`, ``document`` the scenario's, ``suffix`` is added to the name meanwhile.

    Everything that explains the file (description of the run, scenario) is on disk before the first message.

    Raises
    ------
    RecordingError
        Unknown compression, ``path`` or the other name exists already, or the file cannot be created.
    """

    def __init__(
        self,
        path: Path,
        description: Mapping[str, str],
        document: str,
        channels: ChannelTable,
        suffix: str = ACTIVE_SUFFIX,
    ) -> None:
        compression = description["compression"]
        if compression not in _COMPRESSION:
            raise RecordingError(f"compression {compression!r}: expected {', '.join(_COMPRESSION)}")
        self.path = path
        if path.is_dir():
            raise RecordingError(f"{path}: is a folder, expected a new file")
        self.active = path.with_name(path.name + suffix)
        self._channels = channels
        self._description = dict(description)
        self._ids: dict[str, int] = {}
        self._counts: Counter[str] = Counter()
        self._start_ns = self._end_ns = 0
        self._stream = _create(path, self.active)
        self._identity = os.fstat(self._stream.fileno())
        try:
            self._writer = Writer(self._stream, chunk_size=CHUNK_SIZE, compression=_COMPRESSION[compression])
            self._begin(document)
        except BaseException as err:
            self.abandon()
            self.active.unlink()
            if isinstance(err, OSError):
                raise RecordingError(f"{path}: cannot be written: {err.strerror}") from err
            raise

    def _begin(self, document: str) -> None:
        self._writer.start(profile="ros2", library=f"haul_ros {self._description['version']}")
        self._add_records((), self._description)
        self._writer.add_attachment(
            create_time=time.time_ns(),
            log_time=0,
            name=SCENARIO_NAME,
            media_type="application/yaml",
            data=document.encode(),
        )
        schemas: dict[str, int] = {}
        for channel in self._channels:
            if channel.msgtype not in schemas:
                text, _ = typestore().generate_msgdef(channel.msgtype, ros_version=2)
                schemas[channel.msgtype] = self._writer.register_schema(channel.msgtype, "ros2msg", text.encode())
            self._ids[channel.topic] = self._writer.register_channel(
                topic=channel.topic,
                message_encoding="cdr",
                schema_id=schemas[channel.msgtype],
                metadata={
                    "offered_qos_profiles": rosbag2_metadata.offered_qos_profiles(channel.qos),
                    "topic_type_hash": typestore().hash_rihs01(channel.msgtype),
                },
            )
        self._writer.flush()

    def _add_records(self, channels: Iterable[Channel], description: dict[str, str]) -> None:
        bag = rosbag2_metadata.bag_metadata(self.path.name, channels, self._counts, self._start_ns, self._end_ns)
        self._writer.add_metadata(rosbag2_metadata.RECORD_NAME, {"serialized_metadata": bag})
        self._writer.add_metadata(RECORD_NAME, description | {CHECKSUM: checksum_of(description)})

    @property
    def size(self) -> int:
        """Bytes given to the file so far."""
        return self._stream.tell()

    def __contains__(self, topic: str) -> bool:
        return topic in self._ids

    def add(self, message: Message, sequence: int, publish_time_ns: int) -> None:
        """Append a message: simulation time is its log time, wall time [ns] its publish time."""
        topic, time_ns = message.channel.topic, message.time_ns
        self._writer.add_message(self._ids[topic], time_ns, message.data, publish_time_ns, sequence)
        self._start_ns = min(self._start_ns, time_ns) if self._counts else time_ns
        self._end_ns = max(self._end_ns, time_ns)
        self._counts[topic] += 1

    def flush(self) -> None:
        """Hand everything so far to the operating system: it survives the end of this process.

        Raises
        ------
        RecordingError
            The file has been removed, renamed, replaced or cut short meanwhile.
        """
        self._writer.flush()
        self._check_name(self.active)
        _check_length(self._stream.fileno(), self.size, self.active)

    def finish(self, dropped: int | None, written: int | None = None) -> int:
        """Complete the file, note how many messages were dropped, give it its name; returns its size in bytes.

        ``dropped`` None: not known. ``written`` is how many the recorder wrote, None: those that are in the file.

        Raises
        ------
        RecordingError
            A file of that name has come into being meanwhile, and the recording keeps its ``.active`` name; or that
            one has been removed, renamed, replaced, cut short or written to.
        """
        self.flush()
        counts = {WRITTEN: str(sum(self._counts.values()) if written is None else written)}
        if dropped is not None:
            counts[DROPPED] = str(dropped)
        self._add_records(self._channels, self._description | counts)
        self._writer.finish()
        self._stream.flush()
        if os.fstat(self._stream.fileno()).st_size != self.size:
            raise RecordingError(_changed(self.active))
        os.fsync(self._stream.fileno())  # the final name must stand for a whole file, even after a power failure
        size = self.size
        self._stream.close()
        try:
            _rename(self.active, self.path)
        except FileExistsError:
            raise RecordingError(f"{self.path}: exists by now, not overwritten; recorded as {self.active}") from None
        self._check_name(self.path)
        return size

    def _check_name(self, name: Path) -> None:
        """See that the file that is written still is the one of this name."""
        with suppress(OSError):
            if os.path.samestat(os.lstat(name), self._identity):
                return
        lost = "its content is where it was moved to, or lost"
        raise RecordingError(f"{self.path}: recording failed: {name} was removed, renamed or replaced; {lost}")

    def abandon(self) -> None:
        """Leave the file as it is."""
        with suppress(OSError, RecordingError):  # what could not be written before cannot be written now either
            self._stream.close()


def _changed(active: Path) -> str:
    return f"recording failed: {active} was cut short or written to by somebody else, what was in it is damaged or lost"


def _check_length(file: int, written: int, active: Path) -> None:
    """See that all that was written is still there."""
    if os.fstat(file).st_size < written:
        raise RecordingError(_changed(active))


class _OwnFile(io.FileIO):
    """A file that nobody else cuts short: behind the cut, writing would leave a hole that looks like data."""

    def write(self, data: Any, /) -> int:
        """Write at the present place, to which the file must reach."""
        _check_length(self.fileno(), self.tell(), Path(self.name))
        return super().write(data)


def _create(path: Path, active: Path) -> BinaryIO:
    """Open ``active`` for writing, or say why ``path`` cannot be recorded."""
    if os.path.lexists(path):
        raise RecordingError(f"{path}: exists already and is not overwritten, expected a new name")
    try:
        return io.BufferedWriter(_OwnFile(active, "xb"))
    except FileExistsError:
        raise RecordingError(f"{active}: an unfinished recording exists already, expected a new name") from None
    except FileNotFoundError:
        raise RecordingError(f"{path}: folder {path.parent} does not exist") from None
    except OSError as err:
        raise RecordingError(f"{path}: cannot be created: {err.strerror}") from err


def _rename(source: Path, target: Path) -> None:
    """Rename without ever overwriting; FileExistsError if there is a target."""
    try:
        os.link(source, target)
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links: take the name first, then replace what we took
        target.open("xb").close()
        source.replace(target)
    else:
        source.unlink()
