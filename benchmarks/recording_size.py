"""How large recordings of a long descent get, by how often and how exactly samples are recorded.

    python -m benchmarks.recording_size [--seconds 4000] [--json]

Drives the train of daqin_descent, published at 50 Hz, once, and records the same run with several settings: into one
file as `haul run` does, and into one that is flushed after every second of the train's time, as the live node's is
in real time, so that each piece of a second is compressed by itself.

A recording grows in proportion to its time: every chunk of a MiB, or of a second, is compressed apart from the others,
and its index entries have a fixed size a message. The whole line (4000 s: level, every grade to -12 per mille, with
traction, electric brake, applications and recharging) has all that eight hours of such descents consist of; the
largest minute of it, 480 times, is a bound for any order of them.

Exit status 1 if the documented setting does not keep eight hours below 2 GB.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.report import machine
from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.scenario import Scenario
from haul_ros.recording.run_file import RunFile, description_of
from haul_ros.recording.thinning import Thinning
from haul_ros.scenario import load_scenario
from haul_ros.simulation.batch import periods
from haul_ros.simulation.session import Session
from haul_ros.units import NS_PER_S

SCENARIO = "daqin_descent"
HOURS = 8.0
LIMIT_GB = 2.0
FINE = {
    "coupler_force_N": 8,
    "stroke_mm": 0.01,
    "stroke_rate_mm_per_s": 0.01,
    "chainage_mm": 1,
    "speed_mm_per_s": 0.01,
    "brake_force_N": 8,
    "pressure_Pa": 16,
}
COARSE = {
    "coupler_force_N": 128,
    "stroke_mm": 0.1,
    "stroke_rate_mm_per_s": 0.1,
    "chainage_mm": 10,
    "speed_mm_per_s": 1,
    "brake_force_N": 128,
    "pressure_Pa": 128,
}
SETTINGS: dict[str, dict[str, Any]] = {
    "50 Hz, all bits": {},
    "10 Hz, rounded (documented)": {"rate_hz": 10, "rounding": FINE},
    "50 Hz, coarsely rounded": {"rounding": COARSE},
}
ALL_BITS = "50 Hz, all bits"
DOCUMENTED = "10 Hz, rounded (documented)"


@dataclass(frozen=True, slots=True)
class Size:
    """Bytes of a file, by the minute; the largest minute of it; and what that makes of eight hours [GB]."""

    setting: str
    flushed_each_second: bool
    seconds: float
    size_bytes: int
    mb_per_minute: float
    mb_in_largest_minute: float
    gb_in_8_hours: float


class _File:
    """A recording that is written with one setting."""

    def __init__(self, folder: Path, setting: str, scenario: Scenario, *, flush: bool) -> None:
        self.setting, self.flush = setting, flush
        self._encoder = TelemetryEncoder.of(scenario)
        self._thinning = Thinning(scenario, self._encoder.channels)
        description = description_of(scenario, self._encoder.channels, "zstd")
        path = folder / f"{setting.partition(' (')[0]}-{flush}.mcap".replace(" ", "_")
        self._file = RunFile(path, description, scenario.document, self._encoder.channels)
        self._second = 0
        self._minutes = [0]

    def put(self, log: Any) -> None:
        for message in self._thinning.taken(self._encoder.messages(log)):
            self._file.add(message, 0, 0)
        if (second := log.time_ns // NS_PER_S) > self._second:
            self._second = second
            if self.flush:
                self._file.flush()
            if second % 60 == 0:
                self._minutes.append(self._file.size)

    def finish(self, seconds: float) -> Size:
        size = self._file.finish(0)
        largest = max(
            (after - before for before, after in zip(self._minutes, self._minutes[1:], strict=False)), default=0
        )
        per_minute = size / (seconds / 60.0)
        gb = per_minute * HOURS * 60.0 / 1e9
        return Size(self.setting, self.flush, seconds, size, per_minute / 1e6, largest / 1e6, gb)


def measure(seconds: float) -> list[Size]:
    """The sizes of all settings for the first so many seconds of the descent."""
    scenarios = {
        name: load_scenario(SCENARIO, {"sample_rate_hz": 50, "max_duration_s": seconds, "recording": plan})
        for name, plan in SETTINGS.items()
    }
    with TemporaryDirectory() as folder:
        ways = [(name, flush) for name in SETTINGS for flush in (False, True) if name != ALL_BITS or not flush]
        files = [_File(Path(folder), name, scenarios[name], flush=flush) for name, flush in ways]
        session = Session(scenarios[ALL_BITS], play_commands=True)
        for log in periods(session):
            for file in files:
                file.put(log)
        return [file.finish(session.time) for file in files]


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=4000.0, help="simulated time; default: the whole line")
    parser.add_argument("--json", action="store_true", help="print JSON")
    arguments = parser.parse_args()
    sizes = measure(arguments.seconds)
    if arguments.json:
        print(
            json.dumps({"machine": machine(("mcap", "zstandard")), "sizes": [asdict(size) for size in sizes]}, indent=2)
        )
    else:
        for size in sizes:
            how = "flushed each second" if size.flushed_each_second else "as haul run"
            print(
                f"{size.setting:28} {how:20} {size.size_bytes:12d} bytes in {size.seconds:.0f} s, "
                f"{size.mb_per_minute:6.2f} MB a minute, at most {size.mb_in_largest_minute:6.2f}; "
                f"8 h: {size.gb_in_8_hours:.2f} GB"
            )
    return int(any(s.setting == DOCUMENTED and s.gb_in_8_hours >= LIMIT_GB for s in sizes))


if __name__ == "__main__":
    sys.exit(main())
