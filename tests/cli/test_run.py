from __future__ import annotations

import json
import os
import re
import signal
from collections.abc import Iterator
from dataclasses import fields
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from mcap.reader import make_reader

from haul_ros.cli import run as run_module
from haul_ros.messages.channels import STRING, channel_table
from haul_ros.model.command import Command, CommandKind
from haul_ros.model.log import PeriodLog
from haul_ros.recording.reader import Recording
from haul_ros.scenario import load_scenario
from haul_ros.simulation.batch import periods
from haul_ros.simulation.session import Session

if TYPE_CHECKING:
    from tests.cli.conftest import Haul

SECOND = 10**9
TABLE = channel_table(["master", "slave_1"])


def test_the_summary_says_when_it_stopped_and_where_the_peaks_are(haul: Haul) -> None:
    session = Session(load_scenario("short.yaml"), play_commands=True)
    for _ in periods(session):
        pass
    outcome = haul("run", "short.yaml")
    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.startswith("short: short train, emergency from 20 km/h\n")
    assert "22 vehicles, 21 couplers, 2368 t, 305.7 m, from 20.0 km/h" in outcome.out
    assert f"after {session.stop_time:.3f} s and {session.travelled:.1f} m" in outcome.out
    assert f"{session.extremes().compression.max() / 1e3:.1f} kN at " in outcome.out
    assert re.search(r"largest stroke +\d+\.\d\d mm in \w+, coupler_\d{3} between vehicle_\d{3}", outcome.out)
    assert re.search(r"relative imbalance -?\de-1\d|relative imbalance -?\d\.\de-\d\d", outcome.out)
    assert "0 unconverged" in outcome.out
    assert "fitted values in   brake_systems.paper_set_b, couplers.paper_set_b, vehicles.C80" in outcome.out


def test_json_has_the_numbers_with_their_units_in_the_keys(haul: Haul) -> None:
    session = Session(load_scenario("short.yaml"), play_commands=True)
    for _ in periods(session):
        pass
    found = json.loads(haul("run", "short.yaml", "--json").out)
    extremes = session.extremes()
    assert found["stop_time_s"] == session.stop_time
    assert found["distance_m"] == session.travelled
    assert found["peak_compression_kN"] == pytest.approx(extremes.compression.max() / 1e3)
    assert found["peak_tension_kN"] == pytest.approx(extremes.tension.max() / 1e3)
    assert found["peak_compression_time_s"] == extremes.compression_time[extremes.compression.argmax()]
    assert found["largest_stroke_mm"] == pytest.approx(
        1e3 * max(extremes.compression_stroke.max(), extremes.tension_stroke.max())
    )
    assert abs(found["energy"]["relative_imbalance"]) < 1e-6
    assert found["energy"]["kinetic_start_MJ"] == pytest.approx(0.5 * 2368e3 * (20 / 3.6) ** 2 / 1e6)
    assert found["newton"]["steps"] == session.step
    assert (found["recording"], found["interrupted"], found["warnings"]) == (None, False, [])


def test_quiet_prints_nothing(haul: Haul) -> None:
    outcome = haul("run", "short.yaml", "--quiet", "-o", "run.mcap")
    assert (outcome.status, outcome.out, outcome.err) == (0, "", "")
    assert Path("run.mcap").exists()


def test_values_of_the_scenario_can_be_replaced(haul: Haul) -> None:
    outcome = haul("run", "short.yaml", "--json", "--set", "initial_speed_kmh=30", "--set", "max_duration_s=2")
    found = json.loads(outcome.out)
    assert found["initial_speed_kmh"] == pytest.approx(30.0)
    assert (found["stop_time_s"], found["duration_s"]) == (None, 2.0)
    assert found["final_speed_kmh"] > 20.0


def test_a_train_that_did_not_stop_is_still_moving(haul: Haul) -> None:
    outcome = haul("run", "short.yaml", "--set", "max_duration_s=2")
    assert re.search(r"still moving +at \d\d\.\d km/h after 2\.000 s and 1\d\.\d m", outcome.out)


def test_the_recording_holds_the_samples_commands_and_brakes_of_the_run_bit_for_bit(haul: Haul) -> None:
    outcome = haul("run", "short.yaml", "-o", "run.mcap")
    assert "recorded           run.mcap, " in outcome.out
    logs = list(periods(Session(load_scenario("short.yaml"), play_commands=True)))
    samples = [log.sample for log in logs if log.sample is not None]
    with Recording("run.mcap") as recording:
        couplers, vehicles, pressure = recording.couplers(), recording.vehicles(), recording.pressure()
        assert recording.commands() == ((SECOND // 2, Command("master", CommandKind.EMERGENCY, 1.0)),)
        applied = {name: recording.scalars(f"{name}/applied_brake") for name in ("master", "slave_1")}
        link = {
            name: recording.scalars(f"slave_1/radio_{name}")
            for name, by_slave in TABLE.radio.items()
            if by_slave["slave_1"].msgtype != STRING
        }
        extremes = list(recording.extremes())
        assert recording.info().complete
    np.testing.assert_array_equal(couplers.time_ns, [sample.time_ns for sample in samples])
    np.testing.assert_array_equal(couplers.stroke, [sample.stroke for sample in samples])
    np.testing.assert_array_equal(couplers.stroke_rate, [sample.stroke_rate for sample in samples])
    np.testing.assert_array_equal(couplers.force, [sample.coupler_force for sample in samples])
    np.testing.assert_array_equal(vehicles.chainage, [sample.chainage for sample in samples])
    np.testing.assert_array_equal(vehicles.speed, [sample.speed for sample in samples])
    np.testing.assert_array_equal(vehicles.brake_force, [sample.brake_force for sample in samples])
    np.testing.assert_array_equal(pressure.pressure, [sample.cylinder_pressure for sample in samples])
    assert applied["master"].time_ns.tolist() == [0, SECOND // 2]
    assert applied["slave_1"].time_ns.tolist() == [0, SECOND * 3 // 2]
    assert {name: (series.time_ns.tolist(), series.values.tolist()) for name, series in link.items()} == {
        "connected": ([0], [1.0]),
        "delay": ([0], [1.0]),
        "jitter": ([0], [0.0]),
        "loss_probability": ([0], [0.0]),
        "retries": ([0], [0.0]),
        "retry_interval": ([0], [0.5]),
        "duplicate_probability": ([0], [0.0]),
        "in_order": ([0], [1.0]),
        "burst_length": ([0], [0.0]),
        "burst_spacing": ([0], [60.0]),
        "burst_loss_probability": ([0], [1.0]),
    }
    expected = [(log.time_ns, log.extremes) for log in logs if log.extremes]
    for (time_ns, found), (expected_ns, largest) in zip(extremes, expected, strict=True):
        assert time_ns == expected_ns
        for field in fields(largest):
            if field.name != "bottomed_time":
                np.testing.assert_array_equal(getattr(found, field.name), getattr(largest, field.name), field.name)
    assert min(extremes[-1].extremes.compression.max(), extremes[-1].extremes.tension.max()) > 0.0


def test_messages_lie_in_the_file_in_the_order_of_simulation_time(haul: Haul) -> None:
    haul("run", "short.yaml", "-o", "run.mcap", "--set", "radio.default.delay_s=0.513")
    with Path("run.mcap").open("rb") as stream:
        messages = make_reader(stream).iter_messages(log_time_order=False)
        times = [message.log_time for _, _, message in messages]
    assert all(earlier <= later for earlier, later in pairwise(times))


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_the_recording_is_compressed_as_asked_for(haul: Haul, compression: str) -> None:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--compression", compression, "--quiet").status == 0
    with Recording("run.mcap") as recording:
        assert recording.info().compression == compression


def test_an_existing_file_is_refused_before_anything_is_simulated(haul: Haul, monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object, **__: object) -> None:
        pytest.fail("simulated")

    Path("run.mcap").write_bytes(b"precious")
    monkeypatch.setattr(run_module, "Session", forbidden)
    outcome = haul("run", "short.yaml", "-o", "run.mcap")
    assert outcome.status == 2
    assert outcome.err == "haul: run.mcap: exists already and is not overwritten, expected a new name\n"
    assert Path("run.mcap").read_bytes() == b"precious"


def test_a_run_that_its_commands_make_impossible_is_one_line_and_keeps_what_was_recorded(haul: Haul) -> None:
    commands = (
        "commands=[{at_s: 0, locomotive: master, emergency: true}, {at_s: 1, locomotive: master, emergency: false}]"
    )
    outcome = haul("run", "short.yaml", "-o", "run.mcap", "--set", commands)
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "haul: short: at 1.000 s: master: an emergency application ends at standstill only\n"
    with Recording("run.mcap") as recording:
        assert recording.couplers().time_ns[-1] == SECOND


def test_ctrl_c_completes_the_recording_and_prints_the_summary_so_far(
    haul: Haul, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted_periods(*arguments: object) -> Iterator[PeriodLog]:
        for number, log in enumerate(periods(*arguments)):  # type: ignore[arg-type]
            if number == 100:
                os.kill(os.getpid(), signal.SIGINT)
            yield log

    monkeypatch.setattr(run_module, "periods", interrupted_periods)
    before = signal.getsignal(signal.SIGINT)
    outcome = haul("run", "short.yaml", "-o", "run.mcap")
    assert outcome.status == 130
    assert "still moving" in outcome.out
    assert outcome.err == "haul: interrupted at 2.020 s\n"
    assert signal.getsignal(signal.SIGINT) is before
    with Recording("run.mcap") as recording:
        assert recording.info().complete
        assert recording.couplers().time_ns[-1] == recording.last_extremes().time_ns == 101 * SECOND // 50


def test_a_closed_draft_gear_is_warned_of(haul: Haul) -> None:
    limit = "couplers.paper_set_b.maximum_stroke_mm=1"
    stiffness = "couplers.paper_set_b.bottoming_stiffness_kN_per_mm=500"
    outcome = haul("run", "short.yaml", "--set", limit, "--set", stiffness)
    assert outcome.status == 0
    assert re.fullmatch(
        r"haul: warning: draft gear closed fully at coupler_\d{3} and \d+ more: the force there is steel on steel\n",
        outcome.err,
    )


def test_the_summary_tells_of_separations_and_of_brakes_that_do_what_nobody_asked(haul: Haul) -> None:
    """A coupler is opened on the way; its hose parts, both parts stop by emergency, and nothing else is told of."""
    faults = "faults={events: [{at_s: 1, uncouple: 7}]}"
    arguments = ("run", "short.yaml", "--set", "brakes=pneumatic", "--set", "commands=[]", "--set", faults)
    commands = "commands=[{at_s: 0.5, locomotive: master, traction_kN: 500}]"
    outcome = haul(*arguments, "--set", commands)
    told = dict(
        re.findall(r"^  (separation|control valves|brake application|released unasked) +(.*)$", outcome.out, re.M)
    )
    assert set(told) == {"separation", "control valves"}
    assert re.fullmatch(r"at 1\.000 s coupler_007: uncoupled under \d+\.\d kN of \w+; and 1 more", told["separation"])
    assert "undesired emergency: no locomotive has asked for it; and " in told["control valves"]
    found = json.loads(haul(*arguments, "--set", commands, "--json").out)
    assert found["events"]["separation"]["count"] == 2
    assert found["events"]["separation"]["first_time_s"] == 1.0
    assert found["events"]["application"] == {"count": 0, "first_time_s": None, "first": None}
    assert found["unintended_releases"] == 0


def test_the_summary_counts_vehicles_that_release_unasked(haul: Haul) -> None:
    """The rear of the train, cut off by a cock, stays charged; once the cock is opened its air releases the front."""
    outcome = haul(
        *("run", "short.yaml", "--set", "consist=[{vehicle: SS4, role: master}, {vehicle: C80, count: 20}]"),
        *("--set", "brakes=pneumatic", "--set", "commands=[{at_s: 2, locomotive: master, brake: 0.3}]"),
        *("--set", "faults={events: [{at_s: 1, close_angle_cock: 11}, {at_s: 20, open_angle_cock: 11}]}"),
        *("--set", "max_duration_s=30"),
    )
    ((count,),) = [re.findall(r"^  released unasked +(\d+) vehicles$", outcome.out, re.M)]
    assert 5 <= int(count) <= 11  # of the locomotive and ten wagons
    assert re.search(r"^  control valves +at 20\.\d{3} s vehicle_.*: unintended release: ", outcome.out, re.M)
