"""Instrumented couplers from the scenario to the file, its reader and its replay."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from mcap.records import Message as McapMessage

from haul_ros.recording.reader import Recording
from tests.recorded import forge

if TYPE_CHECKING:
    from tests.cli.conftest import Haul

TOPIC = "/haul/measured_couplers"
SENSORS = (
    "sensors={couplers: [1, 21, 9], rate_hz: 25, force: {noise_kN: 2, quantisation_kN: 0.5, range_kN: 60}, "
    "stroke: {noise_mm: 0.1, quantisation_mm: 0.05}}"
)
NAMES = ("coupler_001", "coupler_021", "coupler_009")


@pytest.fixture
def measured(haul: Haul) -> Haul:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--set", SENSORS, "--quiet").status == 0
    return haul


def test_what_sensors_show_is_recorded_beside_the_truth(measured: Haul) -> None:
    with Recording("run.mcap") as recording:
        found, truth = recording.measured_couplers(), recording.couplers()
    assert found is not None
    assert found.stroke is not None
    assert found.names == NAMES
    assert found.time_ns.tolist() == truth.time_ns[::2].tolist()
    force = truth.force[::2, [0, 20, 8]]
    assert np.abs(force).max() > 60e3
    assert np.abs(found.force).max() == 60e3
    within = np.abs(force) < 50e3
    error = (found.force - force)[within]
    # Standard deviation 2 kN and a twelfth of the square of 0.5 kN, to four standard errors
    assert error.std() / np.hypot(2e3, 0.5e3 / 12**0.5) == pytest.approx(1.0, abs=4.0 / (2.0 * error.size) ** 0.5)
    assert (found.force % 500.0 == 0.0).all()
    assert np.abs(found.stroke - truth.stroke[::2, [0, 20, 8]]).max() < 0.6e-3


def test_the_rest_of_the_recording_is_as_without_sensors(measured: Haul) -> None:
    assert measured("run", "short.yaml", "-o", "plain.mcap", "--quiet").status == 0
    with Recording("run.mcap") as recording, Recording("plain.mcap") as plain:
        assert plain.measured_couplers() is None
        others = [m for m in recording.state_messages() if m.channel.topic != TOPIC]
        assert others == list(plain.state_messages())
        topics = {info.topic for info in recording.info().topics} - {info.topic for info in plain.info().topics}
        assert recording.events() == plain.events()
    assert topics == {TOPIC}


def test_info_names_the_couplers(measured: Haul) -> None:
    outcome = measured("info", "run.mcap")
    assert "sensors            at coupler_001, coupler_021, coupler_009\n" in outcome.out
    assert json.loads(measured("info", "run.mcap", "--json").out)["measured_couplers"] == list(NAMES)


@pytest.mark.parametrize("plan", [(), ("--set", "recording={rate_hz: 10, rounding: {coupler_force_N: 100}}")])
def test_a_replay_measures_the_same_whatever_else_is_recorded(measured: Haul, plan: tuple[str, ...]) -> None:
    assert measured("run", "short.yaml", "-o", "again.mcap", "--set", SENSORS, *plan, "--quiet").status == 0
    outcome = measured("replay", "again.mcap")
    assert outcome.out.startswith("identical: ")
    assert outcome.status == 0
    with Recording("run.mcap") as one, Recording("again.mcap") as other:
        first, second = one.measured_couplers(), other.measured_couplers()
        assert first is not None
        assert second is not None
        assert first.force.tobytes() == second.force.tobytes()  # of the truth, which is not rounded
        assert other.couplers().force.size < one.couplers().force.size or not plan


def test_force_alone_is_read_back_without_stroke(haul: Haul) -> None:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--set", "sensors={couplers: [4]}", "--quiet").status == 0
    with Recording("run.mcap") as recording:
        found = recording.measured_couplers()
        assert found is not None
        assert found.stroke is None
        assert found.force[:, 0].tolist() == recording.couplers().force[:, 3].tolist()
    assert haul("replay", "run.mcap").status == 0


def test_a_changed_measurement_is_found(measured: Haul) -> None:
    def changed(found: list[tuple[str, McapMessage]]) -> list[tuple[str, McapMessage]]:
        message = [message for topic, message in found if topic == TOPIC][4]
        message.data = message.data[:-1] + bytes([message.data[-1] ^ 0x80])  # the sign of the last force
        return found

    forge(Path("run.mcap"), Path("forged.mcap"), messages=changed)
    outcome = measured("replay", "forged.mcap")
    assert outcome.status == 1
    assert outcome.out.startswith("different: 1 of ")
    assert f"first at 0.160 s in {TOPIC}: coupler_009 measured force [N]: recorded " in outcome.out


def test_another_seed_or_noise_in_its_scenario_is_told(measured: Haul) -> None:
    for old, new in ((b"noise_kN: 2", b"noise_kN: 3"), (b"seed: 0", b"seed: 1")):
        name = f"forged_{new[-1]}.mcap"
        forge(Path("run.mcap"), Path(name), scenario=lambda text, old=old, new=new: text.replace(old, new, 1))  # type: ignore[misc]
        outcome = measured("replay", name)
        assert outcome.status == 1, new
        assert TOPIC in outcome.out


def test_a_missing_measurement_is_found(measured: Haul) -> None:
    def less(found: list[tuple[str, McapMessage]]) -> list[tuple[str, McapMessage]]:
        return [(topic, m) for topic, m in found if not (topic == TOPIC and m.log_time == 400_000_000)]

    forge(Path("run.mcap"), Path("less.mcap"), messages=less)
    outcome = measured("replay", "less.mcap")
    assert outcome.status == 1
    assert f"missing: 1 messages of {TOPIC}\n" in outcome.out


def test_a_measurement_at_another_time_is_refused(measured: Haul) -> None:
    def late(found: list[tuple[str, McapMessage]]) -> list[tuple[str, McapMessage]]:
        for topic, message in found:
            if topic == TOPIC and message.log_time == 400_000_000:
                message.log_time = 420_000_000
        return found

    forge(Path("run.mcap"), Path("late.mcap"), messages=late)
    outcome = measured("replay", "late.mcap")
    assert (outcome.status, outcome.out) == (2, "")
    assert f"late.mcap: {TOPIC} at 0.420 s, when no sensor measures" in outcome.err


@pytest.mark.parametrize(
    ("names", "told"),
    [
        ('["coupler_001"]', "its scenario has other sensors than its description of the run"),
        ("[]", "its scenario has other sensors than its description of the run"),
        ('["coupler_1"]', "measured_couplers is"),
        ("3", "measured_couplers is"),
    ],
)
def test_a_description_of_other_sensors_is_refused(measured: Haul, names: str, told: str) -> None:
    forge(Path("run.mcap"), Path("forged.mcap"), description=lambda found: found | {"measured_couplers": names})
    outcome = measured("replay", "forged.mcap")
    assert (outcome.status, outcome.out) == (2, "")
    assert told in outcome.err
    assert outcome.err.count("\n") == 1


def test_a_message_of_other_couplers_is_refused(measured: Haul) -> None:
    def renamed(found: list[tuple[str, McapMessage]]) -> list[tuple[str, McapMessage]]:
        for topic, message in found:
            if topic == TOPIC:
                message.data = message.data.replace(b"coupler_021", b"coupler_020")
        return found

    forge(Path("run.mcap"), Path("forged.mcap"), messages=renamed)
    with Recording("forged.mcap") as recording, pytest.raises(Exception, match="a message of other couplers"):
        recording.measured_couplers()
    outcome = measured("replay", "forged.mcap")
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1


def test_a_recovered_recording_keeps_its_measurements(measured: Haul) -> None:
    data = Path("run.mcap").read_bytes()
    Path("cut.mcap").write_bytes(data[: len(data) * 9 // 10])
    assert measured("recover", "cut.mcap", "-o", "whole.mcap").status == 0
    assert measured("replay", "whole.mcap").status == 0
    with Recording("whole.mcap") as recording:
        found = recording.measured_couplers()
        assert found is not None
        assert len(found.time_ns)
