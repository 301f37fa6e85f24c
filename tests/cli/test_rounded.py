"""Runs recorded less often and rounded: what is in the file, and that a replay still tells any difference."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from mcap.records import Message as McapMessage

from haul_ros.messages.encoder import Message
from haul_ros.recording.reader import Recording
from tests.recorded import forge

if TYPE_CHECKING:
    from tests.cli.conftest import Haul

ROUNDING = "{coupler_force_N: 10, stroke_mm: 0.01, stroke_rate_mm_per_s: 0.01, speed_mm_per_s: 0.01, pressure_Pa: 20}"
TOLD = (
    "coupler force to 8 N, stroke to 7.62939e-06 m, stroke rate to 7.62939e-06 m/s, speed to 7.62939e-06 m/s, "
    "pressure to 16 Pa"
)


@pytest.fixture
def exact(haul: Haul) -> Haul:
    assert haul("run", "short.yaml", "-o", "exact.mcap", "--quiet").status == 0
    return haul


@pytest.fixture
def rounded(exact: Haul) -> Haul:
    plan = f"recording={{rate_hz: 10, rounding: {ROUNDING}}}"
    assert exact("run", "short.yaml", "-o", "rounded.mcap", "--set", plan, "--quiet").status == 0
    return exact


def test_the_recorded_samples_are_some_of_the_published_ones_rounded(rounded: Haul) -> None:
    with Recording("exact.mcap") as recording:
        every, times = recording.samples(), recording.couplers().time_ns
        all_extremes, all_events = [m.data for m in _extremes(recording)], recording.events()
    with Recording("rounded.mcap") as recording:
        some = recording.samples()
        assert [m.data for m in _extremes(recording)] == all_extremes  # of every time step, with all their bits
        assert recording.events() == all_events
    last = len(times) - 1
    taken = sorted({*range(0, last + 1, 5), last})
    assert last % 5, "so that the last sample is one that is recorded for being the last"
    assert some.couplers.time_ns.tolist() == times[taken].tolist()
    for found, exact, power in (
        (some.couplers.force, every.couplers.force, 8.0),
        (some.couplers.stroke, every.couplers.stroke, 2.0**-17),
        (some.vehicles.speed, every.vehicles.speed, 2.0**-17),
        (some.pressure.pressure, every.pressure.pressure, 16.0),
    ):
        assert (found % power == 0.0).all()
        assert np.abs(found - exact[taken]).max() <= power / 2.0
        assert (found != exact[taken]).any()
    np.testing.assert_array_equal(some.vehicles.chainage, every.vehicles.chainage[taken])  # which is not rounded
    assert Path("rounded.mcap").stat().st_size < Path("exact.mcap").stat().st_size / 4


def _extremes(recording: Recording) -> list[Message]:
    channels = (recording.channels.max_compression, recording.channels.max_tension)
    return [message for message in recording.state_messages() if message.channel in channels]


def test_info_says_how_samples_are_recorded(rounded: Haul) -> None:
    outcome = rounded("info", "rounded.mcap")
    assert f"samples            10 a second, one in 5 of those published; rounded: {TOLD}\n" in outcome.out
    found = json.loads(rounded("info", "rounded.mcap", "--json").out)
    assert (found["record_rate_hz"], found["record_every"]) == (10.0, 5)
    assert found["rounding"]["coupler_force"] == 8.0
    assert "samples   " not in rounded("info", "exact.mcap").out


def test_a_replay_is_exact_and_says_what_was_rounded_before(rounded: Haul) -> None:
    outcome = rounded("replay", "rounded.mcap")
    assert (outcome.status, outcome.err) == (0, "")
    with Recording("rounded.mcap") as recording:
        count = len(list(recording.state_messages()))
    assert outcome.out.splitlines() == [
        f"identical: {count} messages of couplers, vehicles, cylinder pressure and extremes, bit for bit",
        f"rounded before: {TOLD}; extremes have all their bits",
    ]
    assert "rounded before" not in rounded("replay", "exact.mcap").out
    assert json.loads(rounded("replay", "rounded.mcap", "--json").out)["rounding"]["pressure"] == 16.0


def test_a_single_bit_of_a_rounded_recording_is_found(rounded: Haul) -> None:
    def flipped(found: list[tuple[str, McapMessage]]) -> list[tuple[str, McapMessage]]:
        index = [n for n, (topic, _) in enumerate(found) if topic == "/haul/couplers"][3]
        data = bytearray(found[index][1].data)
        data[-8 * 5] ^= 1  # the last bit of a force: far below its resolution
        found[index][1].data = bytes(data)
        return found

    forge(Path("rounded.mcap"), Path("forged.mcap"), messages=flipped)
    outcome = rounded("replay", "forged.mcap")
    assert outcome.status == 1
    assert outcome.out.startswith("different: 1 of ")
    assert "first at 0.300 s in /haul/couplers: coupler_017 force [N]: recorded " in outcome.out


def test_a_sample_that_is_missing_is_found_though_few_are_recorded(rounded: Haul) -> None:
    def less(found: list[tuple[str, McapMessage]]) -> list[tuple[str, McapMessage]]:
        return [(topic, m) for topic, m in found if not (topic == "/haul/vehicles" and m.log_time == 300_000_000)]

    forge(Path("rounded.mcap"), Path("less.mcap"), messages=less)
    outcome = rounded("replay", "less.mcap")
    assert outcome.status == 1
    assert "missing: 1 messages of /haul/vehicles\n" in outcome.out


def _with_force_to_four(description: dict[str, str]) -> dict[str, str]:
    return description | {"rounding": description["rounding"].replace('"coupler_force": 8.0', '"coupler_force": 4.0')}


def test_another_rounding_in_its_scenario_is_told(rounded: Haul) -> None:
    def finer(document: bytes) -> bytes:
        assert b"coupler_force_N: 10" in document
        return document.replace(b"coupler_force_N: 10", b"coupler_force_N: 5")

    forge(Path("rounded.mcap"), Path("forged.mcap"), scenario=finer)
    outcome = rounded("replay", "forged.mcap")
    assert (outcome.status, outcome.out) == (2, "")
    assert "forged.mcap: its samples are recorded otherwise than its description of the run says" in outcome.err
    forge(Path("rounded.mcap"), Path("both.mcap"), scenario=finer, description=_with_force_to_four)
    outcome = rounded("replay", "both.mcap")
    assert outcome.status == 1
    assert outcome.out.startswith("different: ")
    assert "/haul/couplers: coupler_" in outcome.out


@pytest.mark.parametrize("plan", ['{"coupler_force": 3.0}', '{"weight": 1.0}', "[1]", "NaN", '{"stroke": "0.5"}'])
def test_a_description_of_no_rounding_is_refused_in_one_line(rounded: Haul, plan: str) -> None:
    forge(Path("rounded.mcap"), Path("forged.mcap"), description=lambda found: found | {"rounding": plan})
    outcome = rounded("info", "forged.mcap")
    assert outcome.status == 2
    assert "rounding is" in outcome.err
    assert outcome.err.count("\n") == 1


def test_a_run_again_may_be_recorded_otherwise(rounded: Haul) -> None:
    change = ("--set", "recording.rounding.coupler_force_N=0", "--set", "recording.rate_hz=50", "-o", "again.mcap")
    assert rounded("replay", "rounded.mcap", *change).status == 0
    assert rounded("replay", "again.mcap").status == 0
    with Recording("again.mcap") as again, Recording("exact.mcap") as recording:
        np.testing.assert_array_equal(again.couplers().force, recording.couplers().force)


def test_a_recovered_recording_keeps_what_is_said_of_its_samples(rounded: Haul) -> None:
    data = Path("rounded.mcap").read_bytes()
    Path("cut.mcap").write_bytes(data[: len(data) * 9 // 10])
    assert rounded("recover", "cut.mcap", "-o", "whole.mcap").status == 0
    assert TOLD in rounded("info", "whole.mcap").out
    assert rounded("replay", "whole.mcap").status == 0
