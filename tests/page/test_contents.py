"""What the page shows of a recording, beside what was recorded."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from haul_ros.cli.main import main
from haul_ros.model.sample import FloatArray
from haul_ros.page import contents
from haul_ros.page.contents import report_contents
from haul_ros.page.document import page
from haul_ros.recording.reader import Recording
from haul_ros.recording.trains import open_train
from haul_ros.units import NS_PER_S
from tests.bags import Train, write_mcap
from tests.page.test_packing import unpacked

TRAIN = """\
description: short train, emergency from 20 km/h
consist: [{vehicle: SS4, role: master}, {vehicle: C80, count: 9}, {vehicle: SS4, role: slave}]
coupler: paper_set_b
brakes: BRAKES
initial_speed_kmh: 20
max_duration_s: 3
radio: {default: {delay_s: 1.0}}
commands: [{at_s: 0.5, locomotive: master, emergency: true}, {at_s: 0.5, locomotive: slave_1, traction_kN: 10}]
"""

Record = Callable[[str], Path]


@pytest.fixture
def record(tmp_path: Path) -> Record:
    def run(brakes: str) -> Path:
        (tmp_path / "train.yaml").write_text(TRAIN.replace("BRAKES", brakes), "utf-8")
        path = tmp_path / "run.mcap"
        assert main(["run", str(tmp_path / "train.yaml"), "-o", str(path), "--quiet"]) == 0
        return path

    return run


def close(packed: dict[str, Any], values: FloatArray) -> None:
    """Half a step apart at most, but for rounding."""
    np.testing.assert_allclose(unpacked(packed), values, rtol=0.0, atol=0.5001 * packed["step"])


def test_quantities_are_those_of_the_recording_in_the_units_of_the_field(record: Record) -> None:
    path = record("pneumatic")
    with open_train(path) as source:
        found: Any = report_contents(source)
    with Recording(path) as recording:
        samples, pipe = recording.samples(), recording.pipe_pressure()
        extremes = recording.last_extremes().extremes
    assert pipe is not None
    times = np.frombuffer(zlib.decompress(base64.b64decode(found["time"])))
    assert times.tolist() == (samples.couplers.time_ns / NS_PER_S).tolist()
    quantities = found["quantities"]
    close(quantities["force"], samples.couplers.force / 1e3)
    close(quantities["stroke"], samples.couplers.stroke * 1e3)
    close(quantities["speed"], 3.6 * samples.vehicles.speed[:, [0, 5, 10]])
    close(quantities["cylinder"], samples.pressure.pressure / 1e3)
    close(quantities["pipe"], pipe.pressure / 1e3)
    assert found["peaks"]["compression"] == (extremes.compression / 1e3).tolist()
    assert found["peaks"]["tension_stroke"] == (extremes.tension_stroke * 1e3).tolist()
    assert found["train"]["locomotives"] == [{"name": "master", "vehicle": 0}, {"name": "slave_1", "vehicle": 10}]
    assert found["commands"] == [
        {"time": 0.5, "locomotive": "master", "kind": "emergency", "value": 1.0},
        {"time": 0.5, "locomotive": "slave_1", "kind": "traction", "value": 10e3},
    ]
    assert found["applied"]["slave_1"] == [[0.0, 0.0], [1.5, 1.0]]
    assert next(event["text"] for event in found["events"] if event["time"] == 1.5) == "slave_1: emergency latched"


def test_of_a_long_recording_each_instant_is_the_largest_of_several(
    record: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(contents, "MOST_INSTANTS", 10)
    path = record("paper_set_b")
    with open_train(path) as source:
        found: Any = report_contents(source)
    with Recording(path) as recording:
        force = recording.couplers().force / 1e3
    assert "pipe" not in found["quantities"]
    shown = unpacked(found["quantities"]["force"])
    assert shown.shape == (10, 10)
    assert np.abs(shown).max(axis=0) == pytest.approx(
        np.abs(force).max(axis=0), abs=found["quantities"]["force"]["step"]
    )
    notes = " ".join(found["notes"])
    assert f"{len(force)} samples of /haul." in notes
    assert "The samples are shown as 10, each" in notes


def test_no_text_can_end_the_data_or_the_title() -> None:
    text = page({"title": "</title></script><!--$style &amp;", "description": "</script>\u2028", "live": True})
    assert text.count("</script>") == 3  # data, uPlot, program
    assert "<title>&lt;/title&gt;&lt;/script&gt;&lt;!--$style &amp;amp;</title>" in text


def test_a_bag_of_another_recorder_is_shown_without_scenario_and_without_what_it_lacks(tmp_path: Path) -> None:
    rows = np.arange(20.0)[:, np.newaxis]
    force, speed = 1e3 * (rows + np.array([1.0, -2.0, 3.0])), 20.0 - rows + np.zeros(4)
    arrays = {"force": force, "stroke": force / 1e8, "stroke_rate": 0.0 * force, "speed": speed}
    chainage = np.array([100.0, 88.0, 76.0, 64.0]) + rows
    bag = Train(
        0.1 * rows[:, 0], chainage=chainage, brake_force=0.0 * speed, pressure=1e3 * speed, node="/yard/haul", **arrays
    )
    messages = [message for message in bag.messages() if not message.topic.endswith("/brake_cylinder_pressure")]
    write_mcap(tmp_path / "line_test.mcap", messages)
    with open_train(tmp_path / "line_test.mcap") as source:
        found: Any = report_contents(source)
    assert found["train"]["places"] == [0.0, 12.0, 24.0, 36.0]
    assert found["train"]["locomotives"] == []
    close(found["quantities"]["force"], force / 1e3)
    close(found["quantities"]["speed"], 3.6 * speed[:, [0, 1, 3]])
    assert np.isnan(unpacked(found["quantities"]["cylinder"])).all()
    assert found["peaks"]["compression"] == [20.0, 17.0, 22.0]
    assert found["tables"]["peaks"]["count"] == 3
    assert any("no scenario in it" in note for note in found["notes"])
    assert "<title>line_test.mcap" in page(found)
