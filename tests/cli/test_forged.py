"""Recordings with fitting checksums that say impossible things: one line, and nothing raw on the terminal."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from haul_ros.recording.reader import Recording
from tests.recorded import forge

if TYPE_CHECKING:
    from tests.cli.conftest import Haul

COMMANDS = (
    ("info",), ("info", "--json"), ("replay",), ("analyze", "-o", "analysis"), ("recover", "-o", "recovered.mcap"),
    ("replay", "--set", "initial_speed_kmh=10", "-o", "again.mcap"),
)  # fmt: skip
MANY = json.dumps([f"slave_{n}" for n in range(20_000)])


@pytest.fixture
def recorded(haul: Haul) -> Haul:
    assert haul("run", "short.yaml", "-o", "run.mcap", "--set", "max_duration_s=1", "--quiet").status == 0
    return haul


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *(("locomotives", value) for value in ("[1, 2]", '["\\ud800"]', "[" * 20_000, MANY, '{"a": 1}', "", "null")),
        ("locomotives", '["master", "master"]'), ("locomotives", '["\\u001b[31m"]'),
        ("compression", None), ("compression", "gzip"), ("version", None), ("version", "1" * 5000),
        ("description", "x" * 400_000), ("scenario", "x" * 400_000), ("topic_prefix", "/a\n/b"), ("topic_prefix", ""),
        ("vehicles", "-1"), ("vehicles", "1e9"), ("vehicles", "9" * 5000), ("couplers", "3"), ("couplers", "\u0663"),
        ("time_step", "nan"), ("time_step", "-1"), ("time_step", "x"),
    ],
)  # fmt: skip
def test_a_description_that_cannot_be_is_refused_in_one_line_by_every_command(
    recorded: Haul, key: str, value: str | None
) -> None:
    def change(found: dict[str, str]) -> dict[str, str]:
        return {**found, key: value} if value is not None else {k: v for k, v in found.items() if k != key}

    forge(Path("run.mcap"), Path("forged.mcap"), description=change)
    for command, *arguments in COMMANDS:
        outcome = recorded(command, "forged.mcap", *arguments)
        assert (outcome.status, outcome.err.count("\n")) == (2, 1)
        assert f"description of the run: {key}" in outcome.err or f"has no {key}" in outcome.err
        assert not any(Path(name).exists() for name in ("analysis", "recovered.mcap", "again.mcap"))


@pytest.mark.parametrize("key", ["version", "scenario", "description"])
def test_control_characters_of_a_recording_do_not_reach_the_terminal(recorded: Haul, key: str) -> None:
    evil = "a\nb\x1b[31mc\r\x07"
    forge(
        Path("run.mcap"), Path("evil.mcap"), description=lambda found: found | {key: evil},
        topic=lambda topic: f"{topic}{evil}" if topic.endswith("/diagnostics") else topic,
    )  # fmt: skip
    Path("cut.mcap").write_bytes(Path("evil.mcap").read_bytes()[:-1])
    for command in (("info", "evil.mcap"), ("info", "cut.mcap"), ("analyze", "evil.mcap"), ("replay", "evil.mcap")):
        outcome = recorded(*command)
        assert outcome.status == (2 if "cut.mcap" in command else 0)
        assert not set(outcome.out + outcome.err) & set("\x1b\r\x07")
    assert r"a\nb\x1b[31mc" in recorded("info", "evil.mcap").out


def test_a_scenario_of_another_train_is_refused(recorded: Haul) -> None:
    def longer(scenario: bytes) -> bytes:
        assert scenario.count(b"count: 20") == 1
        return scenario.replace(b"count: 20", b"count: 60")

    forge(Path("run.mcap"), Path("forged.mcap"), scenario=longer)
    for command, *arguments in COMMANDS[2:4]:
        outcome = recorded(command, "forged.mcap", *arguments)
        assert (outcome.status, outcome.err.count("\n")) == (2, 1)
        assert "its scenario is of another train" in outcome.err


def test_messages_of_another_train_are_refused(recorded: Haul) -> None:
    def shorter(found: dict[str, str]) -> dict[str, str]:
        return found | {"vehicles": "20", "couplers": "19"}

    forge(
        Path("run.mcap"), Path("forged.mcap"), description=shorter,
        scenario=lambda text: text.replace(b"count: 20", b"count: 18"),
    )  # fmt: skip
    outcome = recorded("analyze", "forged.mcap")
    assert (outcome.status, outcome.err.count("\n")) == (2, 1)
    assert "a message of 21 names, expected 19" in outcome.err


def test_what_is_recovered_can_be_opened(recorded: Haul) -> None:
    assert recorded("recover", "run.mcap", "-o", "recovered.mcap").status == 0
    with Recording("recovered.mcap") as first, Recording("run.mcap") as second:
        assert first.metadata == second.metadata
