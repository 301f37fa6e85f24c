"""Speed over the limits of a line: when it is told, of what, and in the summary."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from haul_ros.analysis.recorded import recorded_scenario, summarize_recording
from haul_ros.analysis.summary import summarize_session
from haul_ros.cli.main import main
from haul_ros.cli.summary_text import summary_json, summary_lines
from haul_ros.model.event import Event, EventKind
from haul_ros.model.scenario import Scenario
from haul_ros.model.track import Track
from haul_ros.recording.reader import Recording
from haul_ros.scenario import load_scenario, load_scenario_text
from haul_ros.simulation.batch import periods
from haul_ros.simulation.overspeed import OverspeedWatch
from haul_ros.simulation.session import Session
from haul_ros.units import kmh_to_mps
from tests.simulation.log_entries import of_kind

SECOND = 10**9
TRAIN = """\
consist:
  - {vehicle: SS4, role: master}
  - {vehicle: C80, count: 10}
coupler: MT-2
brakes: paper_set_b
initial_speed_kmh: 36
max_duration_s: 60
track:
  speed_limits: [{from_m: -1000, limit_kmh: 40}, {from_m: 100, limit_kmh: 30}, {from_m: 130, limit_kmh: 40}]
"""
LENGTH = 32.83 + 10 * 12.0


def scenario(**overrides: object) -> Scenario:
    """Ten metres a second, less by the running resistance, towards a limit of 30 km/h from 100 to 130 m."""
    return load_scenario_text(TRAIN, "train", {key.replace("__", "."): value for key, value in overrides.items()})


def told(run: Scenario) -> list[Event]:
    session = Session(run, play_commands=True)
    return [event for event in of_kind(Event, *periods(session)) if event.kind is EventKind.OVERSPEED]


def watch(*limits: tuple[float, float]) -> OverspeedWatch:
    return OverspeedWatch(scenario().consist, Track(speed_limits=limits))


def test_the_head_is_told_of_when_it_comes_to_a_lower_limit() -> None:
    (event,) = told(scenario())
    # At 0.92 + 0.0048 v + ... N/kN the train loses 1.7 % of 10 m/s on 100 m.
    assert event.time_ns / SECOND == pytest.approx(100.0 / 9.92, abs=0.05)
    text = re.fullmatch(r"vehicle_001_SS4: (\d+\.\d) km/h at (\d+\.\d) m, (\d+\.\d) over the limit of 30", event.text)
    assert text is not None
    speed, chainage, excess = map(float, text.groups())
    assert 100.0 <= chainage < 100.0 + 10.0 / 50.0 + 0.05
    assert speed == pytest.approx(36.0 * 0.983, abs=0.3)
    assert excess == pytest.approx(speed - 30.0, abs=0.051)


def test_a_limit_holds_until_the_tail_has_left_it() -> None:
    offsets = np.array(scenario().consist.centre_offsets)
    speeds = np.full(11, 10.0)
    # Front of the head short of the limit and past it; rear of the tail under its end and past it.
    for head, over in ((99.9, False), (100.1, True), (129.9 + LENGTH, True), (130.1 + LENGTH, False)):
        found = watch((100.0, 8.0), (130.0, 12.0)).update(0, head - offsets, speeds)
        assert (found is not None) is over, head
    found = watch((100.0, 8.0), (130.0, 12.0)).update(7, 129.9 + LENGTH - offsets, speeds)
    assert found is not None
    assert (found.time_ns, found.vehicle, found.speed, found.limit) == (7, 10, 10.0, 8.0)
    assert found.chainage == pytest.approx(129.9 + 12.0)
    assert found.excess == 2.0


def test_a_limit_that_is_shorter_than_a_vehicle_holds_too() -> None:
    offsets = np.array(scenario().consist.centre_offsets)
    # 5 m in the middle of the locomotive, which is 33 m long.
    assert watch((100.0, 8.0), (105.0, 12.0)).update(0, 119.0 - offsets, np.full(11, 10.0)) is not None


def test_an_overspeed_is_told_once_until_it_is_over() -> None:
    offsets = np.array(scenario().consist.centre_offsets)
    limit = watch((-1000.0, 10.0))
    excesses_kmh = [0.05, 0.15, 3.0, 0.05, -0.4, 0.2, -0.6, 0.05, 0.2, 1.0]
    begun = [
        limit.update(n, -offsets, np.full(11, 10.0 + kmh_to_mps(excess))) is not None
        for n, excess in enumerate(excesses_kmh)
    ]
    assert [n for n, begins in enumerate(begun) if begins] == [1, 8]
    assert limit.found.count == 2
    assert limit.found.worst is not None
    assert limit.found.worst.time_ns == 2
    assert limit.found.worst.excess == pytest.approx(kmh_to_mps(3.0))


def test_a_train_that_runs_backwards_is_watched_too() -> None:
    offsets = np.array(scenario().consist.centre_offsets)
    assert watch((-1000.0, 10.0)).update(0, -offsets, np.full(11, -11.0)) is not None


def test_a_train_that_is_too_fast_at_the_start_is_told_of_there() -> None:
    (event,) = told(scenario(initial_speed_kmh=44, max_duration_s=1))
    assert event.time_ns == 0
    assert event.text.endswith(": 44.0 km/h at 0.0 m, 4.0 over the limit of 40")


@pytest.mark.parametrize("overrides", [{"track__speed_limits": []}, {"initial_speed_kmh": 30}])
def test_a_train_within_the_limits_is_told_nothing_of(overrides: dict[str, object]) -> None:
    session = Session(scenario(**overrides))
    assert [event for event in of_kind(Event, *periods(session)) if event.kind is EventKind.OVERSPEED] == []
    summary = summarize_session(session)
    assert (summary.overspeeds.count, summary.overspeeds.worst) == (0, None)
    assert not any("over the limit" in line for line in summary_lines(summary))
    assert summary_json(summary)["largest_overspeed"] is None


def test_the_summary_of_a_run_and_of_its_recording_tell_the_same_overspeed(tmp_path: Path) -> None:
    run = scenario()
    session = Session(run, play_commands=True)
    for _ in periods(session):
        pass
    live = summarize_session(session)
    assert live.overspeeds.count == 1
    worst = live.overspeeds.worst
    assert worst is not None
    # The train slows down all the way: it is worst where it begins.
    assert worst.chainage == pytest.approx(100.0, abs=0.25)
    assert worst.limit == kmh_to_mps(30)
    (line,) = [line for line in summary_lines(live) if "over the limit" in line]
    assert (
        line.split()
        == (
            f"over the limit once, at most {worst.speed * 3.6:.1f} km/h where 30 are allowed, at 100 m after "
            f"{worst.time_ns / SECOND:.1f} s"
        ).split()
    )
    path = tmp_path / "run.mcap"
    (tmp_path / "train.yaml").write_text(TRAIN, "utf-8")
    assert main(["run", str(tmp_path / "train.yaml"), "-o", str(path), "--quiet"]) == 0
    with Recording(path) as recording:
        again = summarize_recording(recording, recorded_scenario(recording))
        events = [event for event in recording.events() if event.kind is EventKind.OVERSPEED]
    assert again.overspeeds == live.overspeeds
    assert [event.time_ns for event in events] == [worst.time_ns]


def test_the_shipped_descent_tells_of_a_train_that_ignores_its_limits() -> None:
    overrides = {
        "track.file": "daqin_descent_synthetic",
        "track.start_chainage_m": 32_900,
        "initial_speed_kmh": 64,
        "commands": [],
        "max_duration_s": 8,
    }
    (event,) = told(load_scenario("daqin_1_1_0", overrides))
    assert event.text.startswith("vehicle_001_SS4: 6")
    assert event.text.endswith("over the limit of 60")
