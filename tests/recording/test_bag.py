"""Trains in bags that other programs have written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionMode

from haul_ros.errors import RecordingError
from haul_ros.recording import bag, batches
from haul_ros.recording.series import Samples
from haul_ros.recording.train_source import TrainSource
from haul_ros.recording.trains import open_train
from tests.bags import WALL, BagMessage, Train, other_messages, write_bag, write_mcap, write_split_bag


@pytest.fixture
def train() -> Train:
    """Three vehicles for 12 s at 100 Hz, all numbers different; the master applies its brake at 3 s."""
    random, n = np.random.default_rng(1), 1200
    first, second, third = (random.normal(size=(n, 2)) for _ in range(3))
    fourth, fifth, sixth, seventh = (random.normal(size=(n, 3)) for _ in range(4))
    return Train(
        np.arange(n) / 100.0,
        first,
        second,
        third,
        fourth,
        fifth,
        sixth,
        seventh,
        numbers={
            "master/applied_brake": [(0.0, 0.0), (3.0, 0.5)],
            "slave_1/applied_brake": [(0.0, 0.0), (4.25, 0.5)],
        },
        late=0.002,
    )


def _whole(source: TrainSource) -> Samples:
    blocks = list(source.blocks())
    return Samples(
        *(
            replace(
                parts[0],
                **{
                    name: np.concatenate([getattr(part, name) for part in parts])
                    for name in parts[0].__dataclass_fields__
                    if name != "names"
                },
            )
            for parts in zip(*blocks, strict=True)
        )
    )


def check(path: Path, train: Train, node: str | None = None) -> None:
    """All of the train is read from a bag, at simulation time."""
    with open_train(path, node) as source:
        assert source.couplers == ("coupler_001", "coupler_002")
        assert source.vehicles == ("vehicle_001_C80", "vehicle_002_C80", "vehicle_003_C80")
        assert (source.node, source.locomotives) == (train.node, ("master", "slave_1"))
        assert source.samples == len(train.time)
        couplers, vehicles, pressure = _whole(source)
        applied = source.scalars("slave_1/applied_brake")
        assert not len(source.scalars("slave_2/applied_brake").values)
        assert source.final_extremes() is None
        assert not list(source.air())
    stamps = np.rint(train.time * 1e9).astype(np.int64)
    for series in (couplers, vehicles, pressure):
        np.testing.assert_array_equal(series.time_ns, stamps)
    np.testing.assert_array_equal(couplers.force, train.force)
    np.testing.assert_array_equal(couplers.stroke, train.stroke)
    np.testing.assert_array_equal(couplers.stroke_rate, train.stroke_rate)
    np.testing.assert_array_equal(vehicles.chainage, train.chainage)
    np.testing.assert_array_equal(vehicles.speed, train.speed)
    np.testing.assert_array_equal(vehicles.brake_force, train.brake_force)
    np.testing.assert_array_equal(pressure.pressure, train.pressure)
    assert applied.values.tolist() == [0.0, 0.5]
    np.testing.assert_allclose(applied.time_ns, [0, 4.25e9], atol=3)  # between the stamps of two couplers


BAGS: dict[str, Callable[[Path, list[BagMessage]], Path]] = {
    "chunks": lambda folder, messages: write_mcap(folder / "bag.mcap", messages),
    "no chunks": lambda folder, messages: write_mcap(folder / "bag.mcap", messages, chunked=False),
    "unfinished": lambda folder, messages: write_mcap(folder / "bag.mcap", messages, finished=False),
    "folder, mcap": lambda folder, messages: write_bag(folder / "bag", messages, "mcap"),
    "folder, sqlite3": lambda folder, messages: write_bag(folder / "bag", messages, "sqlite3"),
    "file, sqlite3": lambda folder, messages: next(write_bag(folder / "bag", messages, "sqlite3").glob("*.db3")),
    "files compressed": lambda folder, messages: write_bag(folder / "bag", messages, "sqlite3", CompressionMode.FILE),
    "messages compressed": lambda folder, messages: write_bag(
        folder / "bag", messages, "sqlite3", CompressionMode.MESSAGE
    ),
    "split into 12": lambda folder, messages: write_split_bag(folder / "bag", messages, 12),
}


@pytest.mark.parametrize("kind", BAGS)
def test_every_kind_of_bag_gives_the_whole_train(kind: str, train: Train, tmp_path: Path) -> None:
    messages = sorted([*train.messages(), *other_messages(500)], key=lambda message: message.log_time)
    check(BAGS[kind](tmp_path, messages), train)


@pytest.mark.parametrize("changes", [{"frame": "haul"}, {"little_endian": False}], ids=str)
def test_messages_that_are_laid_out_otherwise_are_read_one_by_one(
    changes: dict[str, object], train: Train, tmp_path: Path
) -> None:
    other = replace(train, **changes)  # type: ignore[arg-type]
    check(write_mcap(tmp_path / "bag.mcap", other.messages()), other)


def test_a_train_is_chosen_by_its_node(train: Train, tmp_path: Path) -> None:
    second = replace(train, node="/yard/train_b/haul", force=train.force + 1.0)
    messages = sorted([*train.messages(), *second.messages()], key=lambda message: message.log_time)
    written = write_mcap(tmp_path / "two.mcap", messages)

    check(written, train, "/haul")
    check(written, second, "/yard/train_b/haul")
    with pytest.raises(RecordingError, match=r"holds 2 trains, choose one by --node: /haul, /yard/train_b/haul$"):
        check(written, train)
    with pytest.raises(RecordingError, match=r"two.mcap: no train of node /haul_3, it has /haul, /yard/train_b/haul$"):
        check(written, train, "/haul_3")


def test_a_run_after_a_reset_is_chosen_by_its_number(train: Train, tmp_path: Path) -> None:
    # 20 s later by the recorder's clock the node is reset, and simulation time begins anew
    again = [m._replace(log_time=m.log_time + 20 * 10**9) for m in replace(train, force=-train.force).messages()]
    written = write_mcap(tmp_path / "reset.mcap", [*train.messages(), *again])

    for run, force in ((1, train.force), (2, -train.force)):
        with open_train(written, run=run) as source:
            np.testing.assert_array_equal(_whole(source).couplers.force, force)
            assert source.scalars("master/applied_brake").values.tolist()[-2:] == [0.0, 0.5]
            np.testing.assert_allclose(source.scalars("master/applied_brake").time_ns[-1], 3e9, atol=3)
    with pytest.raises(RecordingError, match=r"holds 2 runs, its node was reset: of 1200, 1200 samples; choose one by"):
        check(written, train)
    with pytest.raises(RecordingError, match="no run 3, it has 2"), open_train(written, run=3):
        pass


def test_a_bag_recorded_slower_than_real_time_has_simulation_times(train: Train, tmp_path: Path) -> None:
    slow = [m._replace(log_time=WALL + 3 * (m.log_time - WALL)) for m in train.messages()]
    with open_train(write_mcap(tmp_path / "slow.mcap", slow)) as source:
        assert _whole(source).pressure.time_ns[600] == 6_000_000_000
        np.testing.assert_allclose(source.scalars("slave_1/applied_brake").time_ns[-1], 4.25e9, atol=3)


@pytest.mark.parametrize("part", [0.05, 0.3, 0.7, 0.9])
def test_a_file_that_is_cut_off_gives_what_lies_before(part: float, train: Train, tmp_path: Path) -> None:
    whole = write_mcap(tmp_path / "whole.mcap", train.messages()).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: int(part * len(whole))])

    with open_train(cut) as source:
        assert source.notes[0].startswith("cut.mcap: unfinished or cut off")
        found = _whole(source)
        count = len(found.couplers.time_ns)
        assert part - 0.1 < count / len(train.time) <= min(1.0, part + 0.05)
        np.testing.assert_array_equal(found.couplers.force, train.force[:count])


def test_damage_within_a_finished_file_is_told(train: Train, tmp_path: Path) -> None:
    written = write_mcap(tmp_path / "damaged.mcap", train.messages())
    data = bytearray(written.read_bytes())
    data[len(data) // 3] ^= 0xFF
    written.write_bytes(data)

    with pytest.raises(RecordingError, match=r"damaged\.mcap: damaged recording"):
        check(written, train)


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("empty.mcap", b"", "empty, expected a recording of haul_ros, or a bag"),
        ("text.mcap", b"time,force\n0,1\n", "not an MCAP file, expected a recording of haul_ros, or a bag"),
        ("broken.db3", b"SQLite format 3\0" + bytes(5000), "damaged recording"),
        ("header.mcap", b"\x89MCAP0\r\n", "holds no train (header.mcap: unfinished or cut off"),
    ],
)
def test_other_files_are_refused_in_one_line(name: str, data: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(RecordingError) as caught, open_train(tmp_path / name):
        pass
    assert str(caught.value).startswith(f"{tmp_path / name}: {message}")
    assert "\n" not in str(caught.value)


def test_a_bag_without_a_train_and_a_folder_without_a_bag_are_refused(tmp_path: Path) -> None:
    written = write_mcap(tmp_path / "bag.mcap", other_messages(5))
    with pytest.raises(RecordingError, match=r"holds no train, expected a topic \.\.\./couplers"), open_train(written):
        pass
    (tmp_path / "folder").mkdir()
    with pytest.raises(RecordingError, match=r"a folder without files of a bag"), open_train(tmp_path / "folder"):
        pass
    with pytest.raises(RecordingError, match=r"missing.mcap: no such file"), open_train(tmp_path / "missing.mcap"):
        pass


def test_messages_of_other_names_are_told(train: Train, tmp_path: Path) -> None:
    longer = replace(train, force=np.ones((1200, 3)), stroke=np.ones((1200, 3)), stroke_rate=np.ones((1200, 3)))
    written = write_mcap(tmp_path / "bag.mcap", [*train.messages()[:300], *longer.messages()[300:]])
    with pytest.raises(RecordingError, match=r"a message of other names \(3\) than the first \(2\)"):
        check(written, train)


def _read_all(path: Path) -> None:
    with open_train(path) as source:
        for _ in source.blocks():
            pass
        for _ in source.air():
            pass
        source.events()
        source.final_extremes()
        for locomotive in source.locomotives:
            source.scalars(f"{locomotive}/applied_brake")


@pytest.mark.parametrize("storage", ["no chunks", "unfinished", "folder, sqlite3"])
def test_changed_bytes_are_told_in_one_line_or_change_numbers_alone(storage: str, train: Train, tmp_path: Path) -> None:
    few = replace(train, **{name: getattr(train, name)[:12] for name in _ARRAYS})
    path = BAGS[storage](tmp_path, few.messages())
    file = next(path.glob("*.db3")) if path.is_dir() else path
    data, random = file.read_bytes(), np.random.default_rng(7)
    for _ in range(150):
        changed = bytearray(data)
        for place in random.integers(0, len(data), random.choice([1, 2, 5])):
            changed[place] = int(random.choice([0, 1, 0x7F, 0x80, 0xFF]))
        file.write_bytes(changed)
        try:
            _read_all(path)
        except RecordingError as error:
            assert "\n" not in str(error)


_ARRAYS = ("time", "force", "stroke", "stroke_rate", "chainage", "speed", "brake_force", "pressure")


@pytest.mark.parametrize(
    ("name", "most", "told"),
    [
        ("MOST_SAMPLES", 1000, "more than 1000 samples of couplers, expected fewer"),
        ("MOST_ENTRIES", 3, "more than 3 numbers and events, expected fewer"),
        ("MOST_KEPT", 100, "more than 100 bytes of events and names, expected fewer"),
    ],
)
def test_more_than_fits_into_memory_is_refused(
    name: str, most: int, told: str, train: Train, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bag, name, most)
    with pytest.raises(RecordingError, match=told), open_train(write_mcap(tmp_path / "bag.mcap", train.messages())):
        pass


def test_a_message_longer_than_any_train_is_refused(
    train: Train, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batches, "LARGEST_STATE", 100)
    with pytest.raises(RecordingError, match=r"/haul/couplers: a message of [0-9]+ bytes, expected at most 100"):
        _read_all(write_mcap(tmp_path / "bag.mcap", train.messages()))
