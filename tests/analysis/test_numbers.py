"""Every number of a train: of a small file against paper, of a simulated run against the simulation's own."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from haul_ros.analysis.number_tables import coupler_table, number_tables, timing_table
from haul_ros.analysis.numbers import Numbers, Window, numbers_of
from haul_ros.analysis.scenarios import scenario_of
from haul_ros.analysis.train_layout import TrainLayout
from haul_ros.errors import RecordingError
from haul_ros.messages.encoder import TelemetryEncoder
from haul_ros.model.scenario import Scenario
from haul_ros.recording import run_file
from haul_ros.recording.bag import TrainBag
from haul_ros.recording.trains import open_train
from haul_ros.recording.writer import McapRecorder
from haul_ros.simulation.batch import periods
from haul_ros.simulation.session import Session
from tests.bags import Train, write_mcap

if TYPE_CHECKING:
    from tests.analysis.conftest import RecordedRun

# Three vehicles for 40 s at 2 Hz. Speeds: all at 20 m/s, from 10 s on 1 m/s less each second, at rest from 30 s on.
TIME = np.arange(0.0, 40.5, 0.5)
SPEED = np.clip(30.0 - TIME, 0.0, 20.0)
WAY = np.concatenate(([0.0], np.cumsum(0.25 * (SPEED[1:] + SPEED[:-1]))))  # exact for straight lines

# Coupler 1, in kN: in draft at -100 up to 9 s, through 0 at 10 s to +300 at 13 s (100 a second), down to 0 at 16 s,
# then at rest. Strokes in mm are a tenth of that on the way in, and a fifth less on the way out of compression.
FORCE_1 = np.interp(TIME, [9.0, 10.0, 13.0, 16.0], [-100.0, 0.0, 300.0, 0.0])
STROKE_1 = np.interp(TIME, [9.0, 10.0, 13.0, 16.0], [-10.0, 0.0, 30.0, 0.0])
RATE_1 = np.interp(TIME, [8.9, 9.0, 13.0, 13.1], [0.0, 10.0, 10.0, 0.0])
# Coupler 2: free until 20 s, then within 1 s to 2500 kN and back to 0 in 1 s, closing at 250 mm/s at the contact
FORCE_2 = np.interp(TIME, [20.0, 21.0, 22.0], [0.0, 2500.0, 0.0])
STROKE_2 = np.interp(TIME, [20.0, 21.0, 21.5, 22.0], [0.0, 80.0, 60.0, 0.0])
RATE_2 = np.interp(TIME, [19.0, 20.0, 21.0], [250.0, 250.0, 0.0])
# Cylinders from 10 s on: 100 kPa a second to 400 kPa, the second vehicle 1 s later, the third 2 s
PRESSURE = np.column_stack([np.clip(100e3 * (TIME - 10.0 - late), 0.0, 400e3) for late in range(3)])

TRAIN = Train(
    TIME,
    force=np.column_stack((FORCE_1, FORCE_2)) * 1e3,
    stroke=np.column_stack((STROKE_1, STROKE_2)) / 1e3,
    stroke_rate=np.column_stack((RATE_1, RATE_2)) / 1e3,
    chainage=np.column_stack([WAY - 12.0 * i for i in range(3)]),
    speed=np.column_stack([SPEED] * 3),
    brake_force=np.zeros((len(TIME), 3)),
    pressure=PRESSURE,
    numbers={
        "master/applied_brake": [(0.0, 0.0), (10.0, 0.5)],
        "slave_1/applied_brake": [(0.0, 0.0), (11.5, 0.5)],
    },
)


@pytest.fixture(scope="module")
def by_hand(tmp_path_factory: pytest.TempPathFactory) -> Numbers:
    with open_train(write_mcap(tmp_path_factory.mktemp("hand") / "hand.mcap", TRAIN.messages())) as source:
        return numbers_of(source, None)


def test_peaks_by_hand(by_hand: Numbers) -> None:
    peaks = by_hand.couplers.peaks
    assert peaks.compression.tolist() == [300e3, 2500e3]
    assert peaks.compression_time.tolist() == [13.0, 21.0]
    assert peaks.tension.tolist() == [100e3, 0.0]
    assert peaks.tension_time[0] == 0.0
    assert peaks.compression_stroke.tolist() == [0.030, 0.080]
    assert peaks.tension_stroke.tolist() == [0.010, 0.0]


def test_run_ins_by_hand(by_hand: Numbers) -> None:
    found = by_hand.couplers.contacts
    # The draft of coupler 1 was there before the first sample; both come into compression once
    assert found.coupler.tolist() == [0, 1]
    assert found.run_in.tolist() == [True, True]
    assert found.time.tolist() == [10.0, 20.0]
    assert found.speed == pytest.approx([0.010, 0.250])
    assert found.peak.tolist() == [300e3, 2500e3]


def test_reversals_and_times_above_the_limit_by_hand(by_hand: Numbers) -> None:
    couplers = by_hand.couplers
    assert couplers.to_buff.tolist() == [1, 0]
    assert couplers.to_draft.tolist() == [0, 0]
    # 2500 kN/s up and down: above 2250 for 0.1 s on either side of the peak
    assert couplers.above_compression == pytest.approx([0.0, 0.2])
    assert couplers.above_tension.tolist() == [0.0, 0.0]


def test_work_by_hand(by_hand: Numbers) -> None:
    # Coupler 1 gives back -100 kN * 10 mm / 2 = 500 J of its draft, takes 300 kN * 30 mm / 2 = 4500 J, gives them back.
    # Coupler 2 takes 2500 kN * 80 mm / 2 = 100 kJ; gives back (2500 + 1250)/2 * 20 mm + 1250/2 * 60 mm = 75 kJ.
    assert by_hand.couplers.work_taken == pytest.approx([-500.0, 25e3], rel=1e-9)
    assert by_hand.couplers.dissipated is None  # without the curves of the gears


def test_fatigue_by_hand(by_hand: Numbers) -> None:
    spectrum = by_hand.couplers.spectrum
    assert spectrum is not None
    # Coupler 1: half a cycle of 400 kN, half one of 300 kN; coupler 2: two halves of 2500 kN
    assert spectrum.cycles.tolist() == [1.0, 1.0]
    assert spectrum.largest_range == pytest.approx([400e3, 2500e3])
    expected = [(0.5 * 400.0**5 + 0.5 * 300.0**5) ** 0.2 * 1e3, 2500e3]
    assert spectrum.equivalent_range() == pytest.approx(expected)


def test_the_stop_by_hand(by_hand: Numbers) -> None:
    train = by_hand.train
    assert train.motion.standing_since == 30.0
    assert train.motion.distance == pytest.approx(200.0 + 200.0)
    (stop,) = train.stops
    assert (stop.begin, stop.demand) == (10.0, 0.5)
    assert stop.initial_speed == 20.0
    assert stop.stopping_time == 20.0
    assert stop.stopping_distance == pytest.approx(200.0)
    assert stop.mean_deceleration == pytest.approx(1.0)
    assert stop.largest_deceleration == pytest.approx(1.0)


def test_brake_timing_and_radio_by_hand(by_hand: Numbers) -> None:
    (filling,) = by_hand.train.fillings
    assert filling.pressure.tolist() == [400e3] * 3
    # 40 kPa after 0.4 s is between samples 10.0 (0) and 10.5 (50 kPa); 360 kPa after 3.6 s
    assert filling.times == pytest.approx(np.array([[0.4, 1.4, 2.4], [3.6, 4.6, 5.6]]))
    (delay,) = by_hand.train.radio
    assert (delay.slave, delay.time, delay.demand) == ("slave_1", 10.0, 0.5)
    assert delay.delay == pytest.approx(1.5)


def test_what_the_samples_are_and_what_is_left_out(by_hand: Numbers) -> None:
    assert (by_hand.samples, by_hand.begin, by_hand.end) == (81, 0.0, 40.0)
    assert (by_hand.period, by_hand.largest_gap) == (0.5, 0.5)
    assert by_hand.train.energy is None
    (note,) = by_hand.notes
    assert note.startswith("no scenario in it: ")


def test_a_window_counts_from_its_begin_to_its_end(tmp_path: Path) -> None:
    with open_train(write_mcap(tmp_path / "hand.mcap", TRAIN.messages())) as source:
        found = numbers_of(source, None, Window(12.0, 20.5))
        with pytest.raises(RecordingError, match=r"holds no /haul/couplers from 50 to 60 s: nothing was run"):
            numbers_of(source, None, Window(50.0, 60.0))
    assert (found.begin, found.end, found.samples) == (12.0, 20.5, 18)
    assert found.couplers.peaks.compression.tolist() == [300e3, 1250e3]
    assert found.train.motion.distance == pytest.approx(0.5 * 18.0**2 - 0.5 * 9.5**2)
    assert found.couplers.contacts.coupler.tolist() == [1]  # the other began before
    assert not found.train.stops
    assert not found.train.radio


def test_tables_have_units_in_the_names_of_their_columns(by_hand: Numbers) -> None:
    vehicles = ("vehicle_001_C80", "vehicle_002_C80", "vehicle_003_C80")
    layout = TrainLayout(vehicles, ("coupler_001", "coupler_002"), np.ones(2, np.bool_))
    tables = number_tables(by_hand, layout, couplers=[1])
    assert set(tables) == {
        "peaks", "run_ins", "train", "rainflow", "brake_applications", "brake_timing", "radio_delays",
    }  # fmt: skip
    peaks = {name: values[0] for name, values in tables["peaks"].items()}
    assert len(tables["peaks"]["coupler"]) == 1
    assert peaks["coupler"] == "coupler_002"
    assert (peaks["vehicle_before"], peaks["vehicle_behind"]) == vehicles[1:]
    assert peaks["position"] == pytest.approx(2 / 3)
    assert peaks["max_compression_kN"] == 2500.0
    assert peaks["max_compression_stroke_mm"] == pytest.approx(80.0)
    assert peaks["time_above_limit_in_buff_s"] == pytest.approx(0.2)
    assert peaks["run_ins"] == 1
    assert peaks["fastest_run_in_m_per_s"] == pytest.approx(0.25)
    assert peaks["work_taken_kJ"] == pytest.approx(25.0)
    assert peaks["damage_equivalent_range_m5_kN"] == pytest.approx(2500.0)
    assert tables["rainflow"] == {
        "coupler": ["coupler_002"], "range_from_kN": [2500.0], "range_to_kN": [2550.0], "cycles": [1.0],
    }  # fmt: skip
    assert timing_table(by_hand.train.fillings, layout)["place"] == ["head", "mid", "tail"]
    assert tables["brake_timing"]["time_to_90_percent_s"] == pytest.approx([3.6, 4.6, 5.6])
    units = ("_kN", "_mm", "_s", "_m_per_s", "_m_per_s2", "_kJ", "_kPa", "_kmh", "_m")
    counts = {
        "coupler", "vehicle_before", "vehicle_behind", "position", "reversals_to_buff", "reversals_to_draft", "run_ins",
        "run_outs", "rainflow_cycles", "cycles", "kind", "demand", "vehicle", "place", "slave", "samples",
    }  # fmt: skip
    for name, table in tables.items():
        for column in table:
            assert column in counts or column.endswith(units), (name, column)


def test_numbers_of_a_recorded_run_are_those_of_the_simulation(run: RecordedRun) -> None:
    with open_train(run.path) as source:
        scenario = scenario_of(source)
        assert scenario is not None
        found = numbers_of(source, scenario)
    own, session = run.session.extremes(), run.session
    best = found.couplers.best
    for name in ("compression", "compression_time", "tension", "tension_time", "compression_stroke", "tension_stroke"):
        np.testing.assert_array_equal(getattr(best, name), getattr(own, name))
    assert found.train.motion.distance == session.travelled
    assert session.stop_time is not None
    assert found.train.motion.standing_since is not None
    assert 0.0 <= found.train.motion.standing_since - session.stop_time < 0.02
    # What samples alone tell is less than what every time step does, but not by much at 50 Hz
    assert (found.couplers.peaks.compression <= best.compression).all()
    np.testing.assert_allclose(found.couplers.peaks.compression, best.compression, rtol=0.02, atol=2e3)
    assert {delay.delay for delay in found.train.radio} == {1.0}
    table = coupler_table(found.couplers, TrainLayout.of(scenario.consist))
    assert table["dissipated_energy_kJ"]
    assert sum(table["dissipated_energy_kJ"]) * 1e3 == pytest.approx(session.energy().gear_dissipated, rel=0.05)  # type: ignore[arg-type]


def test_extremes_that_are_older_than_the_last_sample_are_made_up_for(
    scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of an unfinished file the extremes are those of the last full second."""
    monkeypatch.setattr(run_file, "CHUNK_SIZE", 10_000)
    session, encoder = Session(scenario, play_commands=True), TelemetryEncoder(scenario.consist)
    with McapRecorder(tmp_path / "run.mcap", scenario, encoder.channels, when_full="block") as recorder:
        for log in islice(periods(session), 180):
            recorder.put(encoder.messages(log), 0)
    data = (tmp_path / "run.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(data[: len(data) // 2])
    with open_train(tmp_path / "cut.mcap") as source:
        extremes = source.final_extremes()
        found = numbers_of(source, scenario_of(source))
    assert extremes is not None
    assert extremes.time_ns / 1e9 < found.end
    assert (found.couplers.best.compression >= found.couplers.peaks.compression).all()
    assert (found.couplers.best.compression > extremes.extremes.compression).any()
    assert found.train.energy is not None


def test_a_bag_of_couplers_alone_gives_what_they_tell(tmp_path: Path) -> None:
    couplers = [message for message in TRAIN.messages() if message.topic.endswith("/couplers")]
    with open_train(write_mcap(tmp_path / "couplers.mcap", couplers)) as source:
        layout = TrainLayout.from_names(source)
        found = numbers_of(source, scenario_of(source))
    assert layout.vehicles == ("vehicle_001", "vehicle_002", "vehicle_003")
    assert found.couplers.peaks.compression.tolist() == [300e3, 2500e3]
    assert not len(found.train.motion.time)
    assert not found.train.stops
    assert [note.split(":")[0] for note in found.notes] == [
        "no scenario in it",
        "no /haul/vehicles in it",
        "no /haul/master/applied_brake in it",
    ]
    assert "distance_m" not in number_tables(found, layout)["train"]


def test_an_unfinished_recording_of_another_train_than_its_scenario_is_refused(
    scenario: Scenario, run: RecordedRun
) -> None:
    with open_train(run.path) as source:
        bag = TrainBag(run.path)
        assert bag.scenario_document == source.scenario_document
        assert scenario_of(bag) is not None
        bag.couplers = bag.couplers[:-1]
        with pytest.raises(RecordingError, match="its scenario is of another train than its samples"):
            scenario_of(bag)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"force": (7, 1, np.nan)}, "coupler_002 at 3.500 s: force is nan, expected at most 1e+08"),
        ({"stroke": (3, 0, -np.inf)}, "coupler_001 at 1.500 s: stroke is -inf, expected at most 1e+06"),
        ({"speed": (80, 2, 1e5)}, "vehicle_003_C80 at 40.000 s: speed is 100000, expected at most 10000"),
        ({"pressure": (0, 0, 1e300)}, "vehicle_001_C80 at 0.000 s: pressure is 1e+300, expected at most 1e+09"),
    ],
    ids=str,
)
def test_samples_that_cannot_be_are_told_with_their_place(
    change: dict[str, tuple[int, int, float]], told: str, tmp_path: Path
) -> None:
    ((name, (row, column, value)),) = change.items()
    values = getattr(TRAIN, name).copy()
    values[row, column] = value
    written = write_mcap(tmp_path / "bag.mcap", replace(TRAIN, **{name: values}).messages())
    with open_train(written) as source, pytest.raises(RecordingError) as caught:
        numbers_of(source, None)
    assert str(caught.value) == f"{written}: {told}"


def test_samples_out_of_order_are_told(tmp_path: Path) -> None:
    messages = TRAIN.messages()
    vehicles = [i for i, message in enumerate(messages) if message.topic.endswith("/vehicles")]
    first, second = vehicles[5], vehicles[9]
    messages[first], messages[second] = messages[second], messages[first]
    written = write_mcap(tmp_path / "bag.mcap", messages)
    with (
        open_train(written) as source,
        pytest.raises(RecordingError, match="samples of vehicles are not in order of time"),
    ):
        numbers_of(source, None)


def test_changed_bytes_give_numbers_or_one_line(tmp_path: Path) -> None:
    few = replace(TRAIN, **{name: getattr(TRAIN, name)[15:45:2] for name in ARRAYS})
    data = write_mcap(tmp_path / "bag.mcap", few.messages(), chunked=False).read_bytes()
    random, told = np.random.default_rng(3), 0
    for _ in range(200):
        changed = bytearray(data)
        for place in random.integers(0, len(data), random.choice([1, 3])):
            changed[place] = int(random.choice([0, 1, 0x7F, 0x80, 0xFF]))
        (tmp_path / "changed.mcap").write_bytes(changed)
        try:
            with open_train(tmp_path / "changed.mcap") as source:
                number_tables(numbers_of(source, None), TrainLayout.from_names(source))
        except RecordingError as error:
            assert "\n" not in str(error)
            told += 1
    assert 0 < told < 200


ARRAYS = ("time", "force", "stroke", "stroke_rate", "chainage", "speed", "brake_force", "pressure")
